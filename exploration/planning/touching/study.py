"""The face under the pad, studied: a place felt, two strokes to the edges, and what the contacts say taken in."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exploration.control.sighting import Sighting
from exploration.control.track_surface import Stroke
from exploration.devices.guard import Collision, Fault, OverPress
from exploration.planning.faces.attribution import (
    AttributionConfig,
    joined,
    known_face,
    name_loose,
    take_in,
    without,
)
from exploration.planning.faces.faceted import rounded
from exploration.planning.faces.low_rims import whole_rims
from exploration.planning.faces.scatter import scatter_of
from exploration.planning.faces.uprighted import uprighted
from exploration.planning.touching.bumps import bump_of
from exploration.planning.touching.findings import Findings
from exploration.planning.touching.pad import Pad
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.fit import Fit, fit
from primitives.patch_graph import Face, PatchGraph

_SLANT, _STRAIGHT = 0.25, 0.98  # cosine from and up to which a stroke goes slanting to a side of the housing
_LAIN, _FLUSH = 1.0, 0.97  # [mm] between a pad that lies on a face and that; least cosine between the two
_NARROW = (0.1, 0.02)  # [mm, rad] of places on a face that was only looked at
_FEW = 8  # such places of one look
_WORTH_CENTERING = 4.0  # [mm] of a stroke, after which the pad goes back to the middle


@dataclass(frozen=True)
class Wall:
    """Where a stroke met something that stands up from its face."""

    point: Floats  # (3,) [mm] at the pad's leading end, on the face
    heading: Floats  # (3,) the way of the stroke
    normal: Floats  # (3,) outward, of the face
    pose: Floats  # (4, 4) world_from_sensor where the pad was stopped
    half: Floats  # (2,) [mm] half the width of the housing that was stopped, along the pad's x and y
    stopped: bool = True  # by force or by the housing; else it was only seen to rise ahead

    def readings(self) -> list[Wall]:
        """What it may be: across the stroke; of one that went slanting, along a side of the housing instead."""
        sides = [way for axis in self.pose[:3, :2].T for way in (axis, -axis)]
        ahead = [way for way in sides if _SLANT < way @ self.heading < _STRAIGHT]
        ahead.sort(key=lambda way: -float(way @ self.heading))
        return [self._across(way) for way in ahead] or [self]

    def lay_on_one_of(self, faces: Sequence[Face]) -> bool:
        """Whether the pad lay on a known face when it was stopped: on an edge nobody knows which way it leans."""
        at = self.pose[None, :3, 3]
        for face in faces:
            if isinstance(face.fit, Fit) and abs(float(face.fit.shape.signed_distance(at)[0])) < _LAIN:
                side = 1.0 if face.fit.convex else -1.0
                if side * float(face.fit.shape.normals(at)[0] @ self.normal) > _FLUSH:
                    return True
        return False

    def _across(self, way: Floats) -> Wall:
        """Across another (3,) way, at the end of the housing there."""
        far = float(np.abs(self.pose[:3, :2].T @ way) @ self.half)
        return replace(self, point=self.pose[:3, 3] + far * way, heading=way)


_MORE = 1.2  # times the contacts, from which it is asked again how far they agree
_STEADY = 0.75, 1.25  # times what is believed of their scatter, between which that stays


class Study:
    """What the pad's contacts and sightings become."""

    def __init__(self, pad: Pad, found: Findings, config: AttributionConfig) -> None:
        self.pad, self.found, self.config = pad, found, config
        self.loose = Contacts.of([])  # what no face explains yet
        self._weighed = 0  # contacts when it was last asked how far they agree
        self._left_loose = 0  # contacts of which no face could be made
        self.seen: list[tuple[Sighting, int]] = []  # edges, each with the face that it was seen from
        self.walls: list[Wall] = []

    def face_here(self) -> int | None:
        """Stroke the face under the pad along two axes, to its edges; the face's id."""
        if self.pad.on_told():
            return None
        first = self.pad.feel()
        known = known_face(self.found.graph, first, self.config)
        if known is not None:
            self.found.graph = joined(self.found.graph, first, known, self.config)
            return known
        strokes: list[Contacts] = [first]
        edges: list[Sighting] = self.pad.sightings()
        axes = self.pad.axes()
        try:
            for heading in (axes[:, 0], axes[:, 1]):
                self._stroke_across(heading, strokes, edges)
        except (OverPress, Collision) as error:
            self.found.warnings.append(str(error))
            strokes.append(error.kept)
        face = self.take_in(Contacts.concatenate(strokes))
        if face is None:
            self.found.warnings.append("a touch named no face by itself; its contacts are kept")
            return None
        self.seen.extend((edge, face) for edge in edges)
        return face

    def take_in(self, contacts: Contacts) -> int | None:
        """Give contacts to the faces that explain them; the face that most of them lie on."""
        before = {face.id for face in self.found.graph.faces}
        taken = take_in(self.found.graph, self.loose, contacts, self.config)
        self._keep(taken.graph)
        self.loose = taken.loose
        self.found.hollow |= taken.hollow
        self._rename(taken.gone)
        gone = self._weigh()
        home = gone.get(taken.home, taken.home) if taken.home is not None else None
        if {face.id for face in self.found.graph.faces} <= before:
            return home
        self.found.graph, facets = rounded(self.found.graph)
        self._rename(facets)
        return facets.get(home, home) if home is not None else None

    def _weigh(self) -> dict[int, int]:
        """Believe contacts as far as those of one face agree; the faces that turn out to be others."""
        count = len(self.loose) + sum(len(face.contacts) for face in self.found.graph.faces)
        if count < _MORE * self._weighed:
            return {}
        self._weighed = count
        graph, scatter = self.found.graph, scatter_of(self.found.graph, self.loose)
        believed = graph.options.scatter
        if _STEADY[0] * believed <= scatter <= _STEADY[1] * believed:
            return {}
        self.found.graph, gone = graph.scattered(scatter).merge_faces()
        self._rename(gone)
        return gone

    def narrow_face(self, places: Floats, normal: Floats, looks: int = 1) -> int | None:
        """The id of a flat face at (n, 3) places that looks (3,) out, too narrow for a pad to lie on.

        The pad has pressed it at the attitude that it came at, and a model of what it saw tells the places; None
        where they are on no plane.  One look errs as one: a few places of each stand for all.
        """
        some = places[np.unique(np.linspace(0, len(places) - 1, _FEW * looks).astype(np.int64))]
        contacts = Contacts.of(
            some,
            np.broadcast_to(normal, some.shape),
            *_NARROW,
            touch=self.pad.guard.cost.touches,
            stroke=self.pad.guard.cost.strokes,
            sensor=self.pad.guard.active,
        )
        made, graph = fit("plane", contacts), self.found.graph
        if not isinstance(made, Fit) or made.rms > _NARROW[0]:
            return None
        home = known_face(graph, contacts, self.config)
        if home is not None:
            self.found.graph = joined(graph, contacts, home, self.config)
            return home
        self.found.graph = replace(graph, faces=(*graph.faces, Face(graph.next_id, made, contacts)))
        return graph.next_id

    def back_off(self, fault: Fault) -> None:
        """Warn of a fault that ended a move, note where, and take in what its stroke had felt until then."""
        self.found.warnings.append(str(fault))
        if (bump := bump_of(fault)) is not None:
            self.pad.bumps.append(bump)
        if len(fault.kept):
            self.take_in(fault.kept)

    def name_loose(self) -> bool:
        """Whether what no face explained makes faces after all, now that there is more of it."""
        self.found.graph, rims = whole_rims(self.found.graph)
        self._rename(rims)
        if len(self.loose) == self._left_loose and not rims:
            return False
        taken = name_loose(self.found.graph, self.loose, self.config)
        before = {face.id for face in self.found.graph.faces}
        self._keep(taken.graph)
        self.loose, self._left_loose = taken.loose, len(taken.loose)
        self._rename(taken.gone)
        return bool(rims) or bool({face.id for face in taken.graph.faces} - before)

    def merge(self) -> bool:
        """Whether faces that grew since they were last compared turn out to be one."""
        self.found.graph, gone = self.found.graph.merge_faces()
        self._rename(gone)
        return bool(gone)

    def _rename(self, gone: dict[int, int]) -> None:
        """Call faces that turned out to be others by the ids of those, wherever an edge or a rim is on one."""
        if not gone:
            return
        self.seen = [(sighting, gone.get(own, own)) for sighting, own in self.seen]
        self.found.rename(gone)

    def _keep(self, graph: PatchGraph) -> None:
        """Round faces that a few contacts made stand upright on the others, where those agree."""
        self.found.graph = graph if self.config.convex else uprighted(graph, self.found.graph)

    def reconsider(self) -> None:
        """Make faces of what was held against a convex object: its steps contradict each other's planes."""
        self.config = replace(self.config, convex=False)
        for touch in np.unique(self.loose.touch):
            held = self.loose.select(self.loose.touch == touch)
            self.loose = without(self.loose, held)
            self.take_in(held)

    def note_wall(self, stroke: Stroke) -> bool:
        """Whether a stroke was ended by what stands up ahead of it, which is remembered."""
        if stroke.ended not in ("wall", "concavity") or stroke.heading is None:
            return False
        pose = self.pad.guard.world_from_sensor if stroke.met is None else stroke.met
        half = 0.5 * float(np.abs(stroke.heading) @ np.asarray(self.pad.size))
        way = pose[:3, :2] @ stroke.heading
        wide = np.abs(self.pad.tool.high[:2])
        aside = float(np.abs(stroke.heading[::-1]) @ wide) * np.cross(pose[:3, 2], way)
        front = pose[:3, 3] + half * way + np.outer([-1.0, 0.0, 1.0], aside)
        if self.pad.told is not None and self.pad.told.stopped(front):
            return False
        self.walls.append(
            Wall(pose[:3, 3] + half * way, way, -pose[:3, 2], pose, wide, stroke.ended == "wall")
        )
        return True

    def _back_on(self, pose: Floats) -> bool:
        """Lie again where a stroke began that a wall has ended."""
        return self.pad.touch(pose, 6.0, 6.0)

    def _stroke_across(self, heading: Floats, strokes: list[Contacts], edges: list[Sighting]) -> None:
        """To the edge on one side, to the edge on the other, and back to the middle."""
        travel = 0.0
        for sign in (1.0, -1.0):
            began = self.pad.guard.world_from_sensor
            stroke = self.pad.stroke(sign * heading)
            strokes.append(stroke.contacts)
            self.note_wall(stroke)
            if stroke.ended == "wall" and not self._back_on(began):
                return
            if stroke.ended == "edge":
                edges.extend(self.pad.sightings(sign * heading))
            travel = stroke.travel
            if stroke.ended in ("closed", "lost"):
                return
        if travel > _WORTH_CENTERING:
            self.note_wall(self.pad.stroke(heading, travel / 2.0))
