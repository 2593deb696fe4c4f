"""Surfaces cut space into cells: which there are, what touch says of each, and where they meet.

A cell is all of space on the same side of every surface.  Its sides are read off sample points: an even grid, the
two sides of every contact, and the two sides of points on every surface, so that thin cells are found where they
touch a surface.  A facet is where two cells meet on one surface.  Its area follows from the grid: points within
h / 2 of a surface stand for their share of the slab's volume over h (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from primitives.arrays import Bools, Floats, Ints, frozen
from primitives.shapes import Plane, Shape


@dataclass(frozen=True)
class ArrangementOptions:
    """How finely space is sampled."""

    grid: int = 32_768  # points over the box
    passed: float = 2.5  # [mm] round a place that something went through, that is as large as a swept cell
    on: float = 3.0  # times that, from a surface, within which a contact lies on it
    along: float = 0.7  # least cosine between how such a contact looks, and its surface there
    outvoted: int = 3  # felt contacts, against which those that nobody felt count no more than
    hearsay: float = 2.0  # of them
    unreached: float = 0.1  # of an area nearer to a face that nobody felt than any contact is, which counts
    aside: float = 1e-3  # of the box's diagonal: how far beside a contact its two sides are looked at


@dataclass(frozen=True)
class Arrangement:
    """The cells between m surfaces."""

    outside: Bools  # (c, m) which surfaces a cell lies outside of
    volume: Floats  # (c,) [mm^3] of it within the box; zero where no grid point fell
    beyond: Floats  # (c,) share of that volume outside the box of the contacts
    solid_votes: Floats  # (c,) contacts that say that it is solid
    free_votes: Floats  # (c,) contacts that say that it is free
    swept_votes: Floats  # (c,) places in it that something went through
    swept_share: Floats  # (c,) share of its volume beside such places
    pairs: Ints  # (f, 2) the cells inside and outside of a facet's surface
    area: Floats  # (f,) [mm^2] of the facet, where contacts are to be expected
    touched: Floats  # (m,) contacts that lie on each surface
    facing: Floats  # (2, m) of those, that look to its outside, and to its inside
    inferred: Bools  # (m,) whether nobody felt a surface
    stops: Bools  # (m,) whether it is no face's, but a plane that primitives may end at

    def __len__(self) -> int:
        return len(self.outside)


def arrange(
    shapes: Sequence[Shape],
    points: Floats,
    normals: Floats,
    free: Floats,
    room: Floats,
    options: ArrangementOptions | None = None,
    inferred: Bools | None = None,
    heard: Bools | None = None,
    stops: Bools | None = None,
) -> Arrangement:
    """Of contacts at (n, 3) points with outward (n, 3) normals, and (k, 3) places known to be free.

    Of the m surfaces some may be `inferred` (m,), or `stops`, and of the contacts some only `heard` of (n,), and
    never felt.
    `room` (2, 3) holds the contacts with some space round them.
    """
    options = options or ArrangementOptions()
    low, high = room
    span = high - low
    aside = options.aside * float(np.linalg.norm(span))
    grid = low + span * _even(options.grid)
    to_surface = _distances(shapes, grid)
    slab = 2.0 * float(np.prod(span) / len(grid)) ** (1.0 / 3.0)
    near = [np.flatnonzero(np.abs(to_surface[:, i]) < slab / 2) for i in range(len(shapes))]
    on = [
        grid[rows] - to_surface[rows, i, None] * shape.normals(grid[rows])
        for i, (rows, shape) in enumerate(zip(near, shapes, strict=True))
    ]
    surface = np.repeat(np.arange(len(shapes)), [len(rows) for rows in near])
    felt = np.concatenate([points - aside * normals, points + aside * normals, free])
    places = np.concatenate([np.empty((0, 3)), *on])
    beside = _distances(shapes, places) > 0
    inner, outer = beside.copy(), beside.copy()
    inner[np.arange(len(surface)), surface] = False
    outer[np.arange(len(surface)), surface] = True
    found, cell = distinct_rows(np.concatenate([to_surface > 0, _distances(shapes, felt) > 0, inner, outer]))
    count, g, n, s = len(found), len(grid), len(points), len(surface)
    of_grid, behind, before = cell[:g], cell[g : g + n], cell[g + n : g + 2 * n]
    went, passed = cell[g + 2 * n : g + len(felt)], _beside(grid, free, options.passed)
    sides = cell[g + len(felt) :]
    box = np.stack([points.min(axis=0), points.max(axis=0)]) + np.outer([-1, 1], [2 * aside] * 3)
    away = ((grid < box[0]) | (grid > box[1])).any(axis=1)
    held = np.bincount(of_grid, minlength=count).astype(float)
    gone = np.bincount(of_grid, away, minlength=count)
    seen = np.bincount(of_grid, passed, minlength=count)
    keys, which = np.unique(sides[:s] * count + sides[s:], return_inverse=True)
    volume = float(np.prod(span)) / g
    told = np.zeros(n, dtype=bool) if heard is None else heard
    bare = np.zeros(len(shapes), dtype=bool) if inferred is None else inferred
    counts = np.where(_unreached(shapes, bare, points[~told], places), options.unreached, 1.0)
    lies = np.abs(_distances(shapes, points)) < options.on * aside
    looks = np.stack([(shape.normals(points) * normals).sum(axis=1) for shape in shapes], axis=1)
    (felt_solid, heard_solid), (felt_free, heard_free) = (
        [np.bincount(side[rows], minlength=count) for rows in (~told, told)] for side in (behind, before)
    )
    return Arrangement(
        frozen(found, bool),
        frozen(held * volume),
        frozen(gone / np.maximum(held, 1)),
        frozen(_votes(felt_solid, heard_solid, felt_free, options)),
        frozen(_votes(felt_free, heard_free, felt_solid, options)),
        frozen(np.bincount(went, minlength=count).astype(float)),
        frozen(seen / np.maximum(held, 1)),
        frozen(np.stack([keys // count, keys % count], axis=1), np.int64),
        frozen(np.bincount(which, counts, minlength=len(keys)) * volume / slab),
        frozen(lies.sum(axis=0).astype(float)),
        frozen([(lies & (way * looks > options.along)).sum(axis=0) for way in (1.0, -1.0)]),
        frozen(bare, bool),
        frozen(np.zeros(len(shapes)) if stops is None else stops, bool),
    )


def _unreached(shapes: Sequence[Shape], bare: Bools, felt: Floats, places: Floats) -> Bools:
    """(s,) which of (s, 3) places lie nearer to a flat face that nobody felt than any of (n, 3) contacts does.

    All contacts are on its one side, as over a table that an object lies on: no array comes so low.
    """
    out = np.zeros(len(places), dtype=bool)
    if not len(felt):
        return out
    for shape, unfelt in zip(shapes, bare, strict=True):
        if (
            unfelt
            and isinstance(shape, Plane)
            and (nearest := -float(shape.signed_distance(felt).max())) > 0.0
        ):
            out |= shape.signed_distance(places) > -nearest
    return out


def _votes(felt: Ints, heard: Ints, against: Ints, options: ArrangementOptions) -> Floats:
    """(c,) votes for one label; hearsay does not outvote (c,) felt contacts that are `against` it."""
    believed = np.where(against < options.outvoted, heard, np.minimum(heard, options.hearsay))
    return np.asarray(felt + believed, dtype=float)


def _even(count: int) -> Floats:
    """(count, 3) of the unit cube, the same every time."""
    from scipy.stats import qmc  # takes as long as all else that an exploration imports of scipy

    return np.asarray(qmc.Sobol(3, scramble=True, rng=np.random.default_rng(0)).random(count))


def _distances(shapes: Sequence[Shape], points: Floats) -> Floats:
    if not shapes:
        return np.empty((len(points), 0))
    return np.stack([shape.signed_distance(points) for shape in shapes], axis=1)


def _beside(grid: Floats, places: Floats, within: float) -> Bools:
    """(g,) which points of a grid are `within` mm of one of (k, 3) places."""
    if not len(places):
        return np.zeros(len(grid), dtype=bool)
    return np.asarray(KDTree(places).query(grid, distance_upper_bound=within)[0] < within)


def distinct_rows(rows: Bools) -> tuple[Bools, Ints]:
    """The distinct rows, and which of them each row is."""
    packed = np.ascontiguousarray(np.packbits(rows, axis=1))
    keys = packed.view(np.dtype((np.void, packed.shape[1]))).ravel()
    _, first, which = np.unique(keys, return_index=True, return_inverse=True)
    return rows[first], which
