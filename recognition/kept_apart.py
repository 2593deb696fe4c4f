"""What contacts that a smooth surface was not made of tell of it, and of the body of faces beside it.

Contacts are parted in a few lots, and each lot is held against the surface through the others: whole touches, or
of a cloud what lies in some cells of space.  Ours.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import cKDTree
from scipy.special import ndtri

from models.solid import Solid
from primitives.arrays import Bools, Floats
from primitives.errors import PalpateError
from primitives.evidence import Contacts
from recognition.hulled import hull_of
from recognition.smooth_mesh import through

SHARE, NEARLY = 75.0, 95.0  # per cent of the contacts, whose distance speaks for all; and nearly all
SIGMAS = float(ndtri(0.5 + 0.005 * SHARE))  # within which so many lie of what is off by chance
NEAR = 0.12  # [mm] from a body, from which it is looked for
_BETTER = 0.8  # times the distance from the body, as which contacts kept apart must be nearer
_CONTRADICTED = 1.3  # times what noise explains, from which contacts contradict a body
_POOR = 5.0  # times what noise explains, from which any surface is taken that is nearer than a body
_GENERAL, _LITTLE = 1.5, 0.1  # times the distance of its own contacts, and [mm] more, that they may be
_BENT = 0.05  # times the width of gaps in a cloud, and as much more
_LEAST, FEWEST = 60, 24  # contacts with normals, and of a cloud, which are spread
_FEWER = 500  # contacts that it is made of, where some are kept apart
_FOLDS = 4  # lots that contacts are parted in, each kept apart once
_CELLS = 6  # along the longest side, at least, that a cloud is parted in, and two along the shortest


class Apart(NamedTuple):
    """What contacts kept apart tell [mm]."""

    off: float  # that most of them lie off a smooth surface through the others
    outside: float  # that nearly all are outside the others' hull, at most
    gap: float  # how wide a gap they leave in a cloud; 0 where they are whole touches


def kept_apart(away: float, freedom: float, smooth: Contacts, is_hull: bool) -> Apart | None:
    """What `smooth` contacts tell; None where those kept apart lie too far off the surface through the others.

    That is farther than off the hull of the others, where the body is one; else than off the body of faces, which
    is `away` [mm] from contacts that it was made of and would be farther from others, by the `freedom` that its
    faces have for each of them (generalized cross-validation, Craven and Wahba 1979).  A body within the noise of
    its contacts is doubted less.
    """
    noise = SIGMAS * float(np.median(smooth.sigma))
    contradicted, poor = away > _CONTRADICTED * noise, away > _POOR * noise
    away = away / (1.0 - freedom) if freedom < 1.0 else np.inf
    poor &= away < np.inf  # there is a body
    if not is_hull and away < NEAR:
        return None
    folds, gap = _folds(smooth)
    if not gap and len(smooth) < _LEAST:
        return None
    off, own, outside, alone = [], [], [], []
    for apart in folds:
        kept, points = smooth.select(~apart), smooth.points[apart]
        try:
            tried = through(kept, _FEWER)
        except PalpateError:
            return None
        off.append(np.abs(tried.values(points)))
        own.append(np.abs(tried.values(kept.points)))
        alone.append(cKDTree(kept.points).query(points)[0])
        if (hull := hull_of(kept.points)) is not None:
            outside.append(Solid.from_csg(hull).signed_distance(points))
    if not off or not outside:
        return None
    found, from_hull = most_of(np.concatenate(off)), np.concatenate(outside)
    if is_hull:
        most = most_of(np.abs(from_hull))
    else:
        gap = max(gap, 2.0 * float(np.median(np.concatenate(alone)))) if gap else 0.0
        most = _GENERAL * most_of(np.concatenate(own)) + _LITTLE + _BENT * gap
        most = _BETTER * away if poor else min(most, away if gap and contradicted else _BETTER * away)
    return Apart(found, float(np.percentile(from_hull, NEARLY)), gap) if found < most else None


def most_of(off: Floats) -> float:
    """[mm] within which most of (n,) distances are."""
    return float(np.percentile(off, SHARE))


def _folds(felt: Contacts) -> tuple[list[Bools], float]:
    """(n,) which contacts are kept apart, a few times, and the width of the gaps that this leaves [mm].

    Whole touches are, which leave none; of a cloud, what lies in some cells.
    """
    names, lot = np.unique(felt.touch, return_inverse=True)
    size = 0.0
    if not 2 * _FOLDS <= len(names) < len(felt):
        own = felt.points - felt.points.mean(axis=0)
        sides = np.ptp(own @ np.linalg.svd(own, full_matrices=False)[2].T, axis=0)
        size = max(min(float(sides.max()) / _CELLS, 0.5 * float(sides.min())), 1e-9)
        lot = np.unique(np.floor(own / size), axis=0, return_inverse=True)[1].reshape(-1)
    folds = [np.asarray(lot % _FOLDS == k) for k in range(_FOLDS)]
    return [fold for fold in folds if fold.any() and not fold.all()], size
