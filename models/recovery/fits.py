"""A shape through facets: their corners lie on it, and their normals are nearly its normals at their middles.

Corners decide where they can; the middles of chords lie inside by the sag, so they weigh less, and mostly by
their normals, which give the fit its start and settle what few corners leave open.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from models.recovery.grow import Mesh, Reach
from primitives.arrays import Floats, Ints
from primitives.evidence import Contacts
from primitives.fit import Fit, FitOptions, NoFit, fit, refit
from primitives.shapes import Shape


@dataclass(frozen=True)
class FacetFitOptions:
    """What facets are worth as evidence."""

    most_corners: int = 160  # more are thinned out
    most_middles: int = 80
    normal: float = 0.4  # deviation of a facet's normal, in units of the typical turn between facets
    sag: float = 0.1  # and of its middle, in units of its size times that turn
    fit: FitOptions = field(default_factory=lambda: FitOptions(gain=1e-4, iterations=30, starts=2))


def corners_of(mesh: Mesh, facets: Ints) -> Ints:
    """Vertex numbers of the facets' corners, each once."""
    start = mesh.flats.start
    return np.unique(np.concatenate([mesh.flats.corners[start[f] : start[f + 1]] for f in facets]))


def evidence(mesh: Mesh, facets: Ints, turn: float, noise: float, options: FacetFitOptions) -> Contacts:
    """Corners without normals and middles with, of facets that turn by `turn` [rad] from one to the next."""
    thick = facets[~mesh.thin[facets]]
    corners = mesh.vertices[_thinned(corners_of(mesh, thick), options.most_corners)]
    middles = _thinned(thick, options.most_middles)
    size = np.sqrt(mesh.flats.area[middles])
    return Contacts.of(
        np.concatenate([corners, mesh.flats.center[middles]]),
        np.concatenate([np.full(corners.shape, np.nan), mesh.flats.normal[middles]]),
        np.concatenate([np.full(len(corners), noise), noise + options.sag * turn * size]),
        max(options.normal * turn, 0.01),
    )


def fit_facets(kind: str, contacts: Contacts, options: FacetFitOptions) -> Fit | NoFit:
    """The shape of a kind that explains the evidence best."""
    return fit(kind, contacts, options.fit)


def refit_facets(shape: Shape, convex: bool, contacts: Contacts, options: FacetFitOptions) -> Fit | NoFit:
    """The same from a shape that is near."""
    return refit(shape, convex, contacts, options.fit)


def depth(mesh: Mesh, shape: Shape, facets: Ints) -> Floats:
    """(n,) [mm] how far the facets' middles are from the shape."""
    away: Floats = np.abs(shape.signed_distance(mesh.flats.center[facets]))
    return away


def farthest(mesh: Mesh, shape: Shape, facets: Ints) -> Floats:
    """(n,) [mm] how far the farthest corner of each facet is from the shape."""
    flats = mesh.flats
    if not len(facets):
        return np.empty(0)
    count = flats.start[facets + 1] - flats.start[facets]
    first = np.cumsum(count) - count
    rows = np.repeat(flats.start[facets] - first, count) + np.arange(int(count.sum()))
    away = np.abs(shape.signed_distance(mesh.vertices[flats.corners[rows]]))
    return np.asarray(np.maximum.reduceat(away, first))


def cut_reach(mesh: Mesh, shape: Shape, facets: Ints, reach: Reach, noise: float) -> Reach:
    """How far corners that a boolean cut out of a shape's facets may be from it: new ones lie on the chords."""
    sag = float(np.quantile(depth(mesh, shape, facets), 0.9))
    return replace(reach, corner=3 * noise + 1.3 * sag, middle=3 * noise + 2.5 * sag)


def _thinned(rows: Ints, most: int) -> Ints:
    if len(rows) <= most:
        return rows
    return rows[np.linspace(0, len(rows) - 1, most).astype(np.int64)]
