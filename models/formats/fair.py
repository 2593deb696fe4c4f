"""Corners moved off their exact surfaces by so little that facets and surfaces enclose the same volume.

A reader puts corners on the surface, so facets cut the corner and a round solid comes out too small (a cylinder
of 63 facets by 0.17 %).  With e the distance of a facet's points from its surface, whose mean over the facet is
that over the middles of its sides (exact for quadratics), a corner moves along the normal of each surface that
meets there by minus the area-weighted mean of e over that surface's facets round it: by the least motion that
does so for all of them, and never out of a plane (our derivation; equal facets of a cylinder come out fair to
fourth order).
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from models.body import LabeledSurface
from models.formats.labeled import LabeledMesh
from primitives.arrays import Bools, Floats, Ints, frozen

_FLAT = 1e-2  # singular values of normals below this are of surfaces that meet smoothly


class _Wish(NamedTuple):
    """How far each of some corners should move along one surface's normals."""

    corners: Ints  # (n,)
    normals: Floats  # (n, 3)
    step: Floats  # (n,) [mm]; nan where the corner must stay
    flat: Bools  # (n,) whether the surface is a plane, which corners do not leave


def fair(mesh: LabeledMesh) -> LabeledMesh:
    """The same triangles with corners moved; those of freeform faces stay."""
    wishes = list(_wishes(mesh))
    if not wishes:
        return mesh
    corner, normals, step, flat = (np.concatenate(column) for column in zip(*wishes, strict=True))
    order = np.argsort(corner, kind="stable")
    corner, normals, step, flat = corner[order], normals[order], step[order], flat[order]
    first = np.flatnonzero(np.diff(corner, prepend=-1))
    count = np.diff(np.append(first, len(corner)))
    vertices = mesh.vertices.copy()
    for meeting in np.unique(count):
        at = first[count == meeting]
        rows = at[:, None] + np.arange(meeting)
        motion = (np.linalg.pinv(normals[rows], rcond=_FLAT) @ step[rows][..., None])[..., 0]
        for k in (*range(meeting), *range(meeting)):
            away = np.where(flat[rows[:, k]], np.einsum("ij,ij->i", motion, normals[rows[:, k]]), 0.0)
            motion = motion - away[:, None] * normals[rows[:, k]]
        vertices[corner[at]] += np.where(np.isfinite(motion), motion, 0.0)
    return replace(mesh, vertices=frozen(vertices))


def _wishes(mesh: LabeledMesh) -> Iterator[_Wish]:
    order = np.argsort(mesh.labels, kind="stable")
    starts = np.searchsorted(mesh.labels[order], np.arange(len(mesh.surfaces) + 1))
    for number, surface in enumerate(mesh.surfaces):
        triangles = mesh.triangles[order[starts[number] : starts[number + 1]]]
        if len(triangles):
            yield _wish(mesh.vertices, triangles, surface)


def _wish(vertices: Floats, triangles: Ints, surface: LabeledSurface) -> _Wish:
    used, local = np.unique(triangles, return_inverse=True)
    if surface.shape is None:
        return _Wish(
            used, np.zeros((len(used), 3)), np.full(len(used), np.nan), np.zeros(len(used), dtype=bool)
        )
    normals = surface.shape.normals(vertices[used])
    corners = vertices[triangles]
    middles = (corners + np.roll(corners, -1, axis=1)).reshape(-1, 3) / 2
    off = surface.shape.signed_distance(middles).reshape(-1, 3).mean(axis=1)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    total, weight = (np.bincount(local.ravel(), np.repeat(x, 3), len(used)) for x in (area * off, area))
    flat = np.full(len(used), surface.shape.kind == "plane")
    return _Wish(used, normals, -total / np.maximum(weight, 1e-300), flat)
