"""Outlines of a soft picture: the polygon of fewest corners whose own soft picture is the one that was seen.

A picture that is soft by s shows what a Gaussian of that width makes of a region.  Where it comes to one half
corners are cut off, and a hole of radius r ends s^2 / 2r early.  A polygon's own picture is compared with it
instead, near the outline, and the corners are moved to the least squares of the difference (Gauss and Newton).
With P the corners' covariance, one that lies h off the line c between its neighbors costs h^2 / (c P c') if it has
to lie on it; the cheapest are taken out until each costs more than it says (our derivation).  A rim that a circle
explains as well becomes one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_erosion

from primitives.arrays import Bools, Floats, Ints
from primitives.outlines import signed_area
from primitives.soft_pictures import REACH, drawn, following, normal_equations, slopes, softened, within


@dataclass(frozen=True)
class SoftOutlineConfig:
    """What a picture tells of a corner."""

    soft: tuple[float, ...] = (0.4, 0.8, 1.1, 1.3, 1.5, 1.7)  # [mm] that a picture may be soft by
    alike: float = 8.0  # [mm^2] of a picture in which its errors are one
    least: float = 0.015  # of a share, that a picture errs at least
    price: float = 10.0  # [chi2] that a corner must gain
    unseen: float = 0.4  # of what was seen, that the end of what is known counts as an outline
    inside: float = 3.0  # [mm] from what is not known, where a picture tells how soft it is
    sample: float = 0.4  # [mm] between samples of an edge
    finer: int = 4  # times as fine as the picture, in which a polygon is drawn
    loose: float = 1.0  # [mm] that corners are expected to move
    move: float = 0.6  # [mm] that they move at a time at most
    share: float = 0.34  # of the corners, that are taken out at a time at most
    passes: int = 10
    margin: float = 12.0  # [mm] round all rims, of the part of a picture that is looked at
    small: float = 6.0  # [mm^2] of a rim that stays as it is
    most: int = 400  # corners of which it is asked
    round_corners: int = 48  # of a circle


def sharpened(
    share: Floats,
    known: Bools,
    rims: Sequence[Floats],
    step: float,
    config: SoftOutlineConfig = SoftOutlineConfig(),
) -> tuple[Floats, ...]:
    """Closed rims of (n, 2) corners [mm] for an (n, m) picture, from those where its share is one half.

    Cell (i, j) of the picture has its middle at step (i, j); where it is not `known` to be as soft as it was seen,
    less is made of it.  Rims run round the region one way, and round its holes the other.
    """
    asked = [rim for rim in rims if abs(signed_area(rim)) > config.small]
    if not asked or sum(map(len, asked)) > config.most:
        return tuple(rims)
    first, window = _window(asked, share.shape, step, config)
    made = _sharpened(share[window], known[window], [rim - first for rim in asked], step, config)
    left = [rim for rim in rims if abs(signed_area(rim)) <= config.small]
    return (*(rim + first for rim in made), *left)


def _window(
    rims: Sequence[Floats], shape: tuple[int, ...], step: float, config: SoftOutlineConfig
) -> tuple[Floats, tuple[slice, ...]]:
    """(2,) [mm] where the part of a picture begins that rims have to do with, and its cells."""
    corners = np.concatenate(rims)
    low = np.maximum(0, np.floor((corners.min(axis=0) - config.margin) / step)).astype(np.int64)
    high = np.minimum(shape, np.ceil((corners.max(axis=0) + config.margin) / step) + 1).astype(np.int64)
    return low * step, tuple(slice(int(a), int(b)) for a, b in zip(low, high, strict=True))


def _sharpened(
    share: Floats, known: Bools, rims: Sequence[Floats], step: float, config: SoftOutlineConfig
) -> list[Floats]:
    told = _well_inside(known, step, config)
    trust = np.where(known, 1.0, config.unseen)
    fit = _Fit(share, trust, rims, step, _softness(share, trust * told, rims, step, config), config)
    for _ in range(2):
        fit.improve(2.0 * config.least)
    off = fit.misfit()[told[tuple(fit.cells.T)]]
    sigma = max(config.least, float(np.sqrt(np.mean(off**2))) if len(off) else 0.0)
    for _ in range(config.passes):
        if not fit.improve(sigma, prune=True):
            break
    fit.improve(sigma)
    squares = float(np.square(fit.misfit()).sum())
    return _better(fit, rims, [_or_circle(fit, k, squares, sigma, config) for k in range(len(fit.rims))])


def _softness(
    share: Floats, trust: Floats, rims: Sequence[Floats], step: float, config: SoftOutlineConfig
) -> float:
    """[mm] that a picture is soft by, as rims through its half explain it best where it is trusted."""
    sharp = drawn(rims, (share.shape[0], share.shape[1]), step, config.finer)
    return min(
        config.soft, key=lambda soft: float(np.square(trust * (share - softened(sharp, soft, step))).sum())
    )


def _well_inside(known: Bools, step: float, config: SoftOutlineConfig) -> Bools:
    """(n, m) where a picture tells how soft it is: where what is not known begins it ends at once."""
    inside = np.asarray(binary_erosion(known, iterations=int(np.ceil(config.inside / step))))
    return inside if inside.any() else known


class _Fit:
    """Polygons beside the picture that they are to explain."""

    def __init__(
        self,
        share: Floats,
        trust: Floats,
        rims: Sequence[Floats],
        step: float,
        soft: float,
        config: SoftOutlineConfig,
    ) -> None:
        self.share, self.trust, self.step, self.soft, self.config = share, trust, step, soft, config
        self.rims = [np.array(rim, dtype=float) for rim in rims]
        self.side = np.sign(signed_area(max(self.rims, key=lambda rim: abs(signed_area(rim)))))

        near = within(self._samples()[0], REACH * soft, share.shape, step)
        self.cells = np.argwhere(near & (trust > 0.0))  # (p, 2) which are compared
        self._numbers = np.full(share.shape, -1)  # (n, m) which of these a cell is
        self._numbers[tuple(self.cells.T)] = np.arange(len(self.cells))

    def misfit(self, rims: Sequence[Floats] | None = None) -> Floats:
        """(p,) by how much more the picture shows near the outline than that of the polygons."""
        return np.asarray(self.off(self.rims if rims is None else rims)[tuple(self.cells.T)])

    def off(self, rims: Sequence[Floats]) -> Floats:
        """(n, m) by how much more the picture shows than that of rims, as far as it is trusted."""
        return np.asarray(self.trust * (self.share - self.seen(rims)))

    def seen(self, rims: Sequence[Floats]) -> Floats:
        """(n, m) the picture that rims would give."""
        shape = self.share.shape[0], self.share.shape[1]
        return softened(drawn(rims, shape, self.step, self.config.finer), self.soft, self.step)

    def improve(self, sigma: float, prune: bool = False) -> int:
        """Move all corners to the least squares, take those out that are not worth it, and tell how many."""
        config, corners = self.config, np.concatenate(self.rims)
        count, off = len(corners), self.misfit()
        squares, sides = normal_equations(self._slope(), off)
        weight = self.step**2 / (config.alike * sigma**2)
        covariance = np.linalg.inv(squares * weight + np.eye(2 * count) / config.loose**2)
        moved = np.clip(covariance @ sides * weight, -config.move, config.move)
        rim = np.repeat(np.arange(len(self.rims)), [len(each) for each in self.rims])
        kept = np.ones(count, dtype=bool)
        if prune:
            kept = self._pruned(corners, moved, covariance, rim)
        moved = np.clip(moved, -2.0 * config.move, 2.0 * config.move)
        places = corners + moved.reshape(2, count).T
        self.rims = [places[(rim == k) & kept] for k in range(len(self.rims))]
        return count - int(kept.sum())

    def _pruned(self, corners: Floats, moved: Floats, covariance: Floats, rim: Ints) -> Bools:
        """(n,) which corners are worth what they say; those left are `moved` to make up for the others."""
        config, count = self.config, len(corners)
        kept, left = np.ones(count, dtype=bool), np.bincount(rim)
        after = following(self.rims)
        before = np.empty_like(after)
        before[after] = np.arange(count)
        while count - kept.sum() < max(4, config.share * count):
            places, own = corners + moved.reshape(2, count).T, np.flatnonzero(kept & (left[rim] > 3))
            if not len(own):
                break
            one, other = before[own], after[own]
            line, at = places[other] - places[one], places[own] - places[one]
            long = np.maximum(np.linalg.norm(line, axis=1), 1e-9)
            across = np.column_stack([line[:, 1], -line[:, 0]]) / long[:, None]
            along = (at * line).sum(axis=1) / long**2
            height = (at * across).sum(axis=1)
            weights = np.column_stack([np.ones(len(own)), along - 1.0, -along])
            slope = np.concatenate([weights * across[:, :1], weights * across[:, 1:]], axis=1)
            three = np.column_stack([own, one, other])
            rows = np.concatenate([three, three + count], axis=1)
            spread = np.einsum("ki,kij,kj->k", slope, covariance[rows[:, :, None], rows[:, None, :]], slope)
            cost = height**2 / np.maximum(spread, 1e-12)
            cost[(along < -0.2) | (along > 1.2) | (spread < 1e-12)] = np.inf
            k = int(np.argmin(cost))
            if not cost[k] <= config.price:
                break
            column = covariance[:, rows[k]] @ slope[k]
            moved -= column * (height[k] / spread[k])
            covariance -= np.outer(column, column) / spread[k]
            kept[own[k]], after[one[k]], before[other[k]] = False, other[k], one[k]
            left[rim[own[k]]] -= 1
        return kept

    def _samples(self) -> tuple[Floats, Ints, Floats, Floats]:
        """(q, 2) places on edges, (q,) whose they are and how far along, and (q, 2) ways out, of their length."""
        start, after = np.concatenate(self.rims), following(self.rims)
        line = start[after] - start
        count: Ints = np.maximum(2, np.ceil(np.linalg.norm(line, axis=1) / self.config.sample)).astype(
            np.int64
        )
        edge = np.repeat(np.arange(len(start)), count)
        along = np.concatenate([(np.arange(n) + 0.5) / n for n in count.tolist()])
        out = self.side * np.column_stack([line[:, 1], -line[:, 0]]) / count[:, None]
        return start[edge] + along[:, None] * line[edge], edge, along, out[edge]

    def _slope(self) -> Floats:
        """(p, 2n) derivative of the polygons' picture by the x, then the y, of their corners."""
        at, edge, along, out = self._samples()
        ends = np.column_stack([edge, following(self.rims)[edge]])
        corners = sum(map(len, self.rims))
        return np.asarray(
            slopes(at, out, along, ends, corners, self._numbers, self.trust, self.soft, self.step)
        )


def _better(fit: _Fit, old: Sequence[Floats], made: Sequence[Floats]) -> list[Floats]:
    """Each rim as it was made, where that explains more of the picture, and is not turned inside out."""

    def squares(rims: Sequence[Floats]) -> float:
        return float(np.square(fit.off(rims)).sum())

    best, least = list(old), squares(old)
    for k, rim in enumerate(made):
        trial = [*best[:k], rim, *best[k + 1 :]]
        if signed_area(rim) * signed_area(old[k]) > 0.0 and (off := squares(trial)) < least:
            best, least = trial, off
    return best


def _or_circle(fit: _Fit, k: int, squares: float, sigma: float, config: SoftOutlineConfig) -> Floats:
    """A rim, or the circle that explains the picture as well as its corners do, which leave these squares."""
    rim = fit.rims[k]
    size = signed_area(rim)
    closed = np.roll(rim, -1, axis=0)
    cross = rim[:, 0] * closed[:, 1] - closed[:, 0] * rim[:, 1]
    center = ((rim + closed) * cross[:, None]).sum(axis=0) / (6.0 * size)
    turn = np.sign(size) * 2.0 * np.pi * np.arange(config.round_corners) / config.round_corners
    radius = np.sqrt(abs(size) / (0.5 * config.round_corners * np.sin(2.0 * np.pi / config.round_corners)))
    circle = center + radius * np.column_stack([np.cos(turn), np.sin(turn)])
    weight = fit.step**2 / (config.alike * sigma**2)
    worse = fit.misfit([*fit.rims[:k], circle, *fit.rims[k + 1 :]])
    loss = weight * (float(worse @ worse) - squares)
    return circle if loss < 0.5 * config.price * (2 * len(rim) - 3) else rim
