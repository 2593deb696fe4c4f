"""Where a narrow contact ends along a way, as a strip on a cylinder's side does at the cylinder's end.

The strip has some profile across, a_j in each line of taxels along the way, which may rise or fall along it by
b_j.  With E the blurred step (`response`) and s the distance of a taxel before the end,

    depth_ij = (a_j + b_j s_ij) E(s_ij).

a and b are linear, so only the end is searched for (variable projection, Golub and Pereyra 1973; our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize_scalar

from exploration.sensing.frame import TactileImage
from exploration.sensing.response import Response, response_of
from primitives.arrays import Floats


@dataclass(frozen=True)
class StripEndConfig:
    """What is an end."""

    step: float = 0.6  # [mm] between the ends that are tried first
    least: float = 3.0  # [mm] of the strip, at least, before its end,
    beyond: float = 1.0  # and this much of the pad behind it
    systematic: float = 0.04  # of the deepest taxel: what the model leaves out
    misfit: float = 2.0  # chi2 per degree of freedom, above which it is none
    certain: float = 0.3  # [mm] that it must be known to
    slope: float = 0.05  # 1 sigma of the rise along the strip, of the deepest taxel for each mm
    lit: float = 0.15  # of the deepest taxel, from which a line of taxels is of the strip


@dataclass(frozen=True)
class StripEnd:
    """The end of a strip."""

    offset: float  # [mm] from the pad's middle, along the way
    sigma: float  # [mm]
    misfit: float  # chi2 per degree of freedom


def fit_strip_end(
    image: TactileImage,
    heading: Floats,
    config: StripEndConfig = StripEndConfig(),
    response: Response | None = None,
) -> StripEnd | None:
    """The end of a contact that goes a (2,) unit way across the pad; None where it has none that is plain."""
    strip = _Strip.of(image, heading, config, response)
    if strip is None:
        return None
    low, high = strip.first + config.least, strip.last - config.beyond
    tried = np.arange(low, high, config.step)
    if len(tried) < 3:
        return None
    costs = np.array([strip.cost(float(t)) for t in tried])
    best = int(np.argmin(costs))
    if best in (0, len(tried) - 1):
        return None
    found = minimize_scalar(
        strip.cost, bounds=(float(tried[best - 1]), float(tried[best + 1])), method="bounded"
    )
    end, least, h = float(found.x), float(found.fun), 0.5 * strip.width
    bend = (strip.cost(end - h) + strip.cost(end + h) - 2.0 * least) / (h * h)
    misfit = least / strip.freedom
    if bend <= 0.0 or misfit > config.misfit:
        return None
    sigma = float(np.sqrt(2.0 * max(misfit, 1.0) / bend))
    return StripEnd(end, sigma, misfit) if sigma < config.certain else None


@dataclass(frozen=True)
class _Strip:
    """The lines of taxels along a way that see it."""

    along: Floats  # (l, n) [mm] of each taxel
    depth: Floats  # (l, n) [mm]
    weight: Floats  # (l, n) 1 / sigma; 0 where a taxel is dead
    rise: float  # [mm] for each mm, 1 sigma
    width: float  # [mm] of the blur
    response: Response

    @staticmethod
    def of(
        image: TactileImage, heading: Floats, config: StripEndConfig, response: Response | None
    ) -> _Strip | None:
        alive = np.isfinite(image.sigma)
        depth = np.where(alive, image.depth, 0.0)
        deepest = float(depth.max(initial=0.0))
        x, y = np.meshgrid(image.array.x, image.array.y)
        along = x * heading[0] + y * heading[1]
        sigma = np.hypot(np.where(alive, image.sigma, 1.0), config.systematic * deepest)
        weight = np.where(alive, 1.0 / np.maximum(sigma, 1e-9), 0.0)
        if abs(heading[0]) < abs(heading[1]):
            along, depth, weight = along.T, depth.T, weight.T
        lit = depth.max(axis=1) > config.lit * deepest
        if deepest <= 0.0 or not lit.any():
            return None
        blur = response_of(image, response)
        return _Strip(along[lit], depth[lit], weight[lit], config.slope * deepest, blur.width(heading), blur)

    @property
    def first(self) -> float:
        """[mm] where the pad begins along the way."""
        return float(self.along.min(axis=1).max())

    @property
    def last(self) -> float:
        """[mm] where it ends."""
        return float(self.along.max(axis=1).min())

    @property
    def freedom(self) -> int:
        """Taxels less what is fitted."""
        return max(int((self.weight > 0.0).sum()) - 2 * len(self.along) - 1, 1)

    def cost(self, end: float) -> float:
        """Chi2 with the strip's end there."""
        before = end - self.along
        share = self.response.edge(before, self.width) * self.weight
        steady, rising = share, share * before
        told = self.depth * self.weight
        aa, ab = (steady * steady).sum(axis=1), (steady * rising).sum(axis=1)
        bb = (rising * rising).sum(axis=1) + 1.0 / self.rise**2
        ya, yb = (steady * told).sum(axis=1), (rising * told).sum(axis=1)
        over = np.maximum(aa * bb - ab * ab, 1e-12)
        a, b = (bb * ya - ab * yb) / over, (aa * yb - ab * ya) / over
        left = told - a[:, None] * steady - b[:, None] * rising
        return float((left * left).sum() + ((b / self.rise) ** 2).sum())
