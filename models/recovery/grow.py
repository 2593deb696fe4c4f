"""Facets that lie on one exact surface, gathered from neighbor to neighbor.

Corners of a tessellation are on the surface and its flats are chords, so a facet belongs where all its corners
are near the surface, its middle is no deeper than a chord may be, and its normal is the surface's within the
angle that a facet spans.  A large flat that is tangent to a fillet fails by its far corners; the flat of a shaft,
whose corners are all on the round, fails by its middle and by its normal.
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
_APEX = 900.0  # a cone has no normal within this many squared tolerances of its apex


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
    sizes = [*shape.sizes, 0.0, 0.0][:2]
    coded = np.array([_KIND[shape.kind], *shape.anchor, *shape.direction, *sizes, 1.0 if convex else -1.0])
    limits = np.array(
        [reach.corner, reach.middle, np.cos(reach.tilt), np.cos(0.7 * reach.tilt), reach.smooth]
    )
    flats, creases = mesh.flats, mesh.creases
    return np.asarray(
        _grow(
            coded,
            mesh.vertices,
            (flats.corners, flats.start),
            (flats.normal, flats.center, mesh.thin),
            (creases.start, creases.other, creases.turn),
            seeds,
            free,
            limits,
        )
    )


@njit(cache=True)
def _field(shape, x, y, z):  # type: ignore[no-untyped-def]
    """Signed distance and unit gradient, of the solid's side, of a coded shape at a point."""
    kind, sign = int(shape[0]), shape[9]
    x, y, z = x - shape[1], y - shape[2], z - shape[3]
    ax, ay, az = shape[4], shape[5], shape[6]
    h = x * ax + y * ay + z * az
    if kind == 0:
        return h, sign * ax, sign * ay, sign * az
    if kind == 3:
        far = max(np.sqrt(x * x + y * y + z * z), 1e-12)
        return far - shape[7], sign * x / far, sign * y / far, sign * z / far
    x, y, z = x - h * ax, y - h * ay, z - h * az
    rho = np.sqrt(x * x + y * y + z * z)
    radial = 1.0 / max(rho, 1e-12)
    axial = 0.0
    if kind == 1:
        d = rho - shape[7]
    elif kind == 2:
        c, s = np.cos(shape[7]), np.sin(shape[7])
        d = rho * c - h * s
        radial, axial = radial * c, -s
    else:
        out = rho - shape[7]
        far = max(np.sqrt(out * out + h * h), 1e-12)
        d = far - shape[8]
        radial, axial = radial * out / far, h / far
    return (
        d,
        sign * (radial * x + axial * ax),
        sign * (radial * y + axial * ay),
        sign * (radial * z + axial * az),
    )


@njit(cache=True)
def _fits(shape, vertices, corners, begin, end, normal, center, thin, limits):  # type: ignore[no-untyped-def]
    for i in range(begin, end):
        p = vertices[corners[i]]
        d, x, y, z = _field(shape, p[0], p[1], p[2])
        if abs(d) > limits[0]:
            return False
        if thin or x * normal[0] + y * normal[1] + z * normal[2] >= limits[2]:
            continue
        far = (p[0] - shape[1]) ** 2 + (p[1] - shape[2]) ** 2 + (p[2] - shape[3]) ** 2
        if shape[0] != 2 or far > _APEX * limits[0] ** 2:
            return False
    if thin:
        return True
    d, x, y, z = _field(shape, center[0], center[1], center[2])
    return abs(d) <= limits[1] and x * normal[0] + y * normal[1] + z * normal[2] >= limits[3]


@njit(cache=True)
def _grow(shape, vertices, outlines, faces, links, seeds, free, limits):  # type: ignore[no-untyped-def]
    corners, start = outlines
    normal, center, thin = faces
    first, other, turn = links
    n = len(thin)
    seen = np.zeros(n, dtype=np.bool_)
    queue = np.empty(n, dtype=np.int64)
    size, at = 0, -1
    while at < size:
        begin, end = (0, len(seeds)) if at < 0 else (first[queue[at]], first[queue[at] + 1])
        for i in range(begin, end):
            g = seeds[i] if at < 0 else other[i]
            if seen[g] or not (at < 0 or free[g]):
                continue
            if at >= 0 and abs(turn[i]) > limits[4] and not thin[g] and not thin[queue[at]]:
                continue
            seen[g] = True
            if _fits(shape, vertices, corners, start[g], start[g + 1], normal[g], center[g], thin[g], limits):
                queue[size] = g
                size += 1
        at += 1
    return queue[:size].copy()
