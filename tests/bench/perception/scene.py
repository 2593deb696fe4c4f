"""A press as numbers: what lies under which pad, and the frame without noise that the simulator makes of it.

The object's top plane is z = 0 of the part frame, material below.  In the pad's frame its depth is
depth + tilt_x x + tilt_y y [mm].  Seen from the pad, the part's x axis runs along -(cos turn, sin turn) and its
y axis along n = (-sin turn, cos turn), and its origin is at (x, y) + offset n [mm]: for material at y > 0, `turn`
and `offset` are those of the edge.  Every number may be moved by a little, which is all that the bound asks for.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from exploration.sensing.physics.elastomer import Rubber
from exploration.sensing.physics.gap import Gap, gap
from exploration.sensing.spec import SensorSpec
from models.solid import Solid
from primitives.arrays import Bools, Floats
from primitives.pose import inverse, pose

Numbers = Mapping[str, float]
LOCAL = ("depth", "tilt_x", "tilt_y", "background")  # what no estimator is told of the contact


@dataclass(frozen=True)
class Scene:
    """One press; `numbers` has x, y, turn, offset, depth, tilt_x, tilt_y, background and those of the solid."""

    spec: SensorSpec
    numbers: Numbers
    solid: Callable[[Numbers], Solid]
    truth: Callable[[Numbers], Floats]  # (m, k) lines: angle, offset; arcs: center x, y, radius
    unknown: tuple[str, ...]  # what the estimator is not told
    dead: Bools | None = None  # (rows, columns) taxels that read nothing

    def moved(self, **by: float) -> "Scene":
        """The same with some numbers changed by so much."""
        return replace(self, numbers={**self.numbers, **{k: self.numbers[k] + v for k, v in by.items()}})

    @property
    def found(self) -> Floats:
        """(m, k) what there is to find."""
        return self.truth(self.numbers)


def numbers(**given: float) -> dict[str, float]:
    """All that a scene needs, zero where not given."""
    return dict.fromkeys(("x", "y", "turn", "offset", *LOCAL), 0.0) | given


def world_from_sensor(n: Numbers) -> Floats:
    """The pad's pose in the part frame."""
    out = -np.array([n["tilt_x"], n["tilt_y"], 1.0])
    out /= np.linalg.norm(out)
    c, s = np.cos(n["turn"]), np.sin(n["turn"])
    along = -np.array([c, s, -(n["tilt_x"] * c + n["tilt_y"] * s)])
    along /= np.linalg.norm(along)
    part_axes = np.stack([along, np.cross(out, along), out], axis=1)
    x, y = n["x"] - n["offset"] * s, n["y"] + n["offset"] * c
    origin = np.array([x, y, -(n["depth"] + n["tilt_x"] * x + n["tilt_y"] * y)])
    return pose(part_axes.T, -part_axes.T @ origin)


def seen(n: Numbers, points: Floats) -> Floats:
    """(..., 2) where the pad sees (..., 2) points of the part's face [mm]."""
    from_part = inverse(world_from_sensor(n))
    return np.asarray(points @ from_part[:2, :2].T + from_part[:2, 3])


def clean(scene: Scene) -> Floats:
    """(rows, columns) depth [mm] that the taxels feel, without noise."""
    n = scene.numbers
    sensed, rubber = _felt(scene.solid(n), scene.spec)
    sensed.feel(world_from_sensor(n)[None])
    felt = rubber.press(sensed.modes, sensed.partial) / scene.spec.elastomer.stiffness
    return np.asarray(felt + n["background"])


@lru_cache(maxsize=96)
def _felt(solid: Solid, spec: SensorSpec) -> tuple[Gap, Rubber]:
    return gap(solid, spec), Rubber(spec)
