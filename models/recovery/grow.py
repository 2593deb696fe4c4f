"""Facets that lie on one exact surface, gathered from neighbor to neighbor.

Corners of a tessellation are on the surface and its flats are chords, so a facet belongs where all its corners are
near the surface, its middle is no deeper than a chord may be, and its normal is the surface's within the angle that
a facet spans.  A large flat that is tangent to a fillet fails by its far corners; the flat of a shaft, whose corners
are all on the round, fails by its middle and by its normal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit

from models.recovery.creases import Creases
from models.recovery.flats import Flats
from primitives.arrays import Bools, Floats, Ints
from primitives.shapes import Shape

_KIND = {"plane": 0, "cylinder": 1, "cone": 2, "sphere": 3, "torus": 4}


@dataclass(frozen=True)
class Mesh:
    """Vertices, their flat facets and how these meet."""

    vertices: Floats  # (v, 3) [mm]
    flats: Flats
    creases: Creases
    thin: Bools  # (f,) facets whose normal is noise


@dataclass(frozen=True)
class Reach:
    """How far from a surface its facets may be."""

    corner: float  # [mm] of a corner
    middle: float  # [mm] of a facet's centroid
    tilt: float  # [rad] between the facet's normal and the surface's at a corner
    smooth: float  # [rad] the greatest turn between neighbors


def grow(mesh: Mesh, shape: Shape, convex: bool, seeds: Ints, free: Bools, reach: Reach) -> Ints:
    """Seeds that fit, and every free facet that is reached from them and fits."""
    sizes = np.zeros(2)
    sizes[: len(shape.sizes)] = shape.sizes
    flats, creases = mesh.flats, mesh.creases
    return np.asarray(
        _grow(
            _KIND[shape.kind],
            np.asarray(shape.anchor),
            np.asarray(shape.direction),
            sizes,
            1.0 if convex else -1.0,
            mesh.vertices,
            flats.corners,
            flats.start,
            flats.normal,
            flats.center,
            mesh.thin,
            creases.start,
            creases.other,
            creases.turn,
            seeds,
            free,
            np.array(
                [reach.corner, reach.middle, np.cos(reach.tilt), np.cos(0.7 * reach.tilt), reach.smooth]
            ),
        )
    )


@njit(cache=True)
def _field(kind, anchor, axis, sizes, p):  # type: ignore[no-untyped-def]
    """Signed distance and unit gradient of a shape at a point."""
    q = p - anchor
    z = (q * axis).sum()
    if kind == 0:
        return z, axis[0], axis[1], axis[2]
    if kind == 3:
        far = max(np.sqrt((q * q).sum()), 1e-12)
        return far - sizes[0], q[0] / far, q[1] / far, q[2] / far
    across = q - z * axis
    rho = np.sqrt((across * across).sum())
    if rho > 1e-12:
        across = across / rho
    if kind == 1:
        return rho - sizes[0], across[0], across[1], across[2]
    if kind == 2:
        c, s = np.cos(sizes[0]), np.sin(sizes[0])
        n = c * across - s * axis
        return rho * c - z * s, n[0], n[1], n[2]
    out = rho - sizes[0]
    far = max(np.sqrt(out * out + z * z), 1e-12)
    n = out / far * across + z / far * axis
    return far - sizes[1], n[0], n[1], n[2]


@njit(cache=True)
def _fits(kind, anchor, axis, sizes, sign, vertices, corners, begin, end, normal, center, thin, limits):  # type: ignore[no-untyped-def]
    for i in range(begin, end):
        d, x, y, z = _field(kind, anchor, axis, sizes, vertices[corners[i]])
        if abs(d) > limits[0]:
            return False
        at_apex = kind == 2 and ((vertices[corners[i]] - anchor) ** 2).sum() < 900.0 * limits[0] ** 2
        if not thin and not at_apex and sign * (x * normal[0] + y * normal[1] + z * normal[2]) < limits[2]:
            return False
    if thin:
        return True
    d, x, y, z = _field(kind, anchor, axis, sizes, center)
    return abs(d) <= limits[1] and sign * (x * normal[0] + y * normal[1] + z * normal[2]) >= limits[3]


@njit(cache=True)
def _grow(  # type: ignore[no-untyped-def]
    kind,
    anchor,
    axis,
    sizes,
    sign,
    vertices,
    corners,
    start,
    normal,
    center,
    thin,
    first,
    other,
    turn,
    seeds,
    free,
    limits,
):
    n = len(normal)
    seen = np.zeros(n, dtype=np.bool_)
    out = np.empty(n, dtype=np.int64)
    size = 0
    for f in seeds:
        if not seen[f]:
            seen[f] = True
            if _fits(
                kind,
                anchor,
                axis,
                sizes,
                sign,
                vertices,
                corners,
                start[f],
                start[f + 1],
                normal[f],
                center[f],
                thin[f],
                limits,
            ):
                out[size] = f
                size += 1
    at = 0
    while at < size:
        f = out[at]
        at += 1
        for i in range(first[f], first[f + 1]):
            g = other[i]
            if seen[g] or not free[g]:
                continue
            if abs(turn[i]) > limits[4] and not thin[f] and not thin[g]:
                continue
            seen[g] = True
            if _fits(
                kind,
                anchor,
                axis,
                sizes,
                sign,
                vertices,
                corners,
                start[g],
                start[g + 1],
                normal[g],
                center[g],
                thin[g],
                limits,
            ):
                out[size] = g
                size += 1
    return out[:size].copy()
