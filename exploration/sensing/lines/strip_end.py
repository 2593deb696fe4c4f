"""Where a narrow contact ends along a way, as a strip on a cylinder's side does at the cylinder's end.

The strip has some profile across, a(t), which may rise or fall along it by b(t).  With s the distance of a taxel
before the end, t its distance aside, both about the contact's middle, and E the blurred step (`response`),

    depth = (a(t) + b(t) s) E(s).

a and b are cubic splines across, about as fine as what the blur lets through.  They are linear, so only the end is
searched for, and the strip's axis, which is the heading but for some degrees (variable projection, Golub and
Pereyra 1973; our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.optimize import minimize

from exploration.sensing.frame import TactileImage
from exploration.sensing.response import Response, response_of
from primitives.arrays import Floats


@dataclass(frozen=True)
class StripEndConfig:
    """What is an end."""

    step: float = 0.8  # [mm] between the ends that are tried first
    least: float = 3.0  # [mm] of the strip, at least, before its end,
    beyond: float = 1.0  # and this much of the pad behind it
    systematic: float = 0.04  # of the deepest taxel: what the model leaves out
    misfit: float = 2.0  # chi2 per degree of freedom, above which it is none
    certain: float = 0.3  # [mm] that it must be known to
    slope: float = 0.05  # 1 sigma of the rise along the strip, of the deepest taxel for each mm
    lit: float = 0.15  # of the deepest taxel, from which a taxel is of the strip
    knots: float = 1.5  # [widths of the blur] between the splines that make the profile
    skew: float = np.deg2rad(4.0)  # [rad] 1 sigma of the strip's axis off the heading,
    most: float = np.deg2rad(15.0)  # and from where it is another way


@dataclass(frozen=True)
class StripEnd:
    """The end of a strip."""

    offset: float  # [mm] from the pad's middle, along the way, level with the contact's middle
    sigma: float  # [mm]
    misfit: float  # chi2 per degree of freedom
    axis: Floats  # (2,) unit way along the strip, to the end


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
    row = int(np.argmin([strip.cost(np.array([end, 0.0])) for end in tried]))
    near = product(tried[max(row - 1, 0) : row + 2], np.linspace(-2.0, 2.0, 5) * config.skew)
    start = np.array(min(near, key=lambda state: strip.cost(np.array(state))))
    if not tried[0] < start[0] < tried[-1]:
        return None
    simplex = start + np.array([[0.0, 0.0], [0.5 * config.step, 0.0], [0.0, 0.5 * config.skew]])
    found = minimize(
        strip.cost,
        start,
        method="Nelder-Mead",
        options={"initial_simplex": simplex, "xatol": 0.002, "fatol": 0.01},
    )
    (end, skew), misfit = found.x, float(found.fun) / strip.freedom(found.x)
    if not (low <= end <= high and abs(skew) < config.most and misfit <= config.misfit):
        return None
    covariance = _covariance(strip, found.x, max(misfit, 1.0))
    if covariance is None:
        return None
    # The end is a line across the axis, and is met at end / cos(skew) by who goes the way from the middle.
    slope = np.array([1.0, end * np.tan(skew)]) / np.cos(skew)
    sigma = float(np.sqrt(slope @ covariance @ slope))
    offset = float(strip.middle @ heading + end / np.cos(skew))
    return StripEnd(offset, sigma, misfit, strip.axis(skew)) if sigma < config.certain else None


def _covariance(strip: _Strip, best: Floats, misfit: float) -> Floats | None:
    """(2, 2) of end and skew, by differences of the cost over about the blur; None where it is no minimum."""
    step = np.array([0.5 * strip.response.mean_width, 0.3 * strip.config.skew])
    near = {k: strip.cost(best + step * k) for k in product((-1, 0, 1), repeat=2)}
    bend = np.array([near[1, 0] + near[-1, 0], near[0, 1] + near[0, -1]]) - 2.0 * near[0, 0]
    cross = 0.25 * (near[1, 1] + near[-1, -1] - near[1, -1] - near[-1, 1])
    hessian = np.array([[bend[0], cross], [cross, bend[1]]]) / np.outer(step, step)
    if bend.min() <= 0.0 or np.linalg.det(hessian) <= 0.0:
        return None
    return np.asarray(2.0 * misfit * np.linalg.inv(hessian))


@dataclass(frozen=True)
class _Strip:
    """The taxels that see it."""

    config: StripEndConfig
    middle: Floats  # (2,) [mm] of the contact
    first: float  # [mm] from there to where the pad begins along the way,
    last: float  # and to where it ends
    heading: Floats  # (2,) unit way
    place: Floats  # (n, 2) [mm] of each taxel from the middle
    told: Floats  # (n,) depth in sigmas
    weight: Floats  # (n,) [1/mm] 1 / sigma
    deepest: float  # [mm]
    response: Response

    @staticmethod
    def of(
        image: TactileImage, heading: Floats, config: StripEndConfig, response: Response | None
    ) -> _Strip | None:
        alive = np.isfinite(image.sigma)
        depth, array = image.depth[alive], image.array
        deepest = float(depth.max(initial=0.0))
        lit = depth > config.lit * deepest
        if deepest <= 0.0 or not lit.any():
            return None
        place = np.stack(np.meshgrid(array.x, array.y), axis=-1)[alive]
        middle = depth[lit] @ place[lit] / depth[lit].sum()
        half = np.array([array.x[-1], array.y[-1]])
        way = np.where(np.abs(heading) < 1e-9, 1e-9, heading)
        sides = np.stack([(-half - middle) / way, (half - middle) / way])
        place = place - middle
        aside = place @ np.array([-heading[1], heading[0]])
        seen = (aside >= aside[lit].min() - 1e-9) & (aside <= aside[lit].max() + 1e-9)
        weight = 1.0 / np.hypot(image.sigma[alive], config.systematic * deepest)[seen]
        return _Strip(
            config=config,
            middle=middle,
            first=float(sides.min(axis=0).max()),
            last=float(sides.max(axis=0).min()),
            heading=np.asarray(heading),
            place=place[seen],
            told=depth[seen] * weight,
            weight=weight,
            deepest=deepest,
            response=response_of(image, response),
        )

    def axis(self, skew: float) -> Floats:
        """(2,) unit way along a strip that is turned by a skew [rad] off the heading."""
        turn = np.array([[np.cos(skew), -np.sin(skew)], [np.sin(skew), np.cos(skew)]])
        return np.asarray(turn @ self.heading)

    def cost(self, state: Floats) -> float:
        """Chi2 of an end [mm from the middle] and a skew [rad]."""
        seen, normal = self._normal(state)
        side = seen.T @ self.told
        explained = float(side @ np.linalg.solve(normal, side))
        return float(self.told @ self.told) - explained + float((state[1] / self.config.skew) ** 2)

    def freedom(self, state: Floats) -> float:
        """Taxels less what is fitted, as far as these tell it."""
        seen, normal = self._normal(state)
        return max(len(self.told) - 1.0 - float(np.trace(np.linalg.solve(normal, seen.T @ seen))), 1.0)

    def _normal(self, state: Floats) -> tuple[Floats, Floats]:
        """(n, 2 k) of each spline in each taxel, in sigmas; and the (2 k, 2 k) normal matrix."""
        end, skew = state
        axis = self.axis(skew)
        before = end - self.place @ axis
        aside = self.place @ np.array([-axis[1], axis[0]])
        share = self.response.edge(before, self.response.width(axis)) * self.weight
        steady = _splines(aside / (self.config.knots * self.response.mean_width)) * share[:, None]
        seen = np.hstack([steady, steady * before[:, None]])
        prior = np.array([self.deepest, self.config.slope * self.deepest])
        return seen, seen.T @ seen + np.diag(np.repeat(prior**-2.0, steady.shape[1]))


def _splines(places: Floats) -> Floats:
    """(n, k) of the cubic splines round each whole number that reach any of (n,) places."""
    knots = np.arange(np.floor(places.min()) - 1.0, np.ceil(places.max()) + 2.0)
    off = np.abs(places[:, None] - knots)
    near, far = np.minimum(off, 1.0), np.clip(off, 1.0, 2.0)
    return np.where(off < 1.0, (4.0 - 6.0 * near**2 + 3.0 * near**3) / 6.0, (2.0 - far) ** 3 / 6.0)
