"""The circle across a groove round a cylinder: of its width alone, or of what was felt of its bottom too.

At a height h along the axis a round bottom of radius r leans by sin(lean) = (middle - h) / r: a few contacts of a
fingertip tell r and the middle by a straight line through (h, sin lean).  The same r follows from the groove's
width w at the wall and its depth s there, r = (w^2 / 4 + s^2) / 2 s.  Where the two agree, a ring comes near the
bottom; a flat one has no such line, and one that is deeper than round has straight sides.  Contacts at one place
of its side tell no line.  Each lies on one circle through both ends of the wall, and where it leans as that does
there the groove is that.  Sides that lean alike over much of their height are straight (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from primitives.arrays import Floats


@dataclass(frozen=True)
class TubesConfig:
    """When contacts tell a circle."""

    few: int = 3  # contacts
    sure: float = 4.0  # of the error of the line's slope, that this is at least
    angle: float = 0.03  # [rad] that a normal errs by, at least
    agree: float = 0.35  # share by which the two radii may differ
    deepest: float = 1.2  # of half the width
    aside: float = 0.8  # [mm] that the bottom may be beside the middle between the walls' ends
    leaning: float = 0.3  # sine of the lean of a side, from which it is no flat bottom's,
    off: float = 0.12  # that this may be off
    told: float = 2.0  # of the error of a normal, that leans of a circle must differ by, to tell it from a V
    same: float = 0.5  # [mm] by which depths of one bottom may differ


@dataclass(frozen=True)
class Tube:
    """In the plane of the axis: heights along it, and depths under the cylinder."""

    height: float  # [mm] of its middle
    depth: float  # [mm] of its bottom
    radius: float  # [mm]

    @property
    def opening(self) -> float:
        """[rad] from its bottom to where it meets the cylinder."""
        return float(np.arccos(np.clip(1.0 - self.depth / self.radius, -1.0, 1.0)))


def half_round(low: float, high: float) -> Tube:
    """Half as deep as wide, between two heights [mm]."""
    half = 0.5 * (high - low)
    return Tube(low + half, half, half)


def tube_felt(
    heights: Floats,
    depths: Floats,
    leans: Floats,
    low: float,
    high: float,
    config: TubesConfig = TubesConfig(),
) -> Tube | None:
    """Of (n,) heights and depths [mm], and sines of the leans toward the axis, of contacts between two heights."""
    if len(heights) < config.few:
        return None
    told = heights, depths, leans, low, high, config
    tube = _by_line(*told) or _by_side(*told)
    steep = np.abs(leans) > config.leaning
    if tube is None or _straight(np.abs(heights - tube.height)[steep], np.abs(leans)[steep], tube, config):
        return None
    return tube


def _by_line(
    heights: Floats, depths: Floats, leans: Floats, low: float, high: float, config: TubesConfig
) -> Tube | None:
    """Of contacts about its bottom, whose leans change with their heights."""
    away = heights - heights.mean()
    square = float(away @ away)
    if square < 1e-9:
        return None
    slope = -float(away @ leans) / square
    error = max(config.angle, float(np.std(leans + slope * away))) / np.sqrt(square)
    if slope < config.sure * error:
        return None
    lowered = (1.0 - np.sqrt(np.clip(1.0 - leans**2, 0.0, 1.0))) / slope
    middle, depth = 0.5 * (low + high), float(np.median(depths + lowered))
    bottom = float(heights.mean() + leans.mean() / slope)
    if not 0.0 < depth < 0.5 * config.deepest * (high - low) or abs(bottom - middle) > config.aside:
        return None
    radius = (0.25 * (high - low) ** 2 + depth**2) / (2.0 * depth)
    return Tube(middle, depth, radius) if abs(slope * radius - 1.0) < config.agree else None


def _by_side(
    heights: Floats, depths: Floats, leans: Floats, low: float, high: float, config: TubesConfig
) -> Tube | None:
    """Of contacts on its sides: the circle through each of them and both ends of the wall (3 points, so one)."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    away = heights - middle
    # a circle through (-half, 0), (half, 0) and (away, d) has its center at c over the wall: c^2 + half^2 = r^2
    center = (half**2 - away**2 - depths**2) / (2.0 * np.maximum(depths, 1e-9))
    bottoms = np.hypot(center, half) - center
    depth = float(np.median(bottoms))
    if not 0.0 < depth < half * config.deepest:
        return None
    radius = (half**2 + depth**2) / (2.0 * depth)
    steep = np.abs(leans) > config.leaning
    alike = (np.abs(leans + away / radius) < config.off) & (np.abs(bottoms - depth) < config.same)
    if (steep & alike).sum() < config.few or alike.mean() < 0.5:
        return None
    return Tube(middle, depth, float(radius))


def _straight(away: Floats, leans: Floats, tube: Tube, config: TubesConfig) -> bool:
    """Whether sines of leans, (n,) so far [mm] from the middle, are one rather than a circle's: as of a V-belt's.

    Where a circle's would hardly differ, they tell nothing.
    """
    expected = away / tube.radius
    if len(leans) < config.few or float(np.std(expected)) < config.told * config.angle:
        return False
    return float(np.std(leans)) < float(np.sqrt(np.mean(np.square(leans - expected))))
