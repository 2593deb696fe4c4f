"""Explore a convex object until its boundary is closed.

Find it, lie flush on it, stroke the face under the pad to its edges, roll over every edge to the face behind it,
touch what the faces so far predict and nothing has touched, and trace every edge.  Each of those is a move; the
frontier says what is open, and the cheapest open thing comes next.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from exploration.control.dwell import dwell
from exploration.control.feel import feel
from exploration.control.procedures.approach import ApproachConfig, retreat, touched
from exploration.control.procedures.curvature import four_direction_curvature
from exploration.control.procedures.land import land
from exploration.control.procedures.settle import SettleConfig
from exploration.control.sighting import Sighting, brink, ends_by_curving, sight
from exploration.control.track_edge import follow_edge
from exploration.control.track_surface import Stroke, follow_surface, keep, touched_cells
from exploration.devices.guard import Collision, Guard, OverPress
from exploration.planning.consistency import drop_contradicted, drop_edges
from exploration.planning.frontier import Frontier, OpenEdge, Predicted
from exploration.planning.search import sweeps
from exploration.planning.touched import Touched
from exploration.planning.transit import Support, box_supports, way
from exploration.sensing.hough import find_lines
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.classify import RankOptions
from primitives.evidence import Contacts, EdgeTrace
from primitives.fit import Fit
from primitives.patch_graph import Face, MergeOptions, PatchGraph


@dataclass(frozen=True)
class ExplorerConfig:
    """Distances and limits of exploration."""

    feature: float = 10.0  # [mm] the smallest feature that must not be missed
    max_touches: int = 500
    longest: float = 400.0  # [mm] of one stroke
    least_line: float = 4.0  # [mm] of a line that counts as an edge
    explained: float = 0.8  # [mm] from a known face, an edge seen needs no crossing
    roll: tuple[float, ...] = (60.0, 95.0)  # [deg] attitudes from which an edge is crossed, in turn
    aside: float = 2.0  # [mm] beyond an edge that leads only to known faces, where a narrow one is looked for
    overlap: float = 5.0  # [mm] of the pad that reaches back over the edge
    tries: int = 3  # at the same open thing
    beside: float = 8.0  # [mm] from a place that was tried before, where another way in is taken
    region: float = 40.0  # [mm] of open surface that is come at as one
    first_tries: int = 60  # touches after which an object that shows no face is given up
    near: float = 0.1  # [mm] a contact this far from a known face belongs to it
    turned: float = 0.06  # [rad] as long as its normal is no farther off
    misfit: float = 8.0  # chi2 per degree of freedom of a face that is none
    least_contacts: int = 5  # that make a new face
    least_share: float = 0.3  # of a visit's contacts that must be unexplained to make one at once
    pool: float = 20.0  # [mm] within which the unexplained contacts of several visits are put together
    facing: float = 0.95  # least cosine of their normals with the first one's


_SETTLE = SettleConfig()
_MERGE = MergeOptions(
    slack=3.0,  # errors common to a stroke are larger than its frames' noise
    rank=RankOptions(
        prior={"plane": 0.5, "cylinder": 0.25, "cone": 0.1, "sphere": 0.1},
    ),
)


@dataclass
class Findings:
    """What exploration has so far; read it whenever the generator yields."""

    graph: PatchGraph = field(default_factory=lambda: PatchGraph(options=_MERGE))
    traces: list[tuple[EdgeTrace, tuple[int, int]]] = field(default_factory=list)
    ended: str = ""
    open: int = 0  # things still open, when last counted
    note: str = ""
    warnings: list[str] = field(default_factory=list)


class Explorer:
    """One exploration: a generator of moves over a guard."""

    def __init__(
        self,
        guard: Guard,
        box: Floats,
        config: ExplorerConfig = ExplorerConfig(),
        announce: Callable[[str, dict[str, object]], None] = lambda kind, detail: None,
    ) -> None:
        self.guard, self.box, self.config, self.announce = guard, box, config, announce
        self.found = Findings()
        self.touched = Touched()
        self._here = Support(np.array([0.0, 0.0, box[5]]), np.array([0.0, 0.0, 1.0]))
        self._seen: list[tuple[Sighting, int]] = []
        self._crossed: list[Floats] = []
        self._loose = Contacts.of(np.empty((0, 3)))
        self._tried: list[Floats] = []

    def run(self) -> Iterator[Findings]:
        """Explore; yields after every move."""
        if not self._find():
            self.found.ended = "nothing was found in the workspace"
            return
        face: int | None = None
        try:
            face = self._study()
        except (OverPress, Collision) as error:
            self.found.warnings.append(str(error))
        yield self._say("found the object")
        while self.guard.cost.touches < self.config.max_touches:
            move = self._next(face)
            if move is None:
                self.found.ended = "closed" if not self.found.open else "nothing reachable is open"
                return
            try:
                done, note = move()
            except (OverPress, Collision) as error:
                self.found.warnings.append(str(error))
                done, note = None, f"backed off: {error}"
            face = done if done is not None else face
            yield self._say(note)
        self.found.ended = "budget"

    def _say(self, note: str) -> Findings:
        self.found.note = note
        self.announce("move", {"note": note, "faces": len(self.found.graph.faces)})
        return self.found

    def _next(self, face: int | None) -> Callable[[], tuple[int | None, str]] | None:
        """The next move: cross an edge, touch what is untouched, trace an edge; None when nothing is open."""
        if not any(isinstance(f.fit, Fit) for f in self.found.graph.faces):
            self.found.open = 1
            return self._look_again if self.guard.cost.touches < self.config.first_tries else None
        crossing = self._open_sighting(face)
        if crossing is not None:
            sighting, own = crossing
            return lambda: self._cross(sighting, own)
        frontier = Frontier(self.found.graph.faces, self.box)
        missing = self._unfinished(frontier.untouched(self.touched, self.config.feature / 2.0))
        edges = [
            e for e in frontier.open_edges([t for t, _ in self.found.traces]) if not self._given_up(e.point)
        ]
        self.found.open = len(missing.points) + len(edges)
        if len(missing.points):
            return lambda: self._cover(missing, face)
        if edges:
            nearest = min(edges, key=lambda e: float(np.linalg.norm(e.point - self._here.point)))
            return lambda: self._trace(nearest)
        untouched = frontier.untouched(self.touched, self.config.feature / 2.0)
        self.found.open = len(untouched.points)
        return None

    def _find(self) -> bool:
        for start, end in sweeps(self.box, self.guard.sensor.array.size):
            try:
                self.guard.go_to(start)
                self.guard.cost.touches += 1
                distance = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))
                if land(self.guard, start[:3, 2], distance, ApproachConfig().search_speed):
                    return True
            except (OverPress, Collision) as error:
                self.found.warnings.append(str(error))
            here = self.guard.world_from_sensor
            self.guard.go_to(se3.pose(start[:3, :3], [here[0, 3], here[1, 3], start[2, 3]]))
        return False

    def _look_again(self) -> tuple[int | None, str]:
        """Come down again beside a first contact that told nothing, each time from another side."""
        turn = se3.turn_about(
            self._here.point,
            self.guard.world_from_sensor[:3, self.guard.cost.touches % 2],
            0.35 * (-1.0) ** (self.guard.cost.touches // 2),
        )
        retreat(self.guard, 15.0)
        target = turn @ self.guard.world_from_sensor
        self.guard.go_to(target)
        self.guard.cost.touches += 1
        if not land(self.guard, target[:3, 2], 40.0, ApproachConfig().speed):
            return None, "looked for the object again in vain"
        return self._study(), "came down beside the first contact"

    def _study(self) -> int | None:
        """Stroke the face under the pad along two axes, to its edges; the face's id."""
        first = self._feel_here()
        known = self._known(first)
        if known is not None:
            self._join(first, known)
            return known
        strokes: list[Contacts] = [first]
        edges: list[Sighting] = self._sightings()
        axis = self._axes()
        try:
            for heading in (axis[:, 0], axis[:, 1]):
                self._stroke_across(heading, strokes, edges)
        except (OverPress, Collision) as error:
            self.found.warnings.append(str(error))
        contacts = Contacts.concatenate(strokes)
        face = self._take_in(contacts)
        if face is None:
            self.found.warnings.append("a face was too small to be measured")
            return None
        self._seen.extend((edge, face) for edge in edges)
        return face

    def _take_in(self, contacts: Contacts) -> int | None:
        """Give contacts to the faces that explain them; what is left over is a new face, if there is enough."""
        owner = np.full(len(contacts), -1)
        best = np.full(len(contacts), np.inf)
        for face in self.found.graph.faces:
            if isinstance(face.fit, Fit) and len(contacts):
                off = self._misfit(face.fit, contacts)
                closer = off < np.minimum(best, 1.0)
                owner[closer], best[closer] = face.id, off[closer]
        home: int | None = None
        for face_id in np.unique(owner[owner >= 0]):
            self._grow(
                self.found.graph.add_contacts(contacts.select(owner == face_id), int(face_id)), int(face_id)
            )
        if (owner >= 0).any():
            home = int(np.bincount(owner[owner >= 0]).argmax())
        rest = contacts.select(owner < 0)
        if len(rest) < max(self.config.least_contacts, self.config.least_share * len(contacts)):
            rest = self._pooled(rest)
        if len(rest) >= self.config.least_contacts:
            grown, opened = self.found.graph.add_stroke(rest)
            if not self._grow(grown, opened):
                rest = self._beside(rest, rest)
                grown, opened = self.found.graph.add_stroke(rest)
                if len(rest) < self.config.least_contacts or not self._grow(grown, opened):
                    return home
            home = opened
            self.found.graph, gone = self.found.graph.merge_faces()
            home = gone.get(home, home)
            self._seen = [(sighting, gone.get(own, own)) for sighting, own in self._seen]
        self.found.graph = drop_edges(drop_contradicted(self.found.graph))
        return home if any(face.id == home for face in self.found.graph.faces) else None

    def _pooled(self, rest: Contacts) -> Contacts:
        """Unexplained contacts of this visit and of earlier ones beside its first: a small face, perhaps."""
        self._loose = Contacts.concatenate([self._loose, rest])
        return self._beside(self._loose, rest) if len(rest) else rest

    def _beside(self, contacts: Contacts, rest: Contacts) -> Contacts:
        """Those contacts that lie beside the first of `rest`, where the pad came down, and face as it does."""
        near = np.linalg.norm(contacts.points - rest.points[0], axis=1) < self.config.pool
        return contacts.select(near & (contacts.normals @ rest.normals[0] > self.config.facing))

    def _grow(self, graph: PatchGraph, face_id: int) -> bool:
        """Accept a graph in which a face grew, unless no one shape explains the face any more."""
        fit = graph.face(face_id).fit
        if isinstance(fit, Fit) and fit.chi2 > self.config.misfit * max(fit.dof, 1):
            return False
        self.found.graph = graph
        return True

    def _misfit(self, fit: Fit, contacts: Contacts) -> Floats:
        """(n,) distance and turn from a fitted face, in units of what still belongs to it."""
        off = np.abs(fit.shape.signed_distance(contacts.points)) / np.hypot(
            4.0 * contacts.sigma, self.config.near
        )
        side = 1.0 if fit.convex else -1.0
        facing = side * (fit.shape.normals(contacts.points) * contacts.normals).sum(axis=1)
        turn = np.arccos(np.clip(facing, -1.0, 1.0)) / np.hypot(
            3.0 * contacts.normal_sigma, self.config.turned
        )
        return np.asarray(np.maximum(off, turn))

    def _stroke_across(self, heading: Floats, strokes: list[Contacts], edges: list[Sighting]) -> None:
        """To the edge on one side, to the edge on the other, and back to the middle."""
        travel = 0.0
        for sign in (1.0, -1.0):
            stroke = self._stroke(sign * heading)
            strokes.append(stroke.contacts)
            if stroke.ended == "edge":
                edges.extend(self._sightings(sign * heading))
            travel = stroke.travel
            if stroke.ended in ("closed", "lost"):
                return
        if travel > 4.0:
            self._stroke(heading, travel / 2.0)

    def _known(self, contacts: Contacts) -> int | None:
        """The face that these contacts lie on, if it is one of those found."""
        for face in self.found.graph.faces:
            if (
                isinstance(face.fit, Fit)
                and len(contacts)
                and np.median(self._misfit(face.fit, contacts)) < 1.0
            ):
                return face.id
        return None

    def _join(self, contacts: Contacts, face: int) -> None:
        if len(contacts):
            self._grow(self.found.graph.add_contacts(contacts, face), face)

    def _feel_here(self) -> Contacts:
        """Contacts of the place under the pad, from averaged frames."""
        seen = dwell(self.guard, 8)
        kept: list[Contacts] = []
        self.guard.cost.strokes += 1
        keep(seen, self.guard.cost.touches, self.guard.cost.strokes, kept)
        felt = feel(seen.image)
        self._lie(touched_cells(seen, felt) if felt else np.empty((0, 3)))
        return Contacts.concatenate(kept)

    def _stroke(self, heading: Floats, length: float | None = None) -> Stroke:
        self.guard.cost.strokes += 1
        stroke = follow_surface(
            self.guard,
            heading,
            self.config.longest if length is None else length,
            self.guard.cost.touches,
            self.guard.cost.strokes,
        )
        self._lie(stroke.cells)
        return stroke

    def _lie(self, cells: Floats) -> None:
        """Note where the pad lies, and what it covers."""
        here = self.guard.world_from_sensor
        felt = feel(self.guard.hold().image)
        offset = np.array([*(felt.centroid if felt else (0.0, 0.0)), 0.0])
        self._here = Support(here[:3, :3] @ offset + here[:3, 3], -here[:3, 2])
        self.touched.add(cells, self._here)

    def _axes(self) -> Floats:
        """(2, 2) columns to stroke along: the edge that is seen, or the least curvature; and across it."""
        seen = dwell(self.guard, 8)
        felt = feel(seen.image)
        long = np.array([1.0, 0.0])
        if felt:
            curved = four_direction_curvature(seen.image, felt)
            self.announce(
                "curvature",
                {
                    "order": curved.order,
                    "probability": curved.probability,
                    "k1_per_mm": float(curved.four.k1[0]),
                    "k2_per_mm": float(curved.four.k2[0]),
                    "consistency": float(curved.four.consistency[0]),
                },
            )
            lines = [line for line in find_lines(seen.image, 3) if line.length > self.config.least_line]
            if curved.order != "plane":
                long = curved.ridge
            elif lines:
                long = max(lines, key=lambda line: line.length).direction
        return np.array([[long[0], -long[1]], [long[1], long[0]]])

    def _sightings(self, heading: Floats | None = None) -> list[Sighting]:
        """Edges under the pad; where contact ends ahead and no line says where, the end itself."""
        seen = dwell(self.guard, 6)
        felt = feel(seen.image)
        if not felt:
            return []
        lines = [line for line in find_lines(seen.image, 3) if line.length > self.config.least_line]
        lines = [line for line in lines if not ends_by_curving(line, felt)]
        found = [sight(line, seen) for line in lines]
        if heading is not None and not any(-line.inward @ heading > 0.4 for line in lines):
            found.append(brink(seen, felt, heading))
        return found

    def _open_sighting(self, face: int | None) -> tuple[Sighting, int] | None:
        """An edge seen from one face that no other known face explains; from the present face if there is one."""
        self._seen = [(s, own) for s, own in self._seen if not self._explained(s, own)]
        if not self._seen:
            return None
        return min(
            self._seen,
            key=lambda pair: (pair[1] != face, float(np.linalg.norm(pair[0].point - self._here.point))),
        )

    def _explained(self, sighting: Sighting, own: int) -> bool:
        tried = sum(float(np.linalg.norm(p - sighting.point)) < 4.0 for p in self._crossed)
        if tried > len(self.config.roll):
            return True
        for face in self.found.graph.faces:
            if face.id == own or not isinstance(face.fit, Fit):
                continue
            point = sighting.point[None]
            normal = outward_normal(face, sighting.point)
            slack = self.config.explained + 2.0 * sighting.sigma
            near = abs(float(face.fit.shape.signed_distance(point)[0])) < slack
            if near and abs(normal @ sighting.tangent) < 0.5 and normal @ sighting.outward > 0.1:
                return True
        return self._goes_on(sighting, own)

    def _goes_on(self, sighting: Sighting, own: int) -> bool:
        """Whether the face was touched beyond the edge that was seen, which then was none."""
        fit = next((f.fit for f in self.found.graph.faces if f.id == own), None)
        if not isinstance(fit, Fit):
            return fit is None
        beyond = fit.shape.project((sighting.point + 5.0 * sighting.outward)[None])
        return bool(self.touched.covers(beyond, 2.0)[0])

    def _cross(self, sighting: Sighting, own: int) -> tuple[int | None, str]:
        """Roll over an edge onto the face behind it."""
        tried = sum(float(np.linalg.norm(p - sighting.point)) < 4.0 for p in self._crossed)
        self._crossed.append(sighting.point)
        if tried >= len(self.config.roll):
            return self._press_between(sighting, own)
        angle = np.radians(self.config.roll[tried])
        normal = np.cos(angle) * sighting.normal + np.sin(angle) * sighting.outward
        down = np.cos(angle) * sighting.outward - np.sin(angle) * sighting.normal
        reach = 0.5 * self.guard.sensor.array.size[1] - self.config.overlap
        target = se3.pose(se3.frame_along(-normal, sighting.tangent), sighting.point + max(reach, 0.0) * down)
        self._travel(target, Support(sighting.point, sighting.normal), standoff=10.0)
        if not self._touch(target, standoff=10.0, overtravel=16.0):
            return None, "crossed an edge and met nothing"
        face = self._study()
        if face == own:
            return face, "rolled back onto the same face"
        return face, "crossed an edge"

    def _press_between(self, sighting: Sighting, own: int) -> tuple[int | None, str]:
        """Press on what may be a face too narrow to roll onto: midway between the two faces beside it, unmoved."""
        normal = sighting.outward
        behind = [f for f in self.found.graph.faces if f.id != own and isinstance(f.fit, Fit)]
        facing = [n for f in behind if (n := outward_normal(f, sighting.point)) @ sighting.outward > 0.1]
        if facing:
            nearest = min(facing, key=lambda n: abs(float(n @ sighting.tangent)))
            normal = nearest + sighting.normal
            normal = normal - (normal @ sighting.tangent) * sighting.tangent
            normal = normal / np.linalg.norm(normal)
        down = np.cross(sighting.tangent, normal)
        down = down * -np.sign(down @ sighting.normal)
        target = se3.pose(
            se3.frame_along(-normal, sighting.tangent), sighting.point + self.config.aside * down
        )
        self._travel(target, Support(sighting.point, sighting.normal), standoff=10.0)
        if not self._touch(target, standoff=10.0, overtravel=16.0, settling=SettleConfig(shifts=0)):
            return None, "pressed between two faces and met nothing"
        return self._study(), "pressed between two faces"

    def _trace(self, edge: OpenEdge) -> tuple[int | None, str]:
        """Lie on the flatter face with the edge under the pad, and follow it both ways."""
        self._tried.append(edge.point)
        face = self.found.graph.face(edge.faces[0])
        assert isinstance(face.fit, Fit)
        normal = np.cross(edge.outward, edge.tangent)
        normal = normal * np.sign(normal @ outward_normal(face, edge.point))
        target = se3.pose(se3.frame_along(-normal, edge.tangent), edge.point - 2.0 * edge.outward)
        self._travel(target, Support(edge.point, normal), standoff=6.0)
        if not self._touch(target, standoff=6.0, overtravel=6.0):
            return None, "an edge was not where the faces meet"
        touch, cost = self.guard.cost.touches, self.guard.cost
        cost.strokes += 1
        ahead = follow_edge(self.guard, edge.tangent, self.config.longest, touch, cost.strokes)
        best = ahead
        if ahead.ended != "closed":
            cost.strokes += 1
            back = follow_edge(self.guard, -edge.tangent, self.config.longest, touch, cost.strokes)
            best = max((ahead, back), key=lambda t: len(t.trace.points) if t.trace else 0)
        self._lie(np.empty((0, 3)))
        if best.trace is None:
            return edge.faces[0], "an edge could not be traced"
        self.found.traces.append((best.trace, edge.faces))
        graph, edge_id = self.found.graph.add_trace(best.trace, edge.faces[0])
        self.found.graph = graph.attach(edge_id, edge.faces[1])
        return edge.faces[0], "traced an edge"

    def _cover(self, missing: Predicted, face: int | None) -> tuple[int | None, str]:
        """Stroke from here over what is untouched on this face, or touch down where it is nearest."""
        fresh = np.array([self._tries(p, 1.5) == 0 for p in missing.points])
        on_face = (missing.face == face) & fresh
        if face is not None and on_face.any() and self._flush_on(face):
            points = missing.points[on_face]
            goal = points[np.argmin(np.linalg.norm(points - self._here.point, axis=1))]
            self._tried.append(goal)
            here = self.guard.world_from_sensor
            toward = here[:3, :2].T @ (goal - here[:3, 3])
            distance = float(np.linalg.norm(toward))
            if distance > 1.0:
                stroke = self._stroke(toward / distance, distance + self.config.feature)
                self._note_edges(stroke, face, toward / distance)
                if stroke.travel < 1.0:
                    self._tried.extend(_beyond(points, goal, self._here.point))
                taken = self._take_in(stroke.contacts) if len(stroke.contacts) else None
                return face if taken is None else taken, "stroked what was untouched"
        nearest = int(np.argmin(np.linalg.norm(missing.points - self._here.point, axis=1)))
        return self._visit(missing, nearest)

    def _note_edges(self, stroke: Stroke, face: int, heading: Floats) -> None:
        if stroke.ended == "edge":
            self._seen.extend((edge, face) for edge in self._sightings(heading))

    def _visit(self, missing: Predicted, nearest: int) -> tuple[int | None, str]:
        """Touch down at a predicted point; where that did not help before, come to the middle of what is open.

        Faces that go on too far, as a cone to an apex that was cut off, predict points where nothing is.
        The mean of their normals is the way in from outside.
        """
        point, normal = missing.points[nearest], missing.normals[nearest]
        standoff, overtravel = 8.0, 10.0
        if self._tries(point, self.config.beside):
            around = np.linalg.norm(missing.points - point, axis=1) < self.config.region
            middle = missing.normals[around].mean(axis=0)
            if np.linalg.norm(middle) > 0.2:
                normal = middle / np.linalg.norm(middle)
                away = (missing.points[around] - missing.points[around].mean(axis=0)) @ normal
                self._tried.append(point)
                point = missing.points[around].mean(axis=0)
                standoff, overtravel = float(away.max()) + 8.0, self.config.region
        self._tried.append(missing.points[nearest])
        hint = self.guard.world_from_sensor[:3, 0]
        target = se3.pose(se3.frame_along(-normal, hint), point)
        self._travel(target, Support(point, normal), standoff)
        if not self._touch(target, standoff, overtravel):
            return None, "nothing was where the faces so far predict the surface"
        return self._study(), "touched a place that was only predicted"

    def _flush_on(self, face: int) -> bool:
        """Whether the pad lies on that face now."""
        fit = self.found.graph.face(face).fit
        if not isinstance(fit, Fit) or not feel(self.guard.hold().image):
            return False
        return abs(float(fit.shape.signed_distance(self._here.point[None])[0])) < 2.0

    def _given_up(self, point: Floats, within: float = 1.5) -> bool:
        return self._tries(point, within) >= self.config.tries

    def _tries(self, point: Floats, within: float) -> int:
        """How often a move has gone for this place."""
        if not self._tried:
            return 0
        return int((np.linalg.norm(np.array(self._tried) - point, axis=1) < within).sum())

    def _unfinished(self, missing: Predicted) -> Predicted:
        keep_ = np.array([not self._given_up(p) for p in missing.points], dtype=bool)
        return Predicted(missing.points[keep_], missing.normals[keep_], missing.face[keep_])

    def _touch(
        self, target: Floats, standoff: float, overtravel: float, settling: SettleConfig = _SETTLE
    ) -> bool:
        """One guarded approach and its settling; counts as a touch, hit or miss."""
        self.guard.cost.touches += 1
        back = target @ se3.pose(translation=[0.0, 0.0, -standoff])
        self.guard.go_to(back, until=lambda seen: touched(seen.image))
        speed = ApproachConfig().speed
        if land(self.guard, target[:3, 2], standoff + overtravel, speed, settling=settling):
            return True
        self._leave()
        return False

    def _leave(self) -> None:
        """Back off; the way back along the pad's normal is free, because the pad came that way."""
        retreat(self.guard, 12.0)

    def _travel(self, target: Floats, far: Support, standoff: float) -> None:
        """Through free space to `standoff` mm in front of a target."""
        retreat(self.guard, 8.0)
        goal = target @ se3.pose(translation=[0.0, 0.0, -standoff])
        here = self.guard.world_from_sensor
        same = self._here.normal @ far.normal > 0.995
        close = abs((self._here.point - far.point) @ far.normal) < 2.0
        if same and close:
            poses = [se3.pose(here[:3, :3], here[:3, 3] + 14.0 * far.normal)]
            poses.append(se3.pose(goal[:3, :3], goal[:3, 3] + 22.0 * far.normal))
            poses.append(goal)
        else:
            supports = [*self._spread(), *box_supports(self.box)]
            poses = way(here, self._here, goal, far, supports)
        for pose in poses:
            self.guard.go_to(pose)

    def _spread(self) -> list[Support]:
        """One support for each face, which is enough to go round."""
        kept: list[Support] = []
        for support in self.touched.supports:
            if all(support.normal @ other.normal < 0.95 for other in kept):
                kept.append(support)
        return kept


def outward_normal(face: Face, point: Floats) -> Floats:
    """(3,) outward normal of a fitted face at the place on it nearest to a (3,) point."""
    assert isinstance(face.fit, Fit)
    return np.asarray(face.fit.shape.normals(point[None])[0] * (1.0 if face.fit.convex else -1.0))


def _beyond(points: Floats, goal: Floats, here: Floats) -> Floats:
    """Those of (n, 3) points that lie the same way from `here` as a goal that could not be stroked to."""
    toward = points - here
    ahead = toward @ (goal - here) > 0.8 * np.linalg.norm(toward, axis=1) * np.linalg.norm(goal - here)
    return np.asarray(points[ahead])
