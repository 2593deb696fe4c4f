"""Ways round an object of any form: lifted clear of all that was touched, short hops before long ones.

The tool is a box from the skin back to the end of its housing, and the bodies that are moved with it, as of other
arrays on the stage.  A way is free where no touched place lies in a box, a margin wider, at any of its poses; what
was never touched is met under guard (our derivation).
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from exploration.planning.ways.box_kernels import comes_near, free_of, swung
from exploration.sensing.physics.housing import housing_box
from exploration.sensing.spec import SensorSpec, whole_body
from primitives import pose as se3
from primitives.arrays import Bools, Floats

_ALIKE = 0.99  # cosine from which two ways out are one
_FEW = 6  # poses, of which one is looked at before all of them are


@dataclass(frozen=True)
class RoutesConfig:
    """Room round the tool, and what is tried."""

    margin: float = 1.5  # [mm] round the housing
    lifts: tuple[float, ...] = (10.0, 25.0, 60.0, 110.0, 160.0)  # [mm]
    step: float = 5.0  # [mm] between the poses that are looked at
    turn: float = 0.15  # [rad] the same
    swing: float = 8.0  # [mm] of the farthest corner, the same where the tool is long
    far: float = 50.0  # [mm] of lift, from which a corner on the way is tried
    barred: float = 4.0  # [mm] from a pose at which something was in the way, that it is so yet
    barred_turn: float = 0.15  # of the attitude's matrix, the same
    leading_off: float = 0.1  # share of these, by which a way may come nearer than it began


@dataclass(frozen=True)
class Carried:
    """A box that is moved with an array."""

    place: Floats  # (4, 4) sensor_from_box
    low: Floats  # (3,) [mm] in the box's own frame
    high: Floats


@dataclass(frozen=True)
class Tool:
    """The box of one array, and what is carried beside it."""

    low: Floats  # (3,) [mm] in the sensor's frame
    high: Floats
    carried: tuple[Carried, ...] = ()
    mount: Floats = field(default_factory=lambda: np.eye(4))  # flange_from_sensor

    @staticmethod
    def of(spec: SensorSpec) -> Tool:
        """Skin and housing."""
        low, high = housing_box(spec)
        return Tool(low, np.array([high[0], high[1], 0.0]))

    @staticmethod
    def of_size(size: tuple[float, float]) -> Tool:
        """Where nothing is known but the array's size [mm]: a housing a little wider and as deep as it may be."""
        half = np.array([size[0] / 2 + 1.0, size[1] / 2 + 1.0])
        return Tool(np.array([-half[0], -half[1], -60.0]), np.array([half[0], half[1], 0.0]))

    @staticmethod
    def each(specs: Sequence[SensorSpec], flange_from_sensor: Sequence[Floats]) -> tuple[Tool, ...]:
        """The tool that each of the arrays on one stage is, with all others carried."""
        bodies = [housing_box(replace(spec, housing=whole_body(spec))) for spec in specs]
        return tuple(
            replace(
                Tool.of(spec),
                mount=mount,
                carried=tuple(
                    Carried(se3.inverse(mount) @ other, *body)
                    for other, body in zip(flange_from_sensor, bodies, strict=True)
                    if other is not mount
                ),
            )
            for spec, mount in zip(specs, flange_from_sensor, strict=True)
        )

    @property
    def corners(self) -> Floats:
        """(8 n, 3) [mm] of all its boxes, in the sensor's frame."""
        boxes = [_corners(self.low, self.high)]
        return np.concatenate(
            [*boxes, *(se3.transform_points(c.place, _corners(c.low, c.high)) for c in self.carried)]
        )

    def clear(self, poses: Floats, obstacles: Floats, margin: float, front: float) -> Bools:
        """(k,) whether no obstacle lies in the box at (k, 4, 4) poses; `front` [mm] is added before the skin."""
        if not len(obstacles):
            return np.ones(len(poses), dtype=bool)
        places, low, high = self._boxes
        ahead = high + margin
        ahead[0, 2] = high[0, 2] + front
        return np.asarray(free_of(np.ascontiguousarray(poses), obstacles, places, low - margin, ahead))

    @cached_property
    def _boxes(self) -> tuple[Floats, Floats, Floats]:
        """(b, 4, 4) places and (b, 3) least and greatest corners [mm] of the array's box and of those carried."""
        return (
            np.stack([np.eye(4), *(box.place for box in self.carried)]),
            np.stack([self.low, *(box.low for box in self.carried)]),
            np.stack([self.high, *(box.high for box in self.carried)]),
        )


def _corners(low: Floats, high: Floats) -> Floats:
    return np.array(list(itertools.product(*zip(low, high, strict=True))))


def route(
    tool: Tool,
    start: Floats,
    goal: Floats,
    obstacles: Floats,
    ways: Floats,
    config: RoutesConfig = RoutesConfig(),
    barred: Sequence[Floats] = (),
) -> list[Floats] | None:
    """The shortest free way that was found from one pose to another; None where there is none.

    `ways` (n, 3) are directions that may lead out, beside those of the pad's own normals; at poses near to (4, 4)
    `barred` ones something unknown was in the way.
    """
    legs = _Legs(tool, start, goal, obstacles, config, np.array(barred).reshape(-1, 4, 4))
    tried = _shortest_first(start, goal, ways, config)
    return next((legs.poses(stops) for stops in tried if legs.free(stops)), None)


def _shortest_first(start: Floats, goal: Floats, ways: Floats, config: RoutesConfig) -> Iterator[Floats]:
    """(2, 3) or (3, 3) stops [mm] of ways up, across and down again; far up also round a corner."""
    back, front = -start[:3, 2], -goal[:3, 2]
    firsts, lasts, alike = np.array([back, *ways]), np.array([front, *ways]), np.array([back, front, *ways])
    i, j = np.nonzero(firsts @ lasts.T < _ALIKE)
    up, down = np.concatenate([alike, firsts[i]]), np.concatenate([alike, lasts[j]])
    apart = np.arange(len(up)) >= len(alike)
    lots = []
    for lift in config.lifts:
        away, near = start[:3, 3] + lift * up, goal[:3, 3] + lift * down
        lots.append((away, near, near))
        if lift > config.far:
            corner = 0.5 * (away + near) + lift * (up + down)
            lots.append((away[apart], corner[apart], near[apart]))
    away, corner, near = (np.concatenate(places) for places in zip(*lots, strict=True))
    ends = [start[:3, 3], away, corner, near, goal[:3, 3]]
    length = sum(np.linalg.norm(b - a, axis=1) for a, b in itertools.pairwise(np.broadcast_arrays(*ends)))
    stops, straight = np.stack([away, corner, near], axis=1), (corner == near).all(axis=1)
    for n in np.argsort(length, kind="stable"):
        yield stops[n, ::2] if straight[n] else stops[n]


class _Legs:
    """The legs of one search, of which many ways share their first and their last.

    All of them turn from the attitude of the start to that of the goal on the way from the first stop to the next.
    """

    def __init__(
        self, tool: Tool, start: Floats, goal: Floats, obstacles: Floats, config: RoutesConfig, barred: Floats
    ) -> None:
        self._tool, self._obstacles, self._config, self._barred = tool, obstacles, config, barred
        self._start, self._goal = start, goal
        self._turn = min(config.turn, config.swing / float(np.linalg.norm(tool.corners, axis=1).max()))
        self._turning = _turn_of(start, goal, tool.mount)
        self._known: dict[tuple[int, bytes], bool] = {}

    def free(self, stops: Floats) -> bool:
        """Whether nothing is in the way over (k, 3) stops to the goal; what most ways share is asked first."""
        return all(self._leg(stops, leg) for leg in (0, -1, *range(1, len(stops))))

    def poses(self, stops: Floats) -> list[Floats]:
        """(4, 4) poses at (k, 3) stops, and the goal."""
        turned = [se3.pose(self._goal[:3, :3], at) for at in stops[1:]]
        return [se3.pose(self._start[:3, :3], stops[0]), *turned, self._goal]

    def _leg(self, stops: Floats, leg: int) -> bool:
        """Whether the leg to a stop is free; -1 is the one to the goal."""
        ends = stops[leg:] if leg == -1 else stops[max(leg - 1, 0) : leg + 1]
        key = leg, ends.tobytes()
        if key not in self._known:
            poses = [self._start, *self.poses(stops)]
            a, b = poses[-2:] if leg == -1 else poses[leg : leg + 2]
            self._known[key] = self._is_free(a, b, leg)
        return self._known[key]

    def _is_free(self, a: Floats, b: Floats, leg: int) -> bool:
        turn = np.zeros(3) if (a[:3, :3] == b[:3, :3]).all() else self._turning
        between = _swung(a, b, self._tool.mount, turn, self._config.step, self._turn)
        between = between[2:] if leg == 0 else between  # the pad leaves what it lies beside
        front = self._config.margin if leg > 0 else 0.0
        margin = self._config.margin if leg != 0 else 0.3
        few = between[_FEW // 2 :: _FEW]  # of a leg in whose way something is, most of these are so
        for poses in (few, between):
            if not self._tool.clear(poses, self._obstacles, margin, front).all():
                return False
        return not self._is_barred(a, between)

    def _is_barred(self, start: Floats, poses: Floats) -> bool:
        """Whether a (k, 4, 4) leg comes near to a barred pose; one that starts near to it must lead off."""
        c = self._config
        near = c.barred, c.barred_turn, c.leading_off
        return bool(comes_near(start, np.ascontiguousarray(poses), self._barred, *near))


def on_the_way(a: Floats, b: Floats, mount: Floats, most: float, most_turn: float) -> Floats:
    """(k, 4, 4) poses of an array as a stage goes: its flange straight, so that an array on an arm swings."""
    return _swung(a, b, mount, _turn_of(a, b, mount), most, most_turn)


def _turn_of(a: Floats, b: Floats, mount: Floats) -> Floats:
    """(3,) rotation vector of the flange between (4, 4) poses of an array."""
    off = mount[:3, :3].T
    return se3.rotation_log(b[:3, :3] @ off @ (a[:3, :3] @ off).T)


def _swung(a: Floats, b: Floats, mount: Floats, turn: Floats, most: float, most_turn: float) -> Floats:
    at = -mount[:3, :3].T @ mount[:3, 3]
    line = (b[:3, :3] - a[:3, :3]) @ at + b[:3, 3] - a[:3, 3]
    count = int(max(np.linalg.norm(line) / most, np.linalg.norm(turn) / most_turn)) + 2
    start, goal = np.ascontiguousarray(a), np.ascontiguousarray(b)
    return np.asarray(swung(start, goal, np.ascontiguousarray(mount), turn, count))
