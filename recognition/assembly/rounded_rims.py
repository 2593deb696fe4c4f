"""Rounded ends of what is turned: where a convex ring touches a flat end and the wall that ends there.

The end is taken away as deep as the ring is thick, and a bar and the ring are put there (`rounded` does so with
straight edges).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from models.csg import Cylinder as Bar
from models.csg import Torus as Ring
from models.solid import Solid
from primitives.arrays import Floats
from primitives.pose import pose
from primitives.shapes import Cylinder, Plane, Shape, Torus
from recognition.assembly.piece import Piece, along, upright

_TOUCH = 0.12  # of its radius, within which a rounding touches the faces beside it,
_OFF = 0.15  # [mm] and more
_ALONG = 0.999  # least cosine between axes that are one
_SIDE = 0.15, 0.05  # of its radius behind both faces, where material is, and before them, where none is
_ROUND = 24  # places round an edge that are looked at,
_SHARE = 0.7  # and of them, that are so
_PAST = 1.0  # [mm] before its faces, that what is taken away of an end reaches


@dataclass(frozen=True)
class Rim:
    """Of one end."""

    number: int  # of its surface
    shape: Torus
    out: Floats  # (3,) normal of the flat end

    @property
    def radius(self) -> float:
        """[mm] of the rounding."""
        return float(self.shape.minor_radius)

    def on(self, solid: Solid) -> bool:
        """Whether a body has that edge, and it is sharp."""
        turns = 2.0 * np.pi * np.arange(_ROUND) / _ROUND
        ways = np.column_stack([np.cos(turns), np.sin(turns)]) @ self.shape.frame[:, :2].T
        inner, outer = (self._at(ways, deep * self.radius) for deep in (_SIDE[0], -_SIDE[1]))
        there = (solid.signed_distance(inner) < 0.0) & (solid.signed_distance(outer) > 0.0)
        return bool(there.mean() > _SHARE)

    def _at(self, ways: Floats, deep: float) -> Floats:
        """(n, 3) places along (n, 3) ways from the axis, so deep behind both faces."""
        shape, short = self.shape, self.radius - deep
        return np.asarray(shape.center + (shape.radius + short) * ways + short * self.out)

    def cut(self, why: str) -> Piece:
        """What is taken away."""
        whole = Bar(float(self.shape.radius) + self.radius + _PAST, self.radius + _PAST)
        where = along(self.shape.center, self.out, 0.0, self.radius + _PAST)
        return Piece("cylinder", "subtract", whole, where, None, ((None, None),), why)

    def filled(self, why: str) -> list[Piece]:
        """What is put there."""
        bar = Bar(float(self.shape.radius), self.radius)
        where = along(self.shape.center, self.out, 0.0, self.radius)
        ring = Ring(float(self.shape.radius), self.radius)
        return [
            Piece("cylinder", "add", bar, where, None, ((None, None),), why),
            Piece("torus", "add", ring, pose(upright(self.out), self.shape.center), self.number, (), why),
        ]


def rims(shapes: Sequence[Shape], convex: Sequence[bool]) -> list[Rim]:
    """Those that touch a flat face and a wall about their axis from inside."""
    found = []
    for k, shape in enumerate(shapes):
        if not convex[k] or not isinstance(shape, Torus) or shape.radius <= shape.minor_radius:
            continue
        near = _TOUCH * shape.minor_radius + _OFF
        walled = any(
            isinstance(wall, Cylinder)
            and convex[i]
            and abs(float(wall.direction @ shape.axis)) > _ALONG
            and np.linalg.norm(np.cross(shape.center - wall.anchor, shape.axis)) < near
            and abs(shape.radius + shape.minor_radius - wall.radius) < near
            for i, wall in enumerate(shapes)
        )
        ends = (
            end.normal
            for end in shapes
            if isinstance(end, Plane)
            and abs(float(end.normal @ shape.axis)) > _ALONG
            and abs(float((shape.center - end.origin) @ end.normal) + shape.minor_radius) < near
        )
        out = next(ends, None) if walled else None
        if out is not None:
            found.append(Rim(k, shape, out))
    return found
