"""How likely contacts are to lie where they do if all came from one side: anywhere on what looks that way.

A hand that reaches an object from one side, or a scan, feels all that faces it and nothing else, so that where
contacts end is where the object does.  A place whose normal n looks along v is reached with Phi((n . v - c) / s),
little where the touch would graze it, and A(v) is the object's area A with these weights.  With n_i the normals
that were felt::

    p(places | object, pose) = mean over v of  product over i of ((1 - e) Phi((n_i . v - c) / s) / A(v) + e / A)

over directions v all round and straight at the object's flat faces; what does not lie on the object came from
anywhere, with 1 / A (our derivation).  What one part of the object hides of another counts, as if it were reached.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.special import log_ndtr, logsumexp, ndtr

from models.library import Entry
from primitives.arrays import Floats, frozen
from recognition.matching.flats import flats_of

_ROUND = 240  # directions
_GRAZING = 0.1  # c
_SOFT = 0.06  # s: with the error of normals
_ALIKE = 0.05  # in each coordinate of normals that are taken for one, to make this once for every object fast
_OTHER = 0.01  # e: share of contacts that came from elsewhere


class Sides(NamedTuple):
    """Directions from which an object is seen, and how much of it."""

    directions: Floats  # (v, 3) unit, in the object's frame
    log_areas: Floats  # (v,) [mm^2]


def sides_of(entry: Entry) -> Sides:
    """Of an object, made once."""
    return entry.solid.body.remembered("sides", lambda: _made(entry))


def log_one_side(entry: Entry, turns: Floats, normals: Floats, on: Floats, counts: Floats) -> Floats:
    """(k,) logarithms of p(places | object, pose) at (k, 3, 3) turns object_from_world, of (n, 3) normals.

    A (k, n) share of each contact lies on the object; each counts so much (n,).
    """
    sides = sides_of(entry)
    along = np.einsum("vi,kij,nj->kvn", sides.directions, turns, normals, optimize=True)
    everywhere = np.log(entry.solid.area)
    reached = log_ndtr((along - _GRAZING) / _SOFT) - sides.log_areas[:, None]
    seen = np.logaddexp(reached + np.log1p(-_OTHER), np.log(_OTHER) - everywhere)
    seen = on[:, None] * seen - (1.0 - on[:, None]) * everywhere
    each = seen @ counts
    return np.asarray(logsumexp(each, axis=1) - np.log(len(sides.directions)))


def _made(entry: Entry) -> Sides:
    body = entry.solid.body
    straight = [flat.axes[:, 2] for flat in flats_of(entry)]
    directions = np.concatenate([_all_round(), np.reshape(straight, (-1, 3))])
    normals, areas = _by_normal(body.triangle_normals, body.triangle_areas)
    area = ndtr((normals @ directions.T - _GRAZING) / _SOFT).T @ areas
    return Sides(frozen(directions), frozen(np.log(area)))


def _by_normal(normals: Floats, areas: Floats) -> tuple[Floats, Floats]:
    """(n, 3) mean normals of facets that look alike, within a fraction of the softness, and their (n,) areas."""
    normals, areas = normals[areas > 0.0], areas[areas > 0.0]  # a facet without area has no normal
    cell = np.round(normals / _ALIKE).astype(np.int64) + int(1.0 / _ALIKE) + 1
    side = 2 * int(1.0 / _ALIKE) + 3
    _, of = np.unique((cell[:, 0] * side + cell[:, 1]) * side + cell[:, 2], return_inverse=True)
    together = np.asarray(np.bincount(of, areas), dtype=np.float64)
    mean = np.column_stack([np.bincount(of, areas * normals[:, k]) for k in range(3)]) / together[:, None]
    return mean, together


@cache
def _all_round() -> Floats:
    """(v, 3) unit vectors, even by area: the golden spiral."""
    k = np.arange(_ROUND) + 0.5
    z, turn = 1.0 - 2.0 * k / _ROUND, np.pi * (1.0 + np.sqrt(5.0)) * k
    flat = np.sqrt(1.0 - z**2)
    return frozen(np.column_stack([flat * np.cos(turn), flat * np.sin(turn), z]))
