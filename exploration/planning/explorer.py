"""Explore a convex object until its boundary is closed.

Find it, lie flush on it, stroke the face under the pad to its edges, roll over every edge to the face behind it,
touch what the faces so far predict and nothing has touched, and trace every edge.  Each of those is a move; the
frontier says what is open, and the cheapest open thing comes next.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from exploration.control.procedures.approach import ApproachConfig, retreat
from exploration.control.procedures.settle import SettleConfig
from exploration.control.sighting import Sighting
from exploration.control.track_edge import follow_edge
from exploration.control.track_surface import Stroke
from exploration.devices.guard import Collision, Guard, OverPress
from exploration.planning.attribution import CONVEX, AttributionConfig, joined, known_face, take_in
from exploration.planning.frontier import Frontier, OpenEdge, Predicted
from exploration.planning.pad import Announce, Pad
from exploration.planning.search import sweeps
from exploration.planning.transit import Support
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.evidence import Contacts, EdgeTrace
from primitives.fit import Fit
from primitives.patch_graph import Face, PatchGraph

Done = tuple[int | None, str]  # the face that a move ended on, and what it did


@dataclass(frozen=True)
class ExplorerConfig:
    """Distances and limits of exploration."""

    feature: float = 10.0  # [mm] the smallest feature that must not be missed
    max_touches: int = 500
    explained: float = 0.8  # [mm] from a known face, an edge seen needs no crossing
    passes: float = 2.0  # [mm] from a face that a crossing led to, its edge is explained by it
    roll: tuple[float, ...] = (60.0, 95.0)  # [deg] attitudes from which an edge is crossed, in turn
    aside: float = 2.0  # [mm] beyond an edge that leads only to known faces, where a narrow one is looked for
    overlap: float = 5.0  # [mm] of the pad that reaches back over the edge
    tries: int = 3  # at the same open thing
    beside: float = 8.0  # [mm] from a place that was tried before, where another way in is taken
    region: float = 40.0  # [mm] of open surface that is come at as one
    first_tries: int = 60  # touches after which an object that shows no face is given up
    attribution: AttributionConfig = field(default_factory=AttributionConfig)


@dataclass
class Findings:
    """What exploration has so far; read it whenever the generator yields."""

    graph: PatchGraph = field(default_factory=lambda: PatchGraph(options=CONVEX))
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
        announce: Announce = lambda kind, detail: None,
    ) -> None:
        self.guard, self.box, self.config, self.announce = guard, box, config, announce
        self.found = Findings()
        self.pad = Pad(guard, box, announce)
        self._loose = Contacts.of(np.empty((0, 3)))
        self._seen: list[tuple[Sighting, int]] = []
        self._crossed: list[Floats] = []
        self._visited: list[Floats] = []
        self._tried: list[Floats] = []

    def run(self) -> Iterator[Findings]:
        """Explore; yields after every move."""
        if not self._find():
            spent = self.guard.cost.touches >= self.config.max_touches
            self.found.ended = "budget" if spent else "nothing was found in the workspace"
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

    def _next(self, face: int | None) -> Callable[[], Done] | None:
        """The next move: cross an edge, touch what is untouched, trace an edge; None when nothing is open."""
        if not any(isinstance(f.fit, Fit) for f in self.found.graph.faces):
            self.found.open = 1
            return self._look_again if self.guard.cost.touches < self.config.first_tries else None
        crossing = self._open_sighting(face)
        if crossing is not None:
            sighting, own = crossing
            return lambda: self._cross(sighting, own)
        frontier = Frontier(self.found.graph.faces, self.box)
        untouched = frontier.untouched(self.pad.covered, self.config.feature / 2.0)
        missing = self._unfinished(untouched)
        edges = frontier.open_edges([t for t, _ in self.found.traces])
        edges = [edge for edge in edges if not self._given_up(edge.point)]
        self.found.open = len(missing.points) + len(edges)
        if len(missing.points):
            return lambda: self._cover(missing, face)
        if edges:
            nearest = min(edges, key=lambda e: float(np.linalg.norm(e.point - self.pad.here.point)))
            return lambda: self._trace(nearest)
        self.found.open = len(untouched.points)
        return None

    def _find(self) -> bool:
        for start, end in sweeps(self.box, self.pad.size):
            if self.guard.cost.touches >= self.config.max_touches:
                return False
            try:
                self.guard.go_to(start)
                distance = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))
                settled = self.pad.come_down(start[:3, 2], distance, ApproachConfig().search_speed)
                if settled or self.pad.touches():
                    return True
            except (OverPress, Collision) as error:
                self.found.warnings.append(str(error))
            here = self.guard.world_from_sensor
            self.guard.go_to(se3.pose(start[:3, :3], [here[0, 3], here[1, 3], start[2, 3]]))
        return False

    def _look_again(self) -> Done:
        """Come down again beside a first contact that told nothing, each time from another side."""
        turn = se3.turn_about(
            self.pad.here.point,
            self.guard.world_from_sensor[:3, self.guard.cost.touches % 2],
            0.35 * (-1.0) ** (self.guard.cost.touches // 2),
        )
        retreat(self.guard, 15.0)
        target = turn @ self.guard.world_from_sensor
        self.guard.go_to(target)
        if not self.pad.come_down(target[:3, 2], 40.0):
            return None, "looked for the object again in vain"
        return self._study(), "came down beside the first contact"

    def _study(self) -> int | None:
        """Stroke the face under the pad along two axes, to its edges; the face's id."""
        first = self.pad.feel()
        known = known_face(self.found.graph, first, self.config.attribution)
        if known is not None:
            self.found.graph = joined(self.found.graph, first, known, self.config.attribution)
            return known
        strokes: list[Contacts] = [first]
        edges: list[Sighting] = self.pad.sightings()
        axes = self.pad.axes()
        try:
            for heading in (axes[:, 0], axes[:, 1]):
                self._stroke_across(heading, strokes, edges)
        except (OverPress, Collision) as error:
            self.found.warnings.append(str(error))
        face = self._take_in(Contacts.concatenate(strokes))
        if face is None:
            self.found.warnings.append("a touch told too little to name the face under it")
            return None
        self._seen.extend((edge, face) for edge in edges)
        return face

    def _take_in(self, contacts: Contacts) -> int | None:
        taken = take_in(self.found.graph, self._loose, contacts, self.config.attribution)
        self.found.graph, self._loose = taken.graph, taken.loose
        self._seen = [(sighting, taken.gone.get(own, own)) for sighting, own in self._seen]
        return taken.home

    def _stroke_across(self, heading: Floats, strokes: list[Contacts], edges: list[Sighting]) -> None:
        """To the edge on one side, to the edge on the other, and back to the middle."""
        travel = 0.0
        for sign in (1.0, -1.0):
            stroke = self.pad.stroke(sign * heading)
            strokes.append(stroke.contacts)
            if stroke.ended == "edge":
                edges.extend(self.pad.sightings(sign * heading))
            travel = stroke.travel
            if stroke.ended in ("closed", "lost"):
                return
        if travel > 4.0:
            self.pad.stroke(heading, travel / 2.0)

    def _open_sighting(self, face: int | None) -> tuple[Sighting, int] | None:
        """An edge seen from one face that no other known face explains; from the present face if there is one."""
        self._seen = [(s, own) for s, own in self._seen if not self._explained(s, own)]
        if not self._seen:
            return None
        return min(
            self._seen,
            key=lambda pair: (pair[1] != face, float(np.linalg.norm(pair[0].point - self.pad.here.point))),
        )

    def _explained(self, sighting: Sighting, own: int) -> bool:
        if self._times_crossed(sighting) > len(self.config.roll):
            return True
        for face in self.found.graph.faces:
            if face.id == own or not isinstance(face.fit, Fit):
                continue
            normal = outward_normal(face, sighting.point)
            slack = self.config.explained + 2.0 * sighting.sigma
            near = abs(float(face.fit.shape.signed_distance(sighting.point[None])[0])) < slack
            if near and abs(normal @ sighting.tangent) < 0.5 and normal @ sighting.outward > 0.1:
                return True
        return self._goes_on(sighting, own)

    def _goes_on(self, sighting: Sighting, own: int) -> bool:
        """Whether the face was touched beyond the edge that was seen, which then was none."""
        fit = next((f.fit for f in self.found.graph.faces if f.id == own), None)
        if not isinstance(fit, Fit):
            return fit is None
        beyond = fit.shape.project((sighting.point + 5.0 * sighting.outward)[None])
        return bool(self.pad.covered.covers(beyond, 2.0)[0])

    def _times_crossed(self, sighting: Sighting) -> int:
        return sum(float(np.linalg.norm(p - sighting.point)) < 4.0 for p in self._crossed)

    def _cross(self, sighting: Sighting, own: int) -> Done:
        """Roll over an edge onto the face behind it."""
        tried = self._times_crossed(sighting)
        self._crossed.append(sighting.point)
        if tried >= len(self.config.roll):
            return self._press_between(sighting, own)
        angle = np.radians(self.config.roll[tried])
        normal = np.cos(angle) * sighting.normal + np.sin(angle) * sighting.outward
        down = np.cos(angle) * sighting.outward - np.sin(angle) * sighting.normal
        reach = 0.5 * self.pad.size[1] - self.config.overlap
        target = se3.pose(se3.frame_along(-normal, sighting.tangent), sighting.point + max(reach, 0.0) * down)
        self.pad.travel(target, Support(sighting.point, sighting.normal), standoff=10.0)
        if not self.pad.touch(target, standoff=10.0, overtravel=16.0):
            return None, "crossed an edge and met nothing"
        face = self._study()
        if face is not None and face != own and self._passes(face, sighting.point):
            self._crossed.extend([sighting.point] * len(self.config.roll))
        return face, "rolled back onto the same face" if face == own else "crossed an edge"

    def _passes(self, face: int, point: Floats) -> bool:
        """Whether a face, once found, runs so near a place that it bounds the edge seen there."""
        fit = self.found.graph.face(face).fit
        return (
            isinstance(fit, Fit)
            and abs(float(fit.shape.signed_distance(point[None])[0])) < self.config.passes
        )

    def _press_between(self, sighting: Sighting, own: int) -> Done:
        """Press on what may be a face too narrow to roll onto: midway between the two beside it, unmoved."""
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
        attitude = se3.frame_along(-normal, sighting.tangent)
        target = se3.pose(attitude, sighting.point + self.config.aside * down)
        self.pad.travel(target, Support(sighting.point, sighting.normal), standoff=10.0)
        if not self.pad.touch(target, standoff=10.0, overtravel=16.0, settling=SettleConfig(shifts=0)):
            return None, "pressed between two faces and met nothing"
        return self._study(), "pressed between two faces"

    def _trace(self, edge: OpenEdge) -> Done:
        """Lie on the flatter face with the edge under the pad, and follow it both ways."""
        self._tried.append(edge.point)
        face = self.found.graph.face(edge.faces[0])
        normal = np.cross(edge.outward, edge.tangent)
        normal = normal * np.sign(normal @ outward_normal(face, edge.point))
        target = se3.pose(se3.frame_along(-normal, edge.tangent), edge.point - 2.0 * edge.outward)
        self.pad.travel(target, Support(edge.point, normal), standoff=6.0)
        if not self.pad.touch(target, standoff=6.0, overtravel=6.0):
            return None, "an edge was not where the faces meet"
        touch, cost, longest = self.guard.cost.touches, self.guard.cost, self.pad.config.longest
        cost.strokes += 1
        best = ahead = follow_edge(self.guard, edge.tangent, longest, touch, cost.strokes)
        if ahead.ended != "closed":
            cost.strokes += 1
            back = follow_edge(self.guard, -edge.tangent, longest, touch, cost.strokes)
            best = max((ahead, back), key=lambda t: len(t.trace.points) if t.trace else 0)
        self.pad.lie(np.empty((0, 3)))
        if best.trace is None:
            return edge.faces[0], "an edge could not be traced"
        self.found.traces.append((best.trace, edge.faces))
        graph, edge_id = self.found.graph.add_trace(best.trace, edge.faces[0])
        self.found.graph = graph.attach(edge_id, edge.faces[1])
        return edge.faces[0], "traced an edge"

    def _cover(self, missing: Predicted, face: int | None) -> Done:
        """Stroke from here over what is untouched on this face, or touch down where it is nearest."""
        fresh = np.array([self._tries(p, 1.5) == 0 for p in missing.points])
        on_face = (missing.face == face) & fresh
        if face is not None and on_face.any() and self._flush_on(face):
            points = missing.points[on_face]
            goal = points[np.argmin(np.linalg.norm(points - self.pad.here.point, axis=1))]
            self._tried.append(goal)
            here = self.guard.world_from_sensor
            toward = here[:3, :2].T @ (goal - here[:3, 3])
            distance = float(np.linalg.norm(toward))
            if distance > 1.0:
                stroke = self.pad.stroke(toward / distance, distance + self.config.feature)
                self._note_edges(stroke, face, toward / distance)
                if stroke.travel < 1.0:
                    self._tried.extend(_beyond(points, goal, self.pad.here.point))
                taken = self._take_in(stroke.contacts) if len(stroke.contacts) else None
                return face if taken is None else taken, "stroked what was untouched"
        return self._visit(missing)

    def _note_edges(self, stroke: Stroke, face: int, heading: Floats) -> None:
        if stroke.ended == "edge":
            self._seen.extend((edge, face) for edge in self.pad.sightings(heading))

    def _visit(self, missing: Predicted) -> Done:
        """Touch down at a predicted point; where that did not help before, come to the middle of what is open.

        Faces that go on too far, as a cone to an apex that was cut off, predict points where nothing is.
        The mean of their normals is the way in from outside.
        """
        nearest = int(np.argmin(np.linalg.norm(missing.points - self.pad.here.point, axis=1)))
        point, normal = missing.points[nearest], missing.normals[nearest]
        standoff, overtravel = 8.0, 10.0
        visited = [float(np.linalg.norm(p - point)) for p in self._visited]
        self._visited.append(point)
        if min(visited, default=np.inf) < self.config.beside:
            around = np.linalg.norm(missing.points - point, axis=1) < self.config.region
            middle = missing.normals[around].mean(axis=0)
            if np.linalg.norm(middle) > 0.2:
                normal = middle / np.linalg.norm(middle)
                point = missing.points[around].mean(axis=0)
                standoff = float(((missing.points[around] - point) @ normal).max()) + standoff
                overtravel = self.config.region
        self._tried.append(missing.points[nearest])
        hint = self.guard.world_from_sensor[:3, 0]
        target = se3.pose(se3.frame_along(-normal, hint), point)
        self.pad.travel(target, Support(point, normal), standoff)
        if not self.pad.touch(target, standoff, overtravel):
            return None, "nothing was where the faces so far predict the surface"
        return self._study(), "touched a place that was only predicted"

    def _flush_on(self, face: int) -> bool:
        """Whether the pad lies on that face now."""
        fit = next((f.fit for f in self.found.graph.faces if f.id == face), None)
        if not isinstance(fit, Fit) or not self.pad.touches():
            return False
        return abs(float(fit.shape.signed_distance(self.pad.here.point[None])[0])) < 2.0

    def _given_up(self, point: Floats, within: float = 1.5) -> bool:
        return self._tries(point, within) >= self.config.tries

    def _tries(self, point: Floats, within: float) -> int:
        """How often a move has gone for this place."""
        if not self._tried:
            return 0
        return int((np.linalg.norm(np.array(self._tried) - point, axis=1) < within).sum())

    def _unfinished(self, missing: Predicted) -> Predicted:
        keep = np.array([not self._given_up(p) for p in missing.points], dtype=bool)
        return Predicted(missing.points[keep], missing.normals[keep], missing.face[keep])


def outward_normal(face: Face, point: Floats) -> Floats:
    """(3,) outward normal of a fitted face at the place on it nearest to a (3,) point."""
    assert isinstance(face.fit, Fit)
    return np.asarray(face.fit.shape.normals(point[None])[0] * (1.0 if face.fit.convex else -1.0))


def _beyond(points: Floats, goal: Floats, here: Floats) -> Floats:
    """Those of (n, 3) points that lie the same way from `here` as a goal that could not be stroked to."""
    toward = points - here
    ahead = toward @ (goal - here) > 0.8 * np.linalg.norm(toward, axis=1) * np.linalg.norm(goal - here)
    return np.asarray(points[ahead])
