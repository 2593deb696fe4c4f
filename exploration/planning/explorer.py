"""Explore an object until its boundary is closed.

Find it, lie flush on it, stroke the face under the pad to its edges, roll over every edge to the face behind it,
touch what the faces so far predict and nothing has touched, and trace every edge.  Each of those is a move; the
frontier says what is open, and the cheapest open thing comes next.  An object is taken for convex, whose faces say
much about what nobody has touched yet, until a wall or its faces contradict that, or until what they say
cannot be closed; then each face is explored for itself (`any_form`).  What stopped a stroke is looked at before it
counts as a wall.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from exploration.control.procedures.approach import retreat
from exploration.devices.guard import Collision, Guard, OverPress
from exploration.planning.any_form import LATER, AnyForm
from exploration.planning.faces.consistency import flattened
from exploration.planning.faces.faceted import rounded
from exploration.planning.faces.tips import tipped
from exploration.planning.inferring.concluding import add_broken_edges
from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.known.told import Told
from exploration.planning.moves.covering import Covering
from exploration.planning.moves.crossing import Crossing
from exploration.planning.moves.finding import Finding
from exploration.planning.moves.tracing import Tracing
from exploration.planning.moves.wall_facing import Walls
from exploration.planning.open.bumps import bumpy
from exploration.planning.open.frontier import Frontier, Predicted
from exploration.planning.open.local_frontier import LocalFrontier
from exploration.planning.survey import POLICIES, Survey
from exploration.planning.touching.findings import Attempts, Done, ExplorerConfig, Findings
from exploration.planning.touching.pad import Announce, Pad
from exploration.planning.touching.study import Study
from exploration.planning.ways.routes import Tool
from primitives.arrays import Floats
from primitives.between_flats import between_flats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.rounded_ends import rounded_ends

__all__ = ["Explorer", "ExplorerConfig", "Findings"]

_UNDER = 1.0  # [mm] that the workspace reaches under a table's top


class Explorer:
    """One exploration: a generator of moves over a guard."""

    def __init__(
        self,
        guard: Guard,
        box: Floats,
        config: ExplorerConfig | None = None,
        announce: Announce = lambda kind, detail: None,
        tools: Sequence[Tool] = (),
        told: Told | None = None,
        draft: Callable[[Findings], Predicted] | None = None,
    ) -> None:
        config = config or ExplorerConfig()
        box = np.array(box, dtype=float)
        if told is not None and told.table is not None:
            box[2] = told.table - _UNDER
        self.guard, self.box, self.config, self.announce, self.told = guard, box, config, announce, told
        self.found, self._draft = Findings(), draft
        self.pad = Pad(guard, box, announce, told=told, tools=tools)
        self._felt = SurfaceMap()
        self._frontier: LocalFrontier | None = None
        self._stopped = 0  # moves that something unknown stopped, since the last that came to a face
        self._hidden = 0  # predicted places that what was told hides
        self._tried = Attempts(config.tries)
        self._study = Study(self.pad, self.found, config.attribution)
        self._finding = Finding(self._study, self.box, self.config, told)
        self._crossing = Crossing(self._study, config)
        self._covering = Covering(self._study, self._tried, config)
        self._walls = Walls(self._study)
        self._tracing = Tracing(self.pad, self.found, self._tried)

    def run(self) -> Iterator[Findings]:
        """Explore; yields after every move."""
        if not self._finding.find():
            spent = self.config.spent(self.guard.cost)
            self.found.ended = "budget" if spent else "nothing was found in the workspace"
            if spent:
                told = "nothing was met before its touches or its time were used up"
                self.found.warnings.append(f"{told}; a smaller --workspace is swept sooner")
            return
        face: int | None = None
        try:
            face = self._study.face_here()
        except (OverPress, Collision) as error:
            self.found.warnings.append(str(error))
        yield self._say("found the object")
        if self.config.policy != "closure":
            yield from self._surveyed()
            return
        while not self.config.spent(self.guard.cost):
            self.found.hollow = self.found.hollow or self._dented()
            if self.found.hollow and (self.found.named or not self._worth_another_look()):
                self._walls.recall()
                self._lay()
                yield from map(self._say, self._any_form())
                spent = self.config.spent(self.guard.cost)
                self.found.ended = "budget" if spent else self._whole(bool(self.found.open))
                return
            wall = None if self.found.hollow else self._walls.next()
            move = self._next(face) if wall is None else partial(self._walls.look, wall)
            if move is None and not self.found.hollow and (self.found.open or self._not_plain()):
                self.found.hollow = True
                continue
            if move is None and self._study.merge():
                face = None
                continue
            if move is None:
                self.found.graph, gone = rounded(
                    tipped(flattened(rounded_ends(between_flats(self.found.graph))))
                )
                self.found.rename(gone)
                add_broken_edges(self.found, self.pad.skin.mosaic)
                self.found.ended = self._whole(self._hidden > 0)
                return
            try:
                done, note = move()
            except (OverPress, Collision) as error:
                self._study.back_off(error)
                self._stopped += not self._by_what_is_told(error)
                done, note = None, f"backed off: {error}"
            if done is not None:
                face, self._stopped = done, 0
            self.found.hollow |= self._stopped >= self.config.stopped
            yield self._say(note)
        self.found.ended = "budget"

    def _whole(self, hidden: bool) -> str:
        """How it ended where nothing is left to do: a face that lies on a table nobody touched."""
        resting = self._note_resting in self.found.warnings
        return "nothing reachable is open" if hidden or resting else "closed"

    def _by_what_is_told(self, fault: OverPress | Collision) -> bool:
        """Whether what is told may have stopped a move, which says nothing of the object then."""
        if self.told is None or fault.seen is None:
            return self.told is not None
        return self.told.may_have_stopped(fault.seen.world_from_sensor, fault.came)

    def _dented(self) -> bool:
        """Whether what was felt of a face proves that the object is not convex, or it bounds no half-space."""
        if any(isinstance(face.fit, Fit) and face.fit.kind == "torus" for face in self.found.graph.faces):
            return True
        self._felt.take(self.pad.felt)
        faces, free = self.found.graph.faces, self.pad.skin.free.points
        self._frontier = LocalFrontier(
            faces,
            self._felt,
            free,
            self.config.feature,
            last=self._frontier,
            pits=self.pad.skin.pits.sure,
            mosaic=self.pad.skin.mosaic,
        )
        return self._frontier.dented()

    def _not_plain(self) -> bool:
        """Whether what looks convex and closed has a narrow hole, or a face from which something stands up."""
        if self._frontier is not None and self._frontier.narrow:
            return True
        self._felt.take(self.pad.felt)
        felt = Contacts.of(self._felt.points, self._felt.facing)
        return bumpy(self.found.graph.faces, felt if self.told is None else self.told.without(felt))

    def _any_form(self) -> Iterator[str]:
        """Face by face, with one array after the other: each goes for what those before it found no room for.

        One whose share was spent goes on once all have had theirs, where something is left.
        """
        cut_short: list[tuple[int, AnyForm]] = []
        for sensor in range(len(self.guard.sensors)):
            if self.config.spent(self.guard.cost) and sensor:
                break
            self._use(sensor)
            last = sensor == len(self.guard.sensors) - 1
            own = self.config if last else self.config.before_others(self.guard.cost)
            draft = self._draft if last else None
            form = AnyForm(self._study, own, LATER if sensor else None, bool(sensor), draft)
            yield from form.run()
            self._unless_met(form.reach.come_out)
            cut_short += [(sensor, form)] if own.spent(self.guard.cost) else []
        for sensor, waiting in cut_short:
            if not self.config.spent(self.guard.cost):
                self._use(sensor)
                waiting.config = self.config
                yield from waiting.run()
                self._unless_met(waiting.reach.come_out)
        form.conclude()

    def _use(self, sensor: int) -> None:
        """Turn another of the arrays to the object, off it."""
        if sensor != self.guard.active:
            self._unless_met(partial(retreat, self.guard, self.config.change))
            self.guard.use(sensor)
            self.announce("array", {"name": self.guard.sensor.array.name})

    def _unless_met(self, move: Callable[[], None]) -> None:
        """Move, and stay where the guard stopped it: what comes next finds its way from there."""
        try:
            move()
        except (OverPress, Collision) as error:
            self.found.warnings.append(str(error))

    def _surveyed(self) -> Iterator[Findings]:
        rng = np.random.default_rng(self.config.seed)
        policy = next(p for p in POLICIES if p == self.config.policy)
        yield from map(self._say, Survey(self._study, policy, self.config, rng).run())
        spent = self.config.spent(self.guard.cost)
        self.found.ended = "budget" if spent else "nothing reachable is open"

    def _say(self, note: str) -> Findings:
        self.found.note = note
        self.announce("move", {"note": note, "faces": len(self.found.graph.faces)})
        return self.found

    def _next(self, face: int | None) -> Callable[[], Done] | None:
        """The next move: cross an edge, touch what is untouched, trace an edge; None when nothing is open."""
        if not self.found.named:
            self.found.open = 1
            return self._finding.look_again if self._worth_another_look() else None
        crossing = self._crossing.open_sighting(face)
        if crossing is not None:
            return lambda: self._crossing.cross(*crossing)
        self._lay()
        frontier = Frontier(self.found.graph.faces, self._around())
        bare = frontier.untouched(self.pad.covered, self.config.feature / 2.0)
        untouched = self._open_to(bare)
        self._hidden = len(bare.points) - len(untouched.points)
        missing = self._crossing.this_side(self._tried.unfinished(untouched))
        edges = frontier.open_edges([t for t, _ in self.found.traces])
        edges = [edge for edge in edges if not self._tried.given_up(edge.point)]
        contradicted = frontier.contradicted(self.pad.skin.free)
        opened = self._covering.pressed.unfinished(contradicted)
        doubtful = self._covering.worth_revisiting(self._open_to(frontier.doubtful()))
        self.found.open = len(missing.points) + len(edges) + len(opened.points) + len(doubtful.points)
        if len(missing.points):
            return lambda: self._covering.cover(missing, face)
        if len(opened.points):
            return lambda: self._covering.press_where_free(opened)
        if len(doubtful.points):
            return lambda: self._covering.revisit(doubtful)
        if edges:
            nearest = min(edges, key=lambda e: float(np.linalg.norm(e.point - self.pad.here.point)))
            return lambda: self._tracing.trace(nearest)
        self.found.open = len(untouched.points) + len(contradicted.points)
        return None

    def _worth_another_look(self) -> bool:
        """Whether an object without a face may show one yet."""
        made = self.guard.cost.touches - self._finding.touches
        return max(made, self._finding.looked) < self.config.first_tries

    def _around(self) -> Floats:
        """(6,) box [mm] in which a boundary that is open anywhere is open too: what was touched, and round it.

        The boundary of a convex body hangs together, so who goes on from what was touched comes to all of it.  A
        face whose few contacts let it go on without end predicts no more than others, and next to what was felt.
        """
        points = np.concatenate([face.contacts.points for face in self.found.graph.faces])
        low, high = points.min(axis=0) - self.config.region, points.max(axis=0) + self.config.region
        return np.concatenate([np.maximum(low, self.box[:3]), np.minimum(high, self.box[3:])])

    def _lay(self) -> None:
        """Add the face that lies on the table, once another is known."""
        faces = self.found.graph.faces
        if self.told is None or not faces or any((f.contacts.touch == NOT_FELT).all() for f in faces):
            return
        resting = self.told.resting(np.concatenate([f.contacts.points for f in faces]).mean(axis=0))
        if len(resting):
            self.found.graph, _ = self.found.graph.add_stroke(resting)
            if self._note_resting not in self.found.warnings:
                self.found.warnings.append(self._note_resting)

    _note_resting = "the face that lies on the table is inferred from the table"

    def _open_to(self, predicted: Predicted) -> Predicted:
        """Those predicted places that what was told leaves room at."""
        if self.told is None or not len(predicted.points):
            return predicted
        keep = self.told.leaves_room(predicted.points, predicted.normals)
        return Predicted(predicted.points[keep], predicted.normals[keep], predicted.face[keep])
