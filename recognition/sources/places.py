"""Contacts by place: what was read twice at one place says no more of the object than what was read once.

A logger that writes one reading again and again repeats it to the last digit.  One that reads on while the probe
stands still repeats what is wrong with the place, and shakes far less than contacts lie apart: of n contacts with
an extent L on faces the spacing is about L / sqrt(n), and readings much nearer than that, whose normals agree, are
of one place (our derivation).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.spatial import cKDTree

from primitives.arrays import Floats, Ints, frozen
from primitives.evidence import Contacts

_SHARE = 0.01  # of the spacing, within which readings are of one place: of 10 000 contacts on faces, three
_FEW = 0.02  # of the contacts, up to which it is chance that some lie where others do
_ALIKE = 0.2  # [rad] between their normals
_CELLS = 4  # to that length, in which readings are put together first: a place may hold thousands


def written_once(contacts: Contacts) -> Ints:
    """Rows of the contacts that repeat no earlier one to the last digit."""
    table = np.column_stack([contacts.points, contacts.normals, contacts.sigma]) + 0.0  # for -0.0 is 0.0
    as_bytes = np.ascontiguousarray(table).view(np.dtype((np.void, table.itemsize * table.shape[1])))
    rows: Ints = np.sort(np.unique(as_bytes.ravel(), return_index=True)[1])
    return rows


def one_a_place(contacts: Contacts) -> Contacts:
    """The first contact of each place, moved to the middle of all read there; as they are where few share one."""
    if not len(contacts):
        return contacts
    first, place, count = np.unique(
        _place_of(contacts), return_index=True, return_inverse=True, return_counts=True
    )[1:]
    if len(contacts) - len(first) < _FEW * len(contacts):
        return contacts
    points, normals = (_means(place, x, count) for x in (contacts.points, contacts.normals))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    order = np.argsort(first)
    kept = contacts.select(first[order])
    return replace(kept, points=frozen(points[order]), normals=frozen(normals[order]))


def _means(place: Ints, values: Floats, count: Ints) -> Floats:
    return np.column_stack([np.bincount(place, column) / count for column in values.T])


def _place_of(contacts: Contacts) -> Ints:
    """(n,) a number of each contact's place."""
    within = _SHARE * float(np.linalg.norm(np.ptp(contacts.points, axis=0))) / np.sqrt(len(contacts))
    if within <= 0.0:
        return np.zeros(len(contacts), dtype=np.int64)
    felt = np.where(contacts.has_normal[:, None], contacts.normals, 0.0)
    lifted = np.column_stack([contacts.points, within / _ALIKE * felt])
    cells, cell_of = np.unique(np.rint(lifted * (_CELLS / within)), axis=0, return_inverse=True)
    return _leaders(cells, float(_CELLS))[cell_of.ravel()]


def _leaders(points: Floats, within: float) -> Ints:
    """(n,) for each point one near it that leads itself; no two that lead are near each other.

    Of points in no order, in which few in a row wait for one another.
    """
    order = np.random.default_rng(0).permutation(len(points))
    pairs = cKDTree(points[order]).query_pairs(within, output_type="ndarray")
    leader = np.arange(len(points))
    while len(pairs):
        waits = np.zeros(len(points), dtype=bool)
        waits[pairs[:, 1]] = True
        led = pairs[~waits[pairs[:, 0]]]
        leader[led[:, 1]] = led[:, 0]
        done = ~waits
        done[led[:, 1]] = True
        pairs = pairs[~done[pairs].any(axis=1)]
    out = np.empty(len(points), dtype=np.int64)
    out[order] = order[leader]
    return out
