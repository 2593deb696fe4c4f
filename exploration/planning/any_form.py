"""Explore an object of any form: face by face, to rims and walls, until nothing that the pad can reach is open.

Three kinds of things are open.  A wall that ended a stroke, and no known face explains: the pad turns to face it.
A rim that no known face explains: the pad rolls over it.  Surface that goes on where nothing was felt: the pad
strokes toward it, or comes down on it.  What stopped a stroke and cannot be faced is climbed; what the skin ran
into on its way is touched; what was met and belongs to no face is followed until it makes one.  Last comes what a
draft of the object has and nobody felt.  Inside edges are where two touched faces meet, because no taxel looks
sideways.  What was tried in vain a few times is given up, and left unknown.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import partial

import numpy as np

from exploration.devices.guard import Collision, OverPress
from exploration.planning.inferring.concluding import conclude, tell_openings
from exploration.planning.inferring.explained_rims import unexplained
from exploration.planning.inferring.far_ends import WHERE_TO_LOOK, far_ends, narrower_ends
from exploration.planning.inferring.inferred_walls import stops_of
from exploration.planning.moves.along_land import AlongLand
from exploration.planning.moves.bores import Bores
from exploration.planning.moves.bumped import Bumped
from exploration.planning.moves.climbing import Climbing
from exploration.planning.moves.drafted import Drafted
from exploration.planning.moves.entering import Entering
from exploration.planning.moves.ledges import Ledges
from exploration.planning.moves.looking import LOOK_AGAIN, Looking, LookingConfig
from exploration.planning.moves.nameless import Nameless
from exploration.planning.moves.open_surface import OpenSurface
from exploration.planning.moves.rim_looks import RimLooks
from exploration.planning.moves.rolling import Rolling, RollingConfig
from exploration.planning.moves.round_holes import RoundHoles
from exploration.planning.moves.slipped import Slipped
from exploration.planning.moves.wall_facing import face_wall
from exploration.planning.moves.wall_tops import WallTops
from exploration.planning.open.frontier import Predicted
from exploration.planning.open.local_frontier import LocalFrontier
from exploration.planning.open.ring_ends import bare_ends
from exploration.planning.open.round_rims import RoundRim
from exploration.planning.touching.explained import unexplained_stops
from exploration.planning.touching.findings import Attempts, Done, ExplorerConfig, Findings, SeenRim
from exploration.planning.touching.overhung import Overhung
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study, Wall
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT
from primitives.fit import NoFit
from primitives.patch_graph import Face, PatchGraph


@dataclass(frozen=True)
class AnyFormConfig:
    """How walls, rims and open surface are gone for."""

    rolling: RollingConfig = field(default_factory=RollingConfig)
    wall_tries: int = 2
    vain: int = 12  # looks at walls that were not there, from which no more of them are believed
    worth: int = 3  # of those, that a wall found makes up for
    beside: float = 9.0  # [mm] between tries that count as one


_NAMELESS = NoFit("contacts that named no face")
LATER = AnyFormConfig(RollingConfig(tries=1))  # of what other arrays have tried before


class AnyForm:
    """Carries on where the object has turned out not to be convex."""

    def __init__(
        self,
        study: Study,
        config: ExplorerConfig,
        own: AnyFormConfig | None = None,
        later: bool = False,
        draft: Callable[[Findings], Predicted] | None = None,
    ) -> None:
        self.study, self.config, self.own = study, config, own or AnyFormConfig()
        self.pad, self.found = study.pad, study.found
        self.reach = Reach(self.pad)
        self._walls = Attempts(self.own.wall_tries, self.own.beside)
        self._rolling = Rolling(study, self.reach, self.own.rolling)
        self._open = OpenSurface(study, self.reach, config)
        self._entering = Entering(study, self.reach) if later else None
        self._slipped = Slipped(study, self.reach) if later else None
        self._ledges = Ledges(study, self.reach) if later else None
        self._bores = Bores(study, self.reach)
        self._holes, self._rim_looks = RoundHoles(study, self.reach), RimLooks(study, self.reach)
        self._wall_tops, self._lands = WallTops(study, self.reach), AlongLand(study, self.reach)
        self._nameless, self._overhung = Nameless(study, self.reach), Overhung()
        self._climbing, self._vain = Climbing(study, self.reach), 0
        self._bumped = Bumped(study, self.reach)
        self._looking = Looking(study, self.reach, LOOK_AGAIN if later else LookingConfig())
        self._drafted: Drafted | None = None
        if draft is not None:
            drawn = partial(self._drafted_by, draft)
            self._drafted = Drafted(study, self.reach, drawn, self._open.alongs, self._looking)
        self._last: tuple[tuple[int, ...], PatchGraph, LocalFrontier] | None = None
        study.reconsider()
        self._before = self.found.named

    def run(self) -> Iterator[str]:
        """Make moves until nothing is left to try; yields what each one did."""
        face: int | None = None
        while not self.config.spent(self.pad.guard.cost):
            move = self._next(face)
            if move is None and (self.study.merge() or self.study.name_loose()):
                continue
            if move is None:
                break
            try:
                done, note = move()
            except (OverPress, Collision) as error:
                self.study.back_off(error)
                done, note = None, f"backed off: {error}"
            face = done
            yield note
        self.study.name_loose()  # of what time or touches ran out for

    def conclude(self) -> None:
        """Infer what no array could lie on, once every one of them has nothing left to try."""
        if len(felt := self.reach.felt.points):
            self.found.inside.append(self.pad.swept.between(felt.min(axis=0), felt.max(axis=0)))
        self.found.strip_ends = self.pad.strip_ends
        table = None if self.pad.told is None else self.pad.told.table
        conclude(self.found, self._unexplained, self._frontier, self.pad.skin.mosaic, table)
        if len(self.study.loose):
            graph = self.found.graph
            rest = Face(1 + max((f.id for f in graph.faces), default=-1), _NAMELESS, self.study.loose)
            self.found.graph = replace(graph, faces=(*graph.faces, rest))
        tell_openings(self.found)

    def _drafted_by(self, draft: Callable[[Findings], Predicted]) -> Predicted:
        """The surface of what would be concluded now; nothing of it is kept."""
        found = self.found
        kept = {each.name: getattr(found, each.name) for each in fields(found)}
        try:
            for name, value in kept.items():
                setattr(found, name, list(value) if isinstance(value, list) else value)
            self.conclude()
            return draft(found)
        finally:
            for name, value in kept.items():
                setattr(found, name, value)

    def _frontier(self) -> LocalFrontier:
        """Of this moment: the last one, where nothing was felt since."""
        graph, felt, free = self.found.graph, self.reach.felt, self.pad.skin.free.points
        pits = self.pad.skin.pits.sure
        known = (id(graph), len(felt.points), len(free), sum(pit.times for pit in pits))
        if self._last is None or self._last[0] != known:
            last = self._last[-1] if self._last else None
            mosaic = self.pad.skin.mosaic
            now = LocalFrontier(
                graph.faces, felt, free, self.config.feature, last=last, pits=pits, mosaic=mosaic
            )
            self._last = known, graph, now
        return self._last[-1]

    def _next(self, face: int | None) -> Callable[[], Done] | None:
        frontier = self._frontier()
        opened, rims = frontier.open, frontier.rims
        walls = self._open_walls()
        self.found.open = len(opened.points) + len(rims) + len(walls)
        left = self._open.left(opened.on(self._own_faces()) if self._entering else opened)
        goal = None if face is None else self._open.near(left, face)
        if face is not None and goal is not None and self._lies():
            return partial(self._open.stroke_to, goal, face)
        ways_in = self._entering.ways_in(frontier.mouths(), self._open.alongs) if self._entering else ()
        if into := list(ways_in):
            here = self.pad.guard.world_from_sensor[:3, 3]
            return min(into, key=lambda item: float(np.linalg.norm(item[0] - here)))[1]
        if self._slipped and (move := self._slipped.next(self._open.alongs)) is not None:
            return move
        if self._ledges and (move := self._ledges.next(frontier.openings)) is not None:
            return move
        lain = [wall for wall in walls if wall.lay_on_one_of(self.found.graph.faces)]
        return (
            self._soonest(lain, rims)
            or self._climbing.next(lain)
            or self._come_down(left)
            or self._bumped.next()
            or self._lands.next()
            or self._nameless.next()
            or (self._looking.next() if self._entering else self._look(frontier))
            or self._bores.next(frontier.round_gaps)
            or (self._drafted.next() if self._drafted else None)
        )

    def _soonest(self, walls: Sequence[Wall], rims: Sequence[SeenRim]) -> Callable[[], Done] | None:
        """To the wall that may be faced, or the rim that may be rolled over, that is soonest come to."""
        seconds = self.reach.seconds_to
        standing = [wall for wall in walls if self._unread(wall)] if self._vain < self.own.vain else []
        todo: list[tuple[float, Callable[[], Done]]] = [
            (float(seconds(wall.point, -wall.heading)), partial(self._face_wall, wall)) for wall in standing
        ]
        todo += self._rolling.ways(rims)
        return min(todo, key=lambda item: item[0])[1] if todo else None

    def _come_down(self, left: Predicted) -> Callable[[], Done] | None:
        """On the open surface that is soonest come to."""
        if not len(left.points):
            return None
        soonest = int(np.argmin(self.reach.seconds_to(left.points, left.normals)))
        return partial(self._open.come_down, left, soonest)

    def _look(self, frontier: LocalFrontier) -> Callable[[], Done] | None:
        """From afar where nobody was, and at the rims of what has no room for an array."""
        seen, flat = self.found.rims, [own for own in frontier.known if own.fit.kind == "plane"]
        openings = [*frontier.openings, *frontier.narrow, *far_ends(seen, flat, WHERE_TO_LOOK)]
        round_ = [opening for opening in openings if not self._refuted(opening)]
        straight = [rim for rim in frontier.rims if not any(o.holds(rim[0].point) for o in round_)]
        rings = bare_ends(frontier.known, self.found.wall_rims, self._free)
        looks = self._holes.next([*openings, *narrower_ends(seen, flat), *rings])
        return (
            self._looking.next()
            or looks
            or self._rim_looks.next([*straight, *unexplained(self.found.barred, self.found.graph.faces)])
            or self._wall_tops.next(self.found.wall_rims)
            or self._wall_tops.over(stops_of(self._unexplained(), self.found.graph.faces))
        )

    def _free(self) -> Floats:
        """(n, 3) places among what was felt, that the skin found free or an array passed through."""
        felt, free = self.reach.felt.points, self.pad.skin.free.points
        if not len(felt):
            return free
        return np.concatenate([free, self.pad.swept.between(felt.min(axis=0), felt.max(axis=0))])

    def _own_faces(self) -> list[int]:
        """Those that the array in use felt, and no other, as floors of what it alone has room in; and new ones."""
        own = self.pad.guard.active
        felt = (
            (face.id, face.contacts.select(face.contacts.touch != NOT_FELT))
            for face in self.found.graph.faces
        )
        return [
            number
            for number, contacts in felt
            if number not in self._before or (len(contacts) and (contacts.sensor == own).all())
        ]

    def _refuted(self, opening: RoundRim) -> bool:
        """Whether a look has found no round rim there."""
        return any(np.linalg.norm(opening.center - at) < opening.radius for at in self.found.refuted)

    def _lies(self) -> bool:
        """Whether the pad is still on something, and nothing is in the way of its housing."""
        try:
            return self.pad.touches()
        except (OverPress, Collision):
            return False

    def _open_walls(self) -> list[Wall]:
        """What strokes met where no known face stands, and nothing that the housing came to."""
        felt, tool = self.reach.felt, self.pad.tool
        return [wall for wall in self._unexplained() if not self._overhung.holds(wall, felt, tool)]

    def _unexplained(self) -> list[Wall]:
        """What strokes met where no known face stands: under what the housing came to, a wall may yet stand."""
        return unexplained_stops(self.study.walls, self.found.graph.faces)

    def _unread(self, wall: Wall) -> list[Wall]:
        """What it may be, and was not tried for yet."""
        return wall.readings()[self._walls.count(wall.point) : self.own.wall_tries]

    def _face_wall(self, wall: Wall) -> Done:
        """Turn to face what a stroke met, just above the face that the pad lay on."""
        reading = self._unread(wall)[0]
        self._walls.note(wall.point)
        done, note = face_wall(self.study, self.reach, reading)
        self._vain = max(0, self._vain - self.own.worth) if done is not None else self._vain + self.reach.led
        return done, note
