"""A pad's taxels as views of an endless skin: one each, or several where the skin ends nearby.

Where the rubber ends, what spreads beyond comes back as from a mirror (see `physics.skin`), so along that axis a
taxel weighs the pressure by a folded Gaussian that stops at the skin's end.  Cut into a few parts of equal weight,
each taken for a Gaussian of its own mean and variance, that keeps its sum, mean and variance (our derivation).
Each part is a view like any other, only narrower.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.special import ndtr

from primitives.arrays import Floats, Ints, frozen

ENDLESS = 4.0  # [widths] from a taxel, beyond which the skin's end is not felt
PARTS, SMALL = 3, 8  # views of a taxel whose blur is cut, along that axis; one more on pads of so few taxels
ENOUGH = 5e-3  # of the step, the error of one view's integral
View = tuple[float, float, float]  # place, variance, weight


@dataclass(frozen=True)
class SkinViews:
    """What `edge_model.design` needs to know of a pad."""

    views: Floats  # (3, k) x, y [mm] and weight
    kinds: Ints  # (k,) which of `blurs`
    first: Ints  # (n + 1,) the views of taxel i are first[i] to first[i + 1]
    blurs: Floats  # (m, 2) [mm^2] variance of the response across edges whose normal is x, and y


@lru_cache(maxsize=64)
def skin_views(
    rows: int, columns: int, pitch: tuple[float, float], skin: float, variance: tuple[float, float]
) -> SkinViews:
    """Views of a pad with so much `skin` [mm] past its taxels; `variance` is of an endless one's response."""
    along_x = _axis(columns, pitch[0], skin, variance[0])
    along_y = _axis(rows, pitch[1], skin, variance[1])
    kinds: dict[tuple[float, float], int] = {variance: 0}
    views, which, first = [], [], [0]
    for of_y in along_y:
        for of_x in along_x:
            for x, vx, cx in of_x:
                for y, vy, cy in of_y:
                    views.append((x, y, cx * cy))
                    which.append(kinds.setdefault((vx, vy), len(kinds)))
            first.append(len(views))
    return SkinViews(
        frozen(np.array(views).T),
        frozen(which, np.int64),
        frozen(first, np.int64),
        frozen(np.array(list(kinds))),
    )


def _axis(count: int, pitch: float, skin: float, variance: float) -> list[list[View]]:
    x = (np.arange(count) - (count - 1) / 2) * pitch
    width, end = float(np.sqrt(variance)), count * pitch / 2 + skin
    parts = PARTS + (count <= SMALL)
    half = [
        _views(float(c), end, width, parts) if end - abs(c) < ENDLESS * width else [(float(c), variance, 1.0)]
        for c in x[: (count + 1) // 2]
    ]
    return half + [[(-at, v, c) for at, v, c in reversed(views)] for views in half[: count // 2][::-1]]


def _views(x: float, end: float, width: float, parts: int) -> list[View]:
    """Of one taxel, on a skin that ends at -end and end."""
    fine = np.linspace(-end, end, 401)
    images = np.array([x, 2 * end - x, -2 * end - x])[:, None]
    weights = np.exp(-(((fine - images) / width) ** 2) / 2).sum(axis=0)
    weights[[0, -1]] /= 2
    weights /= weights.sum()
    share = np.cumsum(weights) - weights / 2
    one = _parts(fine, weights, share, 1)
    ((at, variance, _),) = one
    miss = np.abs(ndtr((fine - at) / np.sqrt(variance)) - share).max()
    return one if miss < ENOUGH else _parts(fine, weights, share, parts)


def _parts(fine: Floats, weights: Floats, share: Floats, count: int) -> list[View]:
    """`count` parts of equal weight, each with its own mean and variance."""
    part = np.minimum((share * count).astype(int), count - 1)
    out = []
    for k in range(count):
        w, at = weights[part == k], fine[part == k]
        mean = float(w @ at / w.sum())
        out.append((mean, float(w @ (at - mean) ** 2 / w.sum()), float(w.sum())))
    return out
