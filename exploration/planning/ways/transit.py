"""Ways through free space around a convex object, from its supporting planes.

Every contact (point, outward normal) of a convex object is a supporting plane: all material lies behind it, so
the open half-space in front is free.  Two such half-spaces that are not opposite share a free wedge, and a path
through it never meets the object (our derivation).  The faces of the workspace box are supporting planes too.
"""

import itertools
from dataclasses import dataclass

import numpy as np

from exploration.planning.ways.routes import Tool, on_the_way
from primitives import pose as se3
from primitives.arrays import Floats


@dataclass(frozen=True)
class TransitConfig:
    """How far the array keeps away while it travels."""

    clearance: float = 62.0  # [mm] of the sensor's origin; covers pad and housing at any attitude
    farthest: float = 450.0  # [mm] from the middle of a way, beyond which another is preferred
    wedge: float = -0.5  # least cosine between two normals whose shared wedge is used directly
    beside: float = 2.0  # [mm] kept between what is carried and a supporting plane
    step: float = 20.0  # [mm] between the poses that are looked at
    turn: float = 0.15  # [rad] the same


@dataclass(frozen=True)
class Support:
    """A supporting plane."""

    point: Floats  # (3,) [mm]
    normal: Floats  # (3,) outward


def box_supports(box: Floats) -> list[Support]:
    """The six faces of a (6,) workspace box x0, y0, z0, x1, y1, z1."""
    low, high = box[:3], box[3:]
    axes = np.eye(3)
    return [Support(low, -axis) for axis in axes] + [Support(high, axis) for axis in axes]


def way(
    start: Floats,
    near: Support,
    goal: Floats,
    far: Support,
    supports: list[Support],
    config: TransitConfig = TransitConfig(),
) -> list[Floats]:
    """Poses (4, 4) from `start`, in front of `near`, to `goal`, in front of `far`; the shortest over one stop."""
    stops: list[Support | None] = [None, *supports]
    ways = [w for stop in stops if (w := _via(start, near, stop, goal, far, config))]
    middle = 0.5 * (start[:3, 3] + goal[:3, 3])
    compact = [w for w in ways if all(np.abs(p[:3, 3] - middle).max() < config.farthest for p in w)]
    return min(compact or ways, key=lambda w: _length(start, w))


def keeps_clear(tool: Tool, start: Floats, poses: list[Floats], supports: list[Support]) -> bool:
    """Whether the tool's corners stay in front of one supporting plane or another all the way."""
    config, corners = TransitConfig(), tool.corners
    for a, b in itertools.pairwise([start, *poses]):
        for place in on_the_way(a, b, tool.mount, config.step, config.turn):
            at = se3.transform_points(place, corners)
            if not any((((at - s.point) @ s.normal) > config.beside).all() for s in supports):
                return False
    return True


def _via(
    start: Floats, near: Support, stop: Support | None, goal: Floats, far: Support, config: TransitConfig
) -> list[Floats]:
    legs = [near, far] if stop is None else [near, stop, far]
    if any(a.normal @ b.normal < config.wedge for a, b in itertools.pairwise(legs)):
        return []
    at = start[:3, 3] + near.normal * _short(start[:3, 3], near, config.clearance)
    points = [at]
    for a, b in itertools.pairwise(legs):
        points.append(_into_wedge(points[-1], a, b, config.clearance))
    above = goal[:3, 3] + far.normal * _short(goal[:3, 3], far, config.clearance)
    points.append(above)
    turns = np.linspace(0.0, 1.0, len(points))
    turn = se3.rotation_log(goal[:3, :3] @ start[:3, :3].T)
    poses = [
        se3.pose(se3.rotation_exp(turn * share) @ start[:3, :3], point)
        for share, point in zip(turns, points, strict=True)
    ]
    return [*poses, goal]


def _into_wedge(point: Floats, a: Support, b: Support, clearance: float) -> Floats:
    """The nearest point to `point`, itself in front of `a`, that is `clearance` in front of both planes."""
    short = clearance - (point - b.point) @ b.normal
    if short <= 0.0:
        return point
    straight: Floats = point + short * b.normal
    if (straight - a.point) @ a.normal >= clearance:
        return straight
    if a.normal @ b.normal > 0.999:
        return straight
    normals = np.stack([a.normal, b.normal])
    need = np.array([clearance - (point - a.point) @ a.normal, short])
    step: Floats = point + normals.T @ np.linalg.solve(normals @ normals.T, need)
    return step


def _short(point: Floats, support: Support, clearance: float) -> float:
    """How much [mm] a point lacks to be `clearance` in front of a plane."""
    return max(0.0, clearance - float((point - support.point) @ support.normal))


def _length(start: Floats, poses: list[Floats]) -> float:
    """Path length [mm], with turning counted at 60 mm a radian."""
    path = [start, *poses]
    steps = sum(float(np.linalg.norm(b[:3, 3] - a[:3, 3])) for a, b in itertools.pairwise(path))
    turn = float(np.linalg.norm(se3.rotation_log(start[:3, :3].T @ poses[-1][:3, :3])))
    return steps + 60.0 * turn
