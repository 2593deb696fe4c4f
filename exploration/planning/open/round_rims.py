"""Round openings that nothing led into: their rims, from where a face was felt to end and where it was not there.

The rim runs between touched places and the free ones beside them.  A circle through the middles,

    |x|^2 = 2 c . x + (r^2 - |c|^2),

is linear in c and in the bracket (Kasa 1976).  It is the rim of an opening where the ways out of the face lead to
its center and it was felt most of the way round.  How deep the opening is, nobody has felt.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from primitives.arcs import around, circle_through
from primitives.arrays import Floats
from primitives.pose import frame_along


@dataclass(frozen=True)
class RoundRimConfig:
    """What is a round opening."""

    rms: float = 0.8  # [mm] of the places from the circle; they are felt a cell apart
    share: float = 0.12  # of the radius, that they may be off it at most
    around: float = 4.0  # [rad] of it that must have been felt
    inward: float = 0.8  # share of the ways out that must lead to the center
    largest: float = 60.0  # [mm] radius


@dataclass(frozen=True)
class NarrowsConfig:
    """When two rims are the ends of one hole that narrows."""

    opposed: float = 0.98  # least cosine between the axes of its ends
    aside: float = 1.0  # [mm] of one end's center from the other's axis
    wider: float = 1.0  # [mm] between their radii, at least


@dataclass(frozen=True)
class RoundRim:
    """A circle on a face, whose inside is not there."""

    center: Floats  # (3,) [mm]
    axis: Floats  # (3,) out of the face
    radius: float  # [mm]
    sigma: float  # [mm] of the radius
    face: int
    measured: bool = False  # by looks at its rim, or all round a mouth in a round face; else it is a guess
    outer: float = np.inf  # [mm] radius at which the face ends, about the same axis
    bent: bool = False  # in a round face, across which its hole may run leaning

    def places(self, count: int = 24) -> tuple[Floats, Floats]:
        """(count, 3) places on the circle, and (count, 3) the ways to them from its center."""
        turn = 2.0 * np.pi * np.arange(count) / count
        ways: Floats = np.column_stack([np.cos(turn), np.sin(turn)]) @ frame_along(self.axis)[:, :2].T
        return self.center + self.radius * ways, ways

    def holds(self, point: Floats, beside: float = 3.0) -> bool:
        """Whether a (3,) point lies on the circle, or beside it."""
        away = point - self.center
        up = float(away @ self.axis)
        return abs(up) < beside and float(np.linalg.norm(away - up * self.axis)) < self.radius + beside

    def felt_over(self, felt: Floats, within: float = 0.6, level: float = 2.0) -> bool:
        """Whether some of (n, 3) felt places lie in it, at the level of its rim: then it is none."""
        away = felt - self.center
        up = away @ self.axis
        across = np.linalg.norm(away - np.outer(up, self.axis), axis=1)
        return int(((np.abs(up) < level) & (across < within * self.radius)).sum()) > 1

    def told(self) -> str:
        """In words, for a person."""
        return f"a round opening of radius about {self._room()}"

    def told_odd(self) -> str:
        """In words, where a look has found that its rim is no circle."""
        return f"an opening that is not round, of radius about {self._room()}"

    def _room(self) -> str:
        x, y, z = self.center
        where = f"({x:.1f}, {y:.1f}, {z:.1f}) mm"
        return f"{self.radius:.0f} mm at {where} has no room for the array; how deep it is, is unknown"


def far_end(
    rim: RoundRim, others: Sequence[RoundRim], config: NarrowsConfig = NarrowsConfig()
) -> RoundRim | None:
    """Of other rims the narrower one that a rim's hole ends at: the first behind it."""
    behind = [other for other in others if _narrows(rim, other, config)]
    return min(behind, key=lambda other: float((rim.center - other.center) @ rim.axis), default=None)


def _narrows(rim: RoundRim, other: RoundRim, config: NarrowsConfig) -> bool:
    apart = rim.center - other.center
    far = float(apart @ rim.axis)
    aside = float(np.linalg.norm(apart - far * rim.axis))
    return (
        (rim.measured or other.measured)
        and float(rim.axis @ other.axis) < -config.opposed
        and far > 0.0
        and aside < config.aside
        and other.radius < rim.radius - config.wider
    )


def round_rim(
    points: Floats, out: Floats, axis: Floats, face: int, config: RoundRimConfig | None = None
) -> RoundRim | None:
    """The circle through (n, 3) places of a rim, with the (n, 3) ways `out` of the face; None where none is."""
    config = config or RoundRimConfig()
    if len(points) < 6:
        return None
    turn, middle = frame_along(axis), points.mean(axis=0)
    flat = (points - middle) @ turn
    circle = circle_through(flat[:, :2])
    if circle is None:
        return None
    (cx, cy), radius = circle
    away = flat[:, :2] - [cx, cy]
    rms = float(np.sqrt(np.mean((np.linalg.norm(away, axis=1) - radius) ** 2)))
    felt = around(np.arctan2(away[:, 1], away[:, 0]))
    inward = float(np.mean((((out @ turn)[:, :2] * away).sum(axis=1)) < 0.0))
    if (
        rms > min(config.rms, config.share * radius)
        or felt < config.around
        or inward < config.inward
        or radius > config.largest
    ):
        return None
    center: Floats = middle + turn @ np.array([cx, cy, float(flat[:, 2].mean())])
    return RoundRim(center, axis, radius, rms / float(np.sqrt(len(points))), face)


def aside(places: Floats, center: Floats, axis: Floats) -> Floats:
    """(n,) [mm] of (n, 3) places from an axis."""
    away = places - center
    return np.asarray(np.linalg.norm(away - np.outer(away @ axis, axis), axis=1))
