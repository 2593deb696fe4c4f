"""What an array is calibrated on: a flat with a straight edge, a step of known height, and a ball.

A plate, a shim on half of it and a ball on a post do; where they are is told in the table `[artifact]` of the
set-up, to some mm.  The emulator has one of its own, `palpate hardware emulate artifact`.

        shim                       ball
    ____|=======|                  ( )
    |  flat     |                   |
    |___________|___________________|___
    edge at the front (least y)
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

from models.csg import Csg, Cube, Cylinder, Sphere
from primitives.errors import PalpateError

NAME = "artifact"


@dataclass(frozen=True)
class Artifact:
    """`[artifact]`, in the stage's coordinates, seen from above; the defaults are the emulator's own."""

    flat_mm: tuple[float, ...] = (-20.0, 0.0, 0.0)  # the middle of a flat larger than the pad
    edge_mm: tuple[float, ...] = (-20.0, -30.0, 0.0)  # a point of a straight edge of it
    edge_deg: float = 0.0  # the edge's direction from the stage's x axis
    step_mm: tuple[float, ...] = (20.0, 0.0, 0.0)  # a point of the step's rim, on the lower face
    step_deg: float = 90.0  # the step's direction
    step_height_mm: float = 0.3
    step_sigma_mm: float = 0.003  # 1 sigma of the height
    ball_mm: tuple[float, ...] = (85.0, 0.0, 0.0)  # its center
    ball_radius_mm: float = 15.0

    @staticmethod
    def of(table: Mapping[str, Any], where: str) -> Artifact:
        """From a set-up's table."""
        valid = {field.name: field for field in fields(Artifact)}
        for key, value in table.items():
            if key not in valid:
                raise PalpateError(f"{where}: unknown key {key!r}; valid keys: {', '.join(valid)}")
            point = isinstance(value, list) and len(value) == 3 and all(map(_number, value))
            if not (_number(value) if valid[key].type == "float" else point):
                kind = "a number" if valid[key].type == "float" else "three numbers X, Y, Z"
                raise PalpateError(f"{where}: {key} must be {kind}, not {value!r}")
        told: dict[str, Any] = {k: tuple(v) if isinstance(v, list) else float(v) for k, v in table.items()}
        made = Artifact(**told)
        if min(made.step_height_mm, made.ball_radius_mm) <= 0.0 or made.step_sigma_mm < 0.0:
            raise PalpateError(f"{where}: step_height_mm and ball_radius_mm must be positive")
        return made

    def table(self) -> dict[str, object]:
        """As a set-up's table holds it."""
        return asdict(self)


def emulated_artifact() -> Csg:
    """The emulator's own: a plate of 80 x 60 mm with a shim on its right quarter, and a ball on a post beside."""
    told = Artifact()
    x = 0.5 * (told.step_mm[0] + 40.0)
    shim = Cube((40.0 - told.step_mm[0], 60.0, told.step_height_mm)).at(x, 0.0, told.step_height_mm / 2)
    post = Cylinder(4.0, 10.0).at(told.ball_mm[0], 0.0, -told.ball_radius_mm - 3.0)
    ball = Sphere(told.ball_radius_mm).at(*told.ball_mm)
    return Cube((80.0, 60.0, 10.0)).at(0.0, 0.0, -5.0) | shim | ball | post


def _number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
