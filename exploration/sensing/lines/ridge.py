"""The narrow top of a wall, from a frame of a pad that lies across it: how thick it is behind its known side.

The top is a band between the wall's outer side, which is known, and an inner one t behind it.  With e the distance
of a taxel behind the outer side, E the blurred step (`response`) and its share of the band

    S = E(e) - E(e - t),    depth = (d + g . p) S + w^2 g . grad S,

d and g of the top's plane, the last term the moment that the blur takes across an edge, as in `round_hole`.  The
plane is linear, so only t is searched for (variable projection, Golub and Pereyra 1973), and where the outer side
is not known well how far off it is.  The top is taken for level across the wall, as the pad came: one that leans
looks like one of another thickness, or one that stands elsewhere.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from exploration.sensing.frame import TactileImage
from exploration.sensing.response import Response, response_of
from primitives import pose as se3
from primitives.arrays import Floats

_LEAST = 12  # taxels
_STEP = 0.05  # [mm] of the slope of the share


@dataclass(frozen=True)
class RidgeConfig:
    """What is the top of a wall."""

    thick: tuple[float, float] = (0.6, 8.0)  # [mm] of a wall
    starts: tuple[float, ...] = (0.8, 1.5, 3.0, 5.0)  # [mm] thick, from where the search begins
    outside: float = 3.0  # [widths] of the blur beside the band, up to which taxels are looked at
    felt: float = 0.3  # of the deepest taxel, from which one tells how far the wall goes along the pad
    past: float = 1.0  # [widths] from an end of it, within which taxels are left out
    systematic: float = 0.02  # of the deepest taxel: what the model leaves out
    misfit: float = 1.5  # chi2 per degree of freedom, above which it is none
    certain: float = 0.3  # [mm] that its thickness must be known to
    level: float = 0.003  # 1 sigma of its slope across the wall
    lean: float = 0.15  # most slope of the top against the pad, along the wall
    on_top: float = 0.8  # of what the best taxel sees of the top, that one sees which tells where it is


@dataclass(frozen=True)
class Ridge:
    """The top of a wall."""

    thick: float  # [mm]
    shift: float  # [mm] of the outer side, outward from where it was thought to be
    sigma: float  # [mm] of the thickness
    side_sigma: float  # [mm] of where the outer side is
    far_sigma: float  # [mm] of where the inner one is
    misfit: float  # chi2 per degree of freedom
    top: Floats  # (n, 3) [mm] places on it


def fit_ridge(
    image: TactileImage,
    pose: Floats,
    side: Floats,
    outward: Floats,
    slack: float = 0.0,
    config: RidgeConfig = RidgeConfig(),
) -> Ridge | None:
    """The wall behind an outer side through a (3,) place `side` that looks (3,) `outward`, at a (4, 4) pose.

    The side may be `slack` [mm] off.
    """
    look = _Look.of(image, pose, side, outward, config)
    if len(look.depth) < _LEAST:
        return None
    (least, most), free = config.thick, int(slack > 0.0)
    bounds = ([least, -slack][: 1 + free], [most, slack][: 1 + free])
    shifts = (-0.5 * slack, 0.0, 0.5 * slack) if free else (0.0,)
    runs = [
        least_squares(look.residual, [start, shift][: 1 + free], bounds=bounds)
        for start in config.starts
        for shift in shifts
    ]
    found = min(runs, key=lambda run: float(run.cost))
    misfit = float(2.0 * found.cost / max(len(found.fun) - 4 - free, 1))
    slopes = np.asarray(found.jac)
    thick, shift = float(found.x[0]), float(found.x[1]) if free else 0.0
    spread = max(misfit, 1.0) * np.linalg.pinv(slopes.T @ slopes)
    of = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 1.0]])[:, : 1 + free]  # thickness, outer side, inner side
    sigma, side_sigma, far_sigma = np.sqrt(np.einsum("ij,jk,ik->i", of, spread, of)).tolist()
    plane, share = look.plane(thick, shift)
    leans = abs(float(plane[1:] @ look.along)) > config.lean
    if (
        misfit > config.misfit
        or sigma > config.certain
        or found.active_mask.any()
        or leans
        or plane[0] <= 0.0
    ):
        return None
    there = share[:, 0] / look.weight
    best = look.rows[there > config.on_top * float(there.max())]
    top = se3.transform_points(pose, np.column_stack([best[:, 1:], -best @ plane]))
    return Ridge(thick, shift, sigma, side_sigma, far_sigma, misfit, top)


@dataclass(frozen=True)
class _Look:
    """Taxels of one frame."""

    behind: Floats  # (n,) [mm] of each, behind the outer side
    rows: Floats  # (n, 3) of its plane: 1, x, y
    depth: Floats  # (n,) [mm]
    weight: Floats  # (n,) 1 / sigma
    into: Floats  # (2,) the way into the wall, along the pad's x and y
    width: float  # [mm] of the blur, across it
    leans: float  # how much the top may lean across the wall, 1 sigma
    response: Response

    @staticmethod
    def of(
        image: TactileImage,
        pose: Floats,
        side: Floats,
        outward: Floats,
        config: RidgeConfig,
    ) -> _Look:
        x, y = (grid.ravel() for grid in np.meshgrid(image.array.x, image.array.y))
        depth, sigma = image.depth.ravel(), image.sigma.ravel()
        places = se3.transform_points(pose, np.column_stack([x, y, -np.maximum(depth, 0.0)]))
        behind, into = (side - places) @ outward, -pose[:3, :2].T @ outward
        into = into / max(float(np.linalg.norm(into)), 1e-9)
        response = response_of(image)
        width = response.width(into)
        reach = config.outside * width
        live = np.isfinite(sigma) & (sigma > 0.0)
        along = x * -into[1] + y * into[0]
        felt = along[live & (depth > config.felt * float(depth[live].max(initial=0.0)))]
        first, last = (float(felt.min()), float(felt.max())) if len(felt) else (np.inf, -np.inf)
        first += config.past * width if first > along.min() + width else -width
        last -= config.past * width if last < along.max() - width else -width
        kept = (behind > -reach) & (behind < config.thick[1] + reach) & live
        kept &= (along > first) & (along < last)
        rows = np.column_stack([np.ones(len(x)), x, y])[kept]
        floor = config.systematic * float(depth[kept].max(initial=0.0))
        weight = 1.0 / np.hypot(sigma[kept], floor)
        return _Look(behind[kept], rows, depth[kept], weight, into, width, config.level, response)

    @property
    def along(self) -> Floats:
        """(2,) the way along the wall."""
        return np.array([-self.into[1], self.into[0]])

    def share(self, behind: Floats, thick: float) -> Floats:
        """(n,) of taxels so far behind the outer side, that lie on the top of a wall so thick."""
        edge = self.response.edge
        return np.asarray(edge(behind, self.width) - edge(behind - thick, self.width))

    def plane(self, thick: float, shift: float = 0.0) -> tuple[Floats, Floats]:
        """(3,) the best plane of the top, and (n, 3) what each taxel sees of it, in standard deviations."""
        behind = self.behind + shift
        share = self.share(behind, thick)
        ahead, back = (self.share(behind + step, thick) for step in (_STEP, -_STEP))
        moment = self.width**2 * ((ahead - back) / (2.0 * _STEP))[:, None] * self.into
        rows = self.rows * share[:, None] + np.column_stack([np.zeros(len(share)), moment])
        rows = rows * self.weight[:, None]
        level = np.concatenate([[0.0], self.into / self.leans])
        seen = np.append(self.depth * self.weight, 0.0)
        plane, *_ = np.linalg.lstsq(np.vstack([rows, level]), seen, rcond=None)
        return np.asarray(plane), rows

    def residual(self, wall: Floats) -> Floats:
        """(n,) what the best plane leaves of a wall's thickness, and shift, in standard deviations."""
        plane, rows = self.plane(*wall.tolist())
        return np.asarray(rows @ plane - self.depth * self.weight)
