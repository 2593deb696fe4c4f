"""Ways round an object of any form: lifted clear of all that was touched, short hops before long ones.

The tool is a box from the skin back to the end of its housing.  A way is free where no touched place lies in the
box, a margin wider, at any of its poses; what was never touched is met under guard (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from exploration.sensing.physics.housing import housing_box
from exploration.sensing.spec import SensorSpec
from primitives import pose as se3
from primitives.arrays import Bools, Floats


@dataclass(frozen=True)
class RoutesConfig:
    """Room round the tool, and what is tried."""

    margin: float = 1.5  # [mm] round the housing
    lifts: tuple[float, ...] = (10.0, 25.0, 60.0, 110.0, 160.0)  # [mm]
    step: float = 5.0  # [mm] between the poses that are looked at
    turn: float = 0.15  # [rad] the same
    lever: float = 60.0  # [mm] of way that a radian costs


@dataclass(frozen=True)
class Tool:
    """The box of one array."""

    low: Floats  # (3,) [mm] in the sensor's frame
    high: Floats

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

    def clear(self, poses: Floats, obstacles: Floats, margin: float, front: float) -> Bools:
        """(k,) whether no obstacle lies in the box at (k, 4, 4) poses; `front` [mm] is added before the skin."""
        out = np.ones(len(poses), dtype=bool)
        if not len(obstacles):
            return out
        low = self.low - margin
        high = np.array([self.high[0] + margin, self.high[1] + margin, self.high[2] + front])
        for k, pose in enumerate(poses):
            local = (obstacles - pose[:3, 3]) @ pose[:3, :3]
            out[k] = not bool(((local > low) & (local < high)).all(axis=1).any())
        return out


def route(
    tool: Tool,
    start: Floats,
    goal: Floats,
    obstacles: Floats,
    ways: Floats,
    config: RoutesConfig = RoutesConfig(),
) -> list[Floats] | None:
    """The shortest free way that was found from one pose to another; None where there is none.

    `ways` (n, 3) are directions that may lead out, beside those of the pad's own normals.
    """
    tried = sorted(_candidates(start, goal, ways, config), key=lambda poses: _length(start, poses, config))
    for poses in tried:
        if _free(tool, start, poses, obstacles, config):
            return poses
    return None


def _candidates(start: Floats, goal: Floats, ways: Floats, config: RoutesConfig) -> Iterator[list[Floats]]:
    back, front = -start[:3, 2], -goal[:3, 2]
    for lift in config.lifts:
        for way in (back, front, *ways):
            yield [_lifted(start, lift * way), _lifted(goal, lift * way), goal]
        for first in (back, *ways):
            for last in (front, *ways):
                if first @ last < 0.99:
                    away, near = _lifted(start, lift * first), _lifted(goal, lift * last)
                    yield [away, near, goal]
                    if lift > 50.0:
                        corner = se3.pose(near[:3, :3], 0.5 * (away + near)[:3, 3] + lift * (first + last))
                        yield [away, corner, near, goal]


def _lifted(pose: Floats, by: Floats) -> Floats:
    return se3.pose(pose[:3, :3], pose[:3, 3] + by)


def _free(tool: Tool, start: Floats, poses: list[Floats], obstacles: Floats, config: RoutesConfig) -> bool:
    at = start
    for number, pose in enumerate(poses):
        between = _between(at, pose, config)
        front = 0.0 if number in (0, len(poses) - 1) else config.margin
        margin = 0.3 if number == 0 else config.margin
        if number == 0:
            between = between[2:]  # the pad leaves what it lies beside
        if not tool.clear(between, obstacles, margin, front).all():
            return False
        at = pose
    return True


def _between(a: Floats, b: Floats, config: RoutesConfig) -> Floats:
    """(k, 4, 4) poses on the straight way, as a stage goes it."""
    line = b[:3, 3] - a[:3, 3]
    turn = se3.rotation_log(b[:3, :3] @ a[:3, :3].T)
    count = int(max(np.linalg.norm(line) / config.step, np.linalg.norm(turn) / config.turn)) + 2
    shares = np.linspace(0.0, 1.0, count)
    return np.stack([se3.pose(se3.rotation_exp(s * turn) @ a[:3, :3], a[:3, 3] + s * line) for s in shares])


def _length(start: Floats, poses: list[Floats], config: RoutesConfig) -> float:
    total, at = 0.0, start
    for pose in poses:
        total += float(np.linalg.norm(pose[:3, 3] - at[:3, 3]))
        total += config.lever * float(np.linalg.norm(se3.rotation_log(pose[:3, :3] @ at[:3, :3].T)))
        at = pose
    return total
