"""Poses that lay contacts of one plane on an object's flat faces, box on box.

Of a face that contacts fill to its edges few poses hold them all, and a pair of samples hardly ever leads to one
of them.  Where the face is filled the least rectangle round it and that round the contacts are nearly one, so the
middles of the two are laid on each other at every turn (our derivation).  Where it is not, many poses hold the
contacts, and pairs find them.
"""

from __future__ import annotations

from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from models.library import Entry
from models.library.samples import SurfaceSamples
from primitives.arrays import Floats, frozen
from primitives.pose import frame_along
from recognition.matching.lone_face import LoneFace

_TURNS = 48  # of contacts on a face
_ANGLES = 18  # at which a face's rectangle is tried
_FLAT = 1e-3  # by how much the normals of a flat face may differ
_LEAST = 6  # samples of a face, below which its box is not known
_SHORT = 0.9  # of the contacts' diagonal, below which a face's does not hold them


class Flat(NamedTuple):
    """The box round one flat face, in the object's frame."""

    axes: Floats  # (3, 3) columns: along its sides, and the normal
    middle: Floats  # (3,) [mm]
    diagonal: float  # [mm]
    area: float  # [mm^2]
    points: Floats  # (m, 3) [mm] samples of it


_kept: WeakKeyDictionary[Entry, tuple[Flat, ...]] = WeakKeyDictionary()


def flats_of(entry: Entry) -> tuple[Flat, ...]:
    """Of all faces that are flat, made when first asked for."""
    found = _kept.get(entry)
    if found is None:
        found = _kept[entry] = _made(entry.samples)
    return found


def _made(samples: SurfaceSamples) -> tuple[Flat, ...]:
    found = []
    for face in np.unique(samples.face):
        rows = samples.face == face
        normals = samples.normals[rows]
        if rows.sum() < _LEAST or float(np.ptp(normals, axis=0).max()) > _FLAT:
            continue
        found.append(_boxed(samples.points[rows], normals.mean(axis=0), float(samples.area[rows].sum())))
    return tuple(found)


def laid_on(points: Floats, one: LoneFace, flats: tuple[Flat, ...]) -> Floats:
    """(k, 3, 4) poses object_from_world of (n, 3) contacts, all of which lie on `one` face."""
    ways = (one.facing,) if one.signed else (one.facing, -one.facing)
    return np.ascontiguousarray(np.concatenate([_laid(points, way, flats) for way in ways]))


def _laid(points: Floats, facing: Floats, flats: tuple[Flat, ...]) -> Floats:
    own = frame_along(facing)
    flat = points @ own  # (n, 3) in the plane's axes
    angles = 2.0 * np.pi * np.arange(_TURNS) / _TURNS
    turns = np.zeros((_TURNS, 3, 3))
    turns[:, 0, 0] = turns[:, 1, 1] = np.cos(angles)
    turns[:, 1, 0], turns[:, 0, 1] = np.sin(angles), -np.sin(angles)
    turns[:, 2, 2] = 1.0
    lying = np.einsum("tij,nj->tni", turns, flat)
    middles = 0.5 * (lying.min(axis=1) + lying.max(axis=1))
    middles[:, 2] = flat[:, 2].mean()
    diagonal = float(np.linalg.norm(np.ptp(flat[:, :2], axis=0)))
    poses = [np.empty((0, 3, 4))]
    for face in flats:
        if face.diagonal < _SHORT * diagonal:
            continue
        turned = face.axes @ turns @ own.T
        shift = face.middle - middles @ face.axes.T
        poses.append(np.concatenate([turned, shift[:, :, None]], axis=2))
    return np.concatenate(poses)


def _boxed(points: Floats, normal: Floats, whole: float) -> Flat:
    """The rectangle of least area round coplanar (n, 3) points of a face of the area `whole`."""
    across = frame_along(normal / np.linalg.norm(normal))
    flat = points @ across
    best, least = across, np.inf
    for angle in np.arange(_ANGLES) * (np.pi / 2.0 / _ANGLES):
        c, s = np.cos(angle), np.sin(angle)
        axes = across @ np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
        area = float(np.ptp(points @ axes[:, :2], axis=0).prod())
        if area < least:
            best, least = axes, area
    flat = points @ best
    low, high = flat.min(axis=0), flat.max(axis=0)
    diagonal = float(np.linalg.norm((high - low)[:2]))
    return Flat(frozen(best), frozen(best @ (0.5 * (low + high))), diagonal, whole, frozen(points))
