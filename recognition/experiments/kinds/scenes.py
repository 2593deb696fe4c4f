"""Presses at random, and the lines that each shows.

The face that is touched is z = 0 of a scene's frame, material below.  The pad's center is over the origin or
beside it, by at most `REACH` of its short side; it is turned at will and leans a little.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

from exploration.sensing.spec import SensorSpec
from models.csg import Csg, Cube, Sphere
from models.solid import Solid
from primitives.arrays import Floats
from primitives.pose import inverse, pose, rotation_exp, transform_points

REACH = 0.3  # of the pad's short side
LEAN = 0.01  # [rad] 1 sigma about each axis of the pad
FAR = 300.0  # [mm] sides of what has no end
WIDTHS = (4.0, 8.0)  # [mm] of walls and slots
RADII = (10.0, 20.0, 40.0)  # [mm] of balls
ROUND = 2e-4  # of its radius, between a ball and its facets
Segment = tuple[tuple[float, float], tuple[float, float]]


@dataclass(frozen=True)
class Press:
    """A pad on a scene."""

    solid: Solid
    world_from_sensor: Floats  # (4, 4)
    lines: tuple[tuple[float, float], ...]  # angle [rad], offset [mm] of each


def pressed(scene: str, spec: SensorSpec, rng: np.random.Generator) -> Press:
    """One press of a kind, as deep as the array is meant to be pressed."""
    size = float(rng.choice(RADII) if scene == "ball" else np.round(rng.uniform(*WIDTHS), 1))
    solid, edges = _solid(scene, size)
    reach = REACH * min(spec.array.size)
    x, y = rng.uniform(-reach, reach, 2)
    turn, lean = rng.uniform(-np.pi, np.pi), rng.normal(0.0, LEAN, 2)
    depth = -20.0 if scene == "nothing" else spec.press_depth
    down = np.diag([1.0, -1.0, -1.0]) @ rotation_exp([0.0, 0.0, turn]) @ rotation_exp([*lean, 0.0])
    at = pose(down, [x, y, -depth])
    return Press(solid, at, tuple(_seen(at, edge) for edge in edges))


def _seen(world_from_sensor: Floats, edge: Segment) -> tuple[float, float]:
    """The line of the scene's face as the pad sees it, looking along its own normal."""
    ends = transform_points(inverse(world_from_sensor), np.array([[*point, 0.0] for point in edge]))[:, :2]
    along = ends[1] - ends[0]
    angle = float(np.arctan2(along[1], along[0]))
    return angle, float(ends[0] @ [-np.sin(angle), np.cos(angle)])


@cache
def _solid(scene: str, size: float) -> tuple[Solid, tuple[Segment, ...]]:
    half, thick = FAR / 2, 30.0
    across: Segment = ((0.0, 0.0), (1.0, 0.0))
    if scene == "edge":
        return _block((0.0, FAR), (-half, half), thick), (across_y(0.0),)
    if scene == "corner":
        return _block((0.0, FAR), (0.0, FAR), thick), (across_y(0.0), across)
    if scene == "wall":
        return _block((-size / 2, size / 2), (-half, half), thick), (across_y(-size / 2), across_y(size / 2))
    if scene == "slot":
        left = _cube((-half, -size / 2), (-half, half), (-thick, 0.0))
        right = _cube((size / 2, half), (-half, half), (-thick, 0.0))
        floor = _cube((-half, half), (-half, half), (-2 * thick, -thick))
        return Solid.from_csg(left | right | floor), (across_y(-size / 2), across_y(size / 2))
    if scene == "ball":
        return Solid.from_csg(Sphere(size).at(0.0, 0.0, -size), ROUND * size), ()
    return _block((-half, half), (-half, half), thick), ()


def across_y(x: float) -> Segment:
    """The line along y at `x`."""
    return (x, 0.0), (x, 1.0)


def _block(x: tuple[float, float], y: tuple[float, float], thick: float) -> Solid:
    return Solid.from_csg(_cube(x, y, (-thick, 0.0)))


def _cube(x: tuple[float, float], y: tuple[float, float], z: tuple[float, float]) -> Csg:
    size = (x[1] - x[0], y[1] - y[0], z[1] - z[0])
    return Cube(size).at((x[0] + x[1]) / 2, (y[0] + y[1]) / 2, (z[0] + z[1]) / 2)
