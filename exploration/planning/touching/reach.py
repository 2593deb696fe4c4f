"""The pad among what it has touched so far: whether it has room at a place, and touching there by a free way."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from exploration.control.feel import feel
from exploration.control.kept_contacts import touched_cells
from exploration.control.procedures.approach import retreat, touched
from exploration.control.procedures.land import AS_TOLD, LandConfig
from exploration.control.procedures.settle import SettleConfig
from exploration.control.steady_flight import FlightConfig, fly
from exploration.devices.guard import Collision, Observation, OverPress
from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.touching.pad import Pad
from exploration.planning.ways.routes import RoutesConfig, on_the_way, route
from primitives import pose as se3
from primitives.arrays import Floats, frozen

_HALF_TURN = frozen(np.diag([-1.0, -1.0, 1.0, 1.0]))


@dataclass(frozen=True)
class ReachConfig:
    """How a place is come at."""

    standoff: float = 10.0  # [mm] before the last, guarded advance
    overtravel: float = 8.0  # [mm]
    back: float = 4.0  # [mm] from what was met on the way
    rise: float = 6.0  # [mm] straight off what the pad lies on, where a wall beside it leaves no other way
    out: float = 4.0  # [mm] of the housing that stay out of what it goes into
    under: float = 5.0  # [mm] aside, up to which a place is under a lid
    wide: float = 3.5  # [mm] round what is carried on long arms, where ways are as free as that
    room: float = 0.6  # [mm] round the housing, where the pad is to lie
    proud: float = 1.6  # [mm] before the skin there, that may be known: blur lays touched places past an edge
    alike: float = 0.85  # cosine from which two ways out are one
    looked: float = 4.0  # [mm] between poses of a way, at which it is asked whether anybody has been there
    looked_turn: float = 0.05  # [rad] the same
    give: float = 8.0  # [mm] off a place that what is known reaches into, from where it is come at yet
    step: float = 1.6  # [mm] between such tries
    back_most: int = 128  # stops back the way it came, where no other way leads on


class Reach:
    """Where the pad has room; `led` says whether there was a way to the last target."""

    def __init__(self, pad: Pad, config: ReachConfig = ReachConfig()) -> None:
        self.pad, self.config = pad, config
        self.led = False
        self.lids: tuple[Floats, Floats] = (np.empty((0, 3)), np.empty((0, 3)))  # of what was not gone into
        self._inside: tuple[Floats, Floats] | None = (
            None  # (3,) a place over the mouth it is in, and the way out
        )
        wide = RoutesConfig(margin=config.wide)  # of edges the places felt last lie a taxel inside
        self._routes = (wide, RoutesConfig()) if pad.tool.carried else (RoutesConfig(),)
        self._felt = SurfaceMap()
        self._barred: list[Floats] = []  # (4, 4) where something unknown stopped the array on its way
        self._suspect: Floats = np.empty((0, 3))  # [mm] before it there, where that may stand

    @property
    def felt(self) -> SurfaceMap:
        """All that was touched until now."""
        self._felt.take(self.pad.felt)
        return self._felt

    def clear(self, pose: Floats) -> bool:
        """Whether nothing touched is in the way of the pad and its housing at a (4, 4) pose."""
        return bool(self.with_room([pose]))

    def with_room(self, poses: Sequence[Floats]) -> list[Floats]:
        """Those of (4, 4) poses at which it is clear."""
        clear = self.pad.tool.clear(np.array(poses), self._obstacles(), self.config.room, -self.config.proud)
        return [pose for pose, free in zip(poses, clear, strict=True) if free]

    def touch(
        self,
        target: Floats,
        give: bool = False,
        settling: SettleConfig | None = None,
        landing: LandConfig | None = None,
    ) -> bool:
        """Go round what is known to before a (4, 4) target, and touch it; may it `give`, from farther off.

        The array may lie there turned by half a turn: to the attitude that is nearer the way is shorter.
        """
        for either in self._either_way_round(target):
            off = self.off(either, self.config.give) if give else 0.0
            goal = either @ se3.pose(translation=[0.0, 0.0, -off])
            under = self._under_lid(goal)
            standoff = self.config.standoff + under
            if self._before(goal, standoff):
                if under > 0.0:
                    self._inside = (goal[:3, 3] - standoff * goal[:3, 2], -goal[:3, 2])
                return self.pad.touch(goal, standoff, self.config.overtravel + off, settling, landing)
            if self.led:
                return False
        return False

    def seconds_to(self, points: Floats, facing: Floats) -> Floats:
        """[s] about, to where the pad lies at (..., 3) points that look (..., 3) out, first flown, then turned."""
        here, flight = self.pad.guard.world_from_sensor, FlightConfig()
        turn = np.arccos(np.clip(-facing @ here[:3, 2], -1.0, 1.0))
        away = np.linalg.norm(points - here[:3, 3], axis=-1)
        return np.asarray(away / flight.speed + turn / flight.turn)

    def _either_way_round(self, target: Floats) -> tuple[Floats, Floats]:
        """A (4, 4) pose and the same half a turn on, that nearer to the attitude of now first."""
        here, turned = self.pad.guard.world_from_sensor, target @ _HALF_TURN
        ahead, behind = (float(np.trace(here[:3, :3].T @ pose[:3, :3])) for pose in (target, turned))
        return (target, turned) if ahead >= behind else (turned, target)

    def descend(
        self,
        target: Floats,
        high: float,
        settling: SettleConfig | None = None,
        landing: LandConfig | None = None,
        deeper: float = 0.0,
    ) -> bool:
        """Come down to a (4, 4) target from over `high` mm before it, until something is touched; or `deeper`."""
        if not self._before(target, self.config.standoff + high):
            return False
        on = self.config.overtravel + deeper
        return self.pad.touch(target, self.config.standoff + high, on, settling, landing)

    def off(self, target: Floats, most: float) -> float:
        """[mm] before a (4, 4) target, at which nothing known is in its way; 0 where that is `most` or more."""
        tried = np.arange(0.0, max(most, self.config.step), self.config.step)
        poses = target @ se3.pose(translation=np.outer(tried, [0.0, 0.0, -1.0]))
        room = self.pad.tool.clear(poses, self._obstacles(), self.config.room, -self.config.proud)
        return float(tried[np.argmax(room)])

    def sound(self, target: Floats, settling: SettleConfig | None = None) -> bool:
        """Go in from a (4, 4) target, as deep as the array is long, until something is touched."""
        if not self._before(target, self.config.standoff):
            return False
        self._inside = (target[:3, 3] - self.config.standoff * target[:3, 2], -target[:3, 2])
        deep = -float(self.pad.tool.low[2]) - self.config.out
        return self.pad.touch(target, self.config.standoff, deep, settling, AS_TOLD)

    def at_lid(self, point: Floats) -> bool:
        """Whether a (3,) point is at the rim of a mouth, or in it."""
        return bool((np.linalg.norm(self.lids[0] - point, axis=1) < self.config.under).any())

    def come_out(self) -> None:
        """Straight out of what the array went into, whose sides nobody has felt."""
        if self._inside is not None:
            (over, way), here = self._inside, self.pad.guard.world_from_sensor
            self._inside = None
            rise = float((over - here[:3, 3]) @ way)
            if rise > 0.0:
                self.pad.guard.go_to(se3.pose(here[:3, :3], here[:3, 3] + rise * way))

    def _under_lid(self, target: Floats) -> float:
        """[mm] that a (4, 4) target lies behind a mouth that the array looks into; 0 where it does not."""
        local = (self.lids[0] - target[:3, 3]) @ target[:3, :3]
        over = (local[:, 2] < -1.0) & (np.abs(local[:, :2]) < self.config.under).all(axis=1)
        over &= self.lids[1] @ target[:3, 2] < -0.95
        return float(-local[over, 2].min()) if over.any() else 0.0

    def _before(self, target: Floats, back: float) -> bool:
        self.led = False
        self.come_out()
        standoff = target @ se3.pose(translation=[0.0, 0.0, -back])
        obstacles = self._obstacles()
        if not self.clear(target) or not self.pad.tool.clear(standoff[None], obstacles, 1.0, 1.0)[0]:
            return False
        return self.go(standoff)

    def go(self, goal: Floats) -> bool:
        """Round what is known to a (4, 4) goal; whether the pad got there, `led` whether there was a way."""
        self._suspect = self._suspect[~self.pad.swept.holds(self._suspect)]
        start = self.pad.guard.world_from_sensor
        poses = self._routed(start, goal)
        if poses is None and not self.clear(start):
            off = start @ se3.pose(translation=[0.0, 0.0, -self.config.rise])
            poses = self._routed(off, goal)
            if poses is not None:
                retreat(self.pad.guard, self.config.rise)
        if poses is None and (back := self._back_to_where_leads(goal)):
            for stop in back:
                self.pad.guard.go_to(stop)
            poses = self._routed(back[-1], goal)
        self.led = poses is not None
        return poses is not None and all(self._fly(pose, k == 0) for k, pose in enumerate(poses))

    def _back_to_where_leads(self, goal: Floats) -> list[Floats]:
        """(4, 4) stops back the way the array came, to where something leads to a goal; or none."""
        start = self.pad.way_back.start
        if start is None or self._routed(start, goal) is None:
            return []
        for stops in self.pad.way_back.ways():
            if len(stops) > self.config.back_most:
                break
            if self._routed(stops[-1], goal) is not None:
                return stops
        return []

    def _routed(self, start: Floats, goal: Floats) -> list[Floats] | None:
        """(4, 4) poses from one to another round what is known; None where nothing leads there.

        Where nothing does among the fewest places with the least margin, nothing does at all.
        """
        tool, ways = self.pad.tool, self._ways()
        most, *others = (
            partial(route, tool, start, goal, places, ways, config, self._barred)
            for places, config in product(self._in_the_way(), self._routes)
        )
        if (found := most()) is not None or not others:
            return found
        *others, least = others
        nearest = least()
        if nearest is None:
            return None
        return next((found for search in others if (found := search()) is not None), nearest)

    def _in_the_way(self) -> Iterator[Floats]:
        """(n, 3) places to keep off: of all that may stand; of what was felt; and of that, less what was since
        gone through, as a pad across a gap feels what is not there, and may stand right under it.
        """
        known = np.concatenate([self._obstacles(), self.lids[0]])
        if len(self._suspect):
            yield np.concatenate([known, self._suspect])
        yield known
        if (gone := self.pad.swept.holds(known)).any():
            yield known[~gone]

    def _fly(self, goal: Floats, first: bool) -> bool:
        """Straight to a (4, 4) goal, slowly where nobody has been; false where it touched something."""
        guard = self.pad.guard
        for stop, known in self._legs(goal):
            until = (lambda seen: False) if first else (lambda seen: touched(seen.image))
            try:
                met = guard.go_to(stop, until) if known else fly(guard, stop, until)
            except (Collision, OverPress) as error:
                self._bar(error.seen)
                raise
            if met is not None:
                self._bar(met)
                retreat(guard, self.config.back)
                return False
        return True

    def _legs(self, goal: Floats) -> list[tuple[Floats, bool]]:
        """Where each leg of the way to a (4, 4) goal ends, and whether an array has been everywhere on it."""
        tool, seen = self.pad.tool, self.pad.swept
        here = self.pad.guard.world_from_sensor
        poses = on_the_way(here, goal, tool.mount, self.config.looked, self.config.looked_turn)
        known = [seen.holds_box(pose, tool.low, tool.high) for pose in poses]
        legs: list[tuple[Floats, bool]] = []
        for pose, before, after in zip(poses[1:], known[:-1], known[1:], strict=True):
            if legs and legs[-1][1] == (before and after):
                legs.pop()
            legs.append((pose, before and after))
        return [*legs[:-1], (goal, legs[-1][1])]

    def _bar(self, seen: Observation | None) -> None:
        """Remember where something unknown was in the way, and what of it the skin felt."""
        if seen is None:
            return
        here, tool = seen.world_from_sensor, self.pad.tool
        self._barred.append(here)
        self._suspect = np.concatenate([self._suspect, self.pad.swept.ahead(here, tool.low, tool.high)])
        if felt := feel(seen.image):
            cells = touched_cells(seen, felt)
            self.pad.felt.append((cells, np.broadcast_to(-here[:3, 2], cells.shape)))

    def _obstacles(self) -> Floats:
        """(n, 3) places of all that is known to stand."""
        told = self.pad.told
        return self.felt.points if told is None else np.concatenate([self.felt.points, told.points])

    def _ways(self) -> Floats:
        """(n, 3) directions that may lead out: the way that each face looks."""
        out: list[Floats] = []
        facing = self.felt.facing
        for normal in [*facing[:: max(1, len(facing) // 200)], *np.eye(3), *-np.eye(3)]:
            if all(normal @ other < self.config.alike for other in out):
                out.append(normal)
        return np.array(out)
