"""Normals from positions alone: at every contact, of the likeliest of many flat and bent pieces that hold it.

A piece is the k contacts nearest to some contact.  Through it go a plane, by the covariance of its points, and a
paraboloid over that plane, by least squares.  Contacts that lie on no common surface scatter by about the piece's
own radius r, so a surface of d parameters with a sum of squares chi2 over sigma^2 is worth, in nats (our
derivation)::

    gain = (k - d) ln(r / (sqrt(2 pi) sigma)) - chi2 / 2.

Every contact takes the piece of greatest gain among those that hold it, its own and its neighbors', so that beside
an edge one that lies all on one side stands for it.  The variance of a plane's normal is e^2 / S, S the sum of
squares along the piece's narrower direction, and that of a paraboloid's follows from its own covariance; with
e = sigma where the piece is explained.  Where none is, the residuals' share of r is an angle by which the normal
may be off.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from primitives.arrays import Floats, Ints

_TINY = 1e-12


@dataclass(frozen=True)
class LocalFitOptions:
    """Which pieces are looked at."""

    flat: tuple[int, ...] = (5, 6, 8, 11, 15, 20, 32)  # contacts of one
    bent: tuple[int, ...] = (12, 20, 32)
    around: int = 12  # neighbors whose pieces a contact may take
    surprise: float = 5.0  # [nats] that the best of so many pieces gains by chance
    doubt: float = 2.0  # factor on the angle by which a piece that nothing explains may be off


def local_normals(
    points: Floats, rows: Ints, sigma: float, options: LocalFitOptions | None = None
) -> tuple[Floats, Floats]:
    """(m, 3) unit normals at some rows of (n, 3) points, either sense, and their (m,) sigma [rad]."""
    options = options or LocalFitOptions()
    n, m = len(points), len(rows)
    tree = cKDTree(points)
    holders = _nearest(tree, points[rows], min(options.around, n))
    away = np.linalg.norm(points[rows][:, None] - points[holders], axis=2)
    centers, which = np.unique(holders, return_inverse=True)
    which = which.reshape(holders.shape)
    near = _nearest(tree, points[centers], min(max(*options.flat, *options.bent), n))
    arms = points[near] - points[centers, None]
    sizes = [(k, False) for k in options.flat if k <= n] + [(k, True) for k in options.bent if k <= n]
    best = np.full(m, -np.inf)
    normals, spread = np.tile([0.0, 0.0, 1.0], (m, 1)), np.full(m, np.pi / 2)
    for size, bent in sizes:
        pieces = (_bent if bent else _flat)(arms[:, :size], sigma)
        reach = np.linalg.norm(arms[:, size - 1], axis=1) * (1 + 1e-9)
        gain = np.where(away <= reach[which], pieces.gain[which], -np.inf)
        column = gain.argmax(axis=1)
        top = gain[np.arange(m), column]
        better = np.flatnonzero(top > best)
        best[better] = top[better]
        piece, holder = which[better, column[better]], holders[better, column[better]]
        normals[better], spread[better] = pieces.at(piece, points[rows[better]] - points[holder])
        doubtful = top[better] < options.surprise
        spread[better] += np.where(doubtful, options.doubt * pieces.bend[piece], 0.0)
    return normals, spread


@dataclass(frozen=True)
class _Pieces:
    """Fitted pieces of one size."""

    gain: Floats  # (g,) [nats]
    bend: Floats  # (g,) [rad] residuals over the piece's radius
    frame: Floats  # (g, 3, 3) rows: the two directions along, the normal
    middle: Floats  # (g, 3) from the piece's center [mm]
    slopes: Floats  # (g, 6) coefficients of 1, u, v, uu, uv, vv
    covariance: Floats  # (g, 6, 6) of them

    def at(self, piece: Ints, point: Floats) -> tuple[Floats, Floats]:
        """(m, 3) normals and their (m,) sigma of some pieces, each at a point from its center."""
        frame = self.frame[piece]
        u, v = np.einsum("mij,mj->im", frame[:, :2], point - self.middle[piece])
        zero, one = np.zeros_like(u), np.ones_like(u)
        along_u, along_v = (zero, one, zero, 2 * u, v, zero), (zero, zero, one, zero, u, 2 * v)
        gradient = np.stack([np.stack(along_u, axis=1), np.stack(along_v, axis=1)], axis=1)
        slope = np.einsum("mij,mj->mi", gradient, self.slopes[piece])
        spread = np.einsum("mij,mjk,mlk->mil", gradient, self.covariance[piece], gradient)
        normal = frame[:, 2] - np.einsum("mi,mij->mj", slope, frame[:, :2])
        greatest = np.linalg.eigvalsh(spread)[:, 1]
        length = np.linalg.norm(normal, axis=1)
        return normal / length[:, None], np.sqrt(np.maximum(greatest, 0.0)) / length**2


def _flat(arms: Floats, sigma: float) -> _Pieces:
    """Planes through (g, k, 3) contacts."""
    g, count = arms.shape[:2]
    _, middle, values, frame = _principal(arms)
    covariance = np.zeros((g, 6, 6))
    covariance[:, 1, 1] = sigma**2 / np.maximum(values[:, 2], _TINY)
    covariance[:, 2, 2] = sigma**2 / np.maximum(values[:, 1], _TINY)
    gain, bend = _worth(values[:, 0], count, 3, values, sigma)
    return _Pieces(gain, bend, frame, middle, np.zeros((g, 6)), covariance)


def _bent(arms: Floats, sigma: float) -> _Pieces:
    """Paraboloids over those planes."""
    count = arms.shape[1]
    away, middle, values, frame = _principal(arms)
    u, v, w = np.moveaxis(np.einsum("gij,gkj->gki", frame, away), 2, 0)
    size = np.sqrt(np.maximum(values[:, 2] / count, _TINY))
    u, v = u / size[:, None], v / size[:, None]
    design = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=2)
    inverse = np.linalg.inv(np.einsum("gki,gkj->gij", design, design) + 1e-9 * np.eye(6))
    slopes = np.einsum("gij,gkj,gk->gi", inverse, design, w)
    left = ((w - np.einsum("gki,gi->gk", design, slopes)) ** 2).sum(axis=1)
    scale = np.stack([size**-p for p in (0, 1, 1, 2, 2, 2)], axis=1)
    covariance = sigma**2 * inverse * scale[:, :, None] * scale[:, None, :]
    gain, bend = _worth(left, count, 6, values, sigma)
    return _Pieces(gain, bend, frame, middle, slopes * scale, covariance)


def _principal(arms: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """From the middle; the middle; sums of squares, least first; and (g, 3, 3) rows of axes, greatest first."""
    middle = arms.mean(axis=1)
    away = arms - middle[:, None]
    values, axes = np.linalg.eigh(np.einsum("gki,gkj->gij", away, away))
    return away, middle, np.maximum(values, 0.0), np.swapaxes(axes[:, :, ::-1], 1, 2)


def _worth(left: Floats, count: int, dof: int, values: Floats, sigma: float) -> tuple[Floats, Floats]:
    """(g,) gain and bend of pieces that leave a sum of squares."""
    radius = np.sqrt(np.maximum(values[:, 1:].sum(axis=1) / count, _TINY))
    chance = np.maximum(np.log(radius / (np.sqrt(2 * np.pi) * sigma)), 0.0)
    gain = (count - dof) * chance - 0.5 * left / sigma**2
    bend = np.sqrt(left / max(count - dof, 1)) / radius
    return np.where(gain > 0, gain, -bend), bend


def _nearest(tree: cKDTree, points: Floats, count: int) -> Ints:
    return np.asarray(tree.query(points, k=count)[1], dtype=np.int64).reshape(len(points), count)
