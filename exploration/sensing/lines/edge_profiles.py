"""How a face presses on skin past its end, or up to a wall on it: sharp, chamfered, rounded or filleted.

A taxel is pressed by what the face stands before it, less what has fallen away there: of a sharp edge nothing up
to the edge, and then all; of a chamfer as wide as high, c, and of a rounding of radius r, at a distance u inside
of where the faces would meet::

    chamfer: max(0, c - u),    rounding: r - sqrt(r^2 - (r - u)^2) for u < r.

Rubber spreads that as a Gaussian.  The size that leaves least squares, and, less surely, which of the two it is,
follow from all taxels near an edge (our derivation).  A face that ends sharp and early, at a step, looks much like
that; but of two faces both seldom do by as much.

Before a wall a fillet of radius r stands up from the face by r - sqrt(r^2 - (r - x)^2) at a distance x < r from
it, and no skin is nearer to the wall than the side of the pad.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.ndimage import gaussian_filter1d

from primitives.arrays import Floats

KINDS = ("chamfer", "rounding")
DEPTHS = np.arange(0.1, 2.6, 0.1)  # [mm] that skin is pressed in
_STEP = 0.05  # [mm] along a profile
_BORDER = 0.25  # [mm] to which the side of a pad is known
_FROM, _TO = -4.0, 12.0  # [mm] outside and inside of an edge, that a profile is drawn over


@dataclass(frozen=True)
class ProfilesConfig:
    """When an edge is broken."""

    sizes: tuple[float, ...] = tuple(np.arange(0.2, 4.01, 0.1).round(2).tolist())  # [mm]
    fillets: tuple[float, ...] = tuple(np.arange(1.0, 10.01, 0.25).tolist())  # [mm] radii
    least: float = 0.4  # [mm] size of a broken edge
    floor: float = 0.04  # [mm] sigma besides the taxels' own,
    slope: float = 0.06  # and per mm of depth
    clip: float = 4.0  # sigmas, beyond which a taxel says no more
    taxels: int = 12  # of each face, at least
    gain: float = 40.0  # by which chi2 must fall, altogether
    each: float = 6.0  # and of each face
    share: float = 0.4  # of chi2 of a sharp edge, that is left at most,
    risen: float = 0.6  # or of that without a fillet,
    off: float = 0.5  # and for each taxel


@dataclass(frozen=True)
class Taxels:
    """Of one pad that lay on a face, near one edge."""

    inside: Floats  # (n,) [mm] from where the faces would meet
    before: Floats  # (n,) [mm] that the face stands before them
    depth: Floats  # (n,) [mm] that they are pressed in
    sigma: Floats  # (n,) [mm] of that
    spread: float  # [mm] of the rubber


def size_of_edge(
    lots: Sequence[Sequence[Taxels]], config: ProfilesConfig = ProfilesConfig()
) -> tuple[tuple[float, float], float] | None:
    """Sizes [mm] of `KINDS` that the taxels of each face tell together, and by how much of chi2 a taxel the first
    fits better.

    None where the edge may be sharp, or is neither.
    """
    counts = [sum(len(taxels.depth) for taxels in lot) for lot in lots]
    if min(counts) < config.taxels:
        return None
    lots = [_by_rubber(lot) for lot in lots]
    sharp = np.array([chi2(lot, KINDS[0], 0.0, config) for lot in lots])
    sizes, costs = [], []
    for kind in KINDS:
        tried = np.array([[chi2(lot, kind, size, config) for lot in lots] for size in config.sizes])
        best = int(tried.sum(axis=1).argmin())
        fallen, left, size = sharp - tried[best], float(tried[best].sum()), config.sizes[best]
        alike = left < config.off * sum(counts) and left < config.share * float(sharp.sum())
        if not alike or fallen.sum() < config.gain or (fallen < config.each).any() or size < config.least:
            return None
        sizes.append(size)
        costs.append(left)
    return (sizes[0], sizes[1]), (costs[1] - costs[0]) / sum(counts)


def _by_rubber(lot: Sequence[Taxels]) -> list[Taxels]:
    """The same taxels, those under one rubber together."""
    rubbers = sorted({taxels.spread for taxels in lot})
    return [_together([t for t in lot if t.spread == spread]) for spread in rubbers]


def _together(lot: Sequence[Taxels]) -> Taxels:
    """All taxels of pads whose rubber is the same."""
    return Taxels(
        np.concatenate([t.inside for t in lot]),
        np.concatenate([t.before for t in lot]),
        np.concatenate([t.depth for t in lot]),
        np.concatenate([t.sigma for t in lot]),
        lot[0].spread,
    )


def size_of_fillet(
    lots: Sequence[Sequence[Taxels]], config: ProfilesConfig = ProfilesConfig()
) -> float | None:
    """Radius [mm] of a fillet at a wall, `inside` being the distance from that; None where there may be none."""
    counts = [sum(len(taxels.depth) for taxels in lot) for lot in lots]
    if sum(counts) < config.taxels:
        return None
    sharp = np.array([_rise_chi2(lot, 0.0, config) for lot in lots])
    tried = np.array([[_rise_chi2(lot, size, config) for lot in lots] for size in config.fillets])
    best = int(tried.sum(axis=1).argmin())
    left, fallen = float(tried[best].sum()), sharp - tried[best]
    alike = left < config.off * sum(counts) and left < config.risen * float(sharp.sum())
    if (
        not alike
        or fallen.sum() < config.gain
        or (fallen < 0.0).any()
        or best in (0, len(config.fillets) - 1)
    ):
        return None
    return config.fillets[best]


def _rise_chi2(lot: Sequence[Taxels], size: float, config: ProfilesConfig) -> float:
    rises = [risen(size, t.spread, float(t.inside.min()), t.inside) for t in lot]
    return sum(_misfit(t, t.before + rise, config) for t, rise in zip(lot, rises, strict=True))


def risen(size: float, spread: float, nearest: float, away: Floats) -> Floats:
    """(n,) [mm] that taxels so far from a wall are pressed in more, the pad's side `nearest` [mm] to it."""
    border = round(max(nearest, 0.0) / _BORDER) * _BORDER
    table = _rises(size, round(spread, 3), border)
    return np.asarray(np.interp(away, border + _STEP * np.arange(len(table)), table))


@lru_cache(maxsize=2048)
def _rises(size: float, spread: float, border: float) -> Floats:
    away = border + _STEP * np.arange(round(_TO / _STEP))
    short = np.clip(size - away, 0.0, size)
    return np.asarray(gaussian_filter1d(size - np.sqrt(size**2 - short**2), spread / _STEP, mode="nearest"))


def chi2(lot: Sequence[Taxels], kind: str, size: float, config: ProfilesConfig = ProfilesConfig()) -> float:
    """Of the taxels of one face, were its edge of that kind and size [mm]; of size 0 it is sharp."""
    return sum(_misfit(t, pressed(kind, size, t.spread, t.inside, t.before), config) for t in lot)


def _misfit(taxels: Taxels, expected: Floats, config: ProfilesConfig) -> float:
    """chi2 of taxels that were expected to be pressed so deep (n,) [mm], each clipped."""
    sigma = np.hypot(taxels.sigma, config.floor + config.slope * taxels.before)
    return float(np.minimum(((taxels.depth - expected) / sigma) ** 2, config.clip**2).sum())


def pressed(kind: str, size: float, spread: float, inside: Floats, before: Floats) -> Floats:
    """(n,) [mm] that taxels are pressed in, which lie so far inside of an edge, the face so far before them."""
    table = _table(kind, size, round(spread, 3))
    at = np.clip((inside - _FROM) / _STEP, 0.0, table.shape[1] - 1.001)
    deep = np.clip((before - DEPTHS[0]) / (DEPTHS[1] - DEPTHS[0]), 0.0, len(DEPTHS) - 1.001)
    i, j = deep.astype(int), at.astype(int)
    v, w = deep - i, at - j
    above, below = (
        (1.0 - w) * table[i, j] + w * table[i, j + 1],
        (1.0 - w) * table[i + 1, j] + w * table[i + 1, j + 1],
    )
    return np.asarray((1.0 - v) * above + v * below)


@lru_cache(maxsize=512)
def _table(kind: str, size: float, spread: float) -> Floats:
    """(depths, places) of `pressed`."""
    inside = np.arange(_FROM, _TO, _STEP)
    if kind == "chamfer" or size <= 0.0:
        fallen = np.maximum(0.0, size - inside)
    else:
        short = np.clip(size - inside, 0.0, size)
        fallen = size - np.sqrt(size**2 - short**2)
    fallen = np.where(inside < 0.0, np.inf, fallen)
    sharp = np.maximum(0.0, DEPTHS[:, None] - fallen)
    return np.asarray(gaussian_filter1d(sharp, spread / _STEP, axis=1, mode="nearest"))
