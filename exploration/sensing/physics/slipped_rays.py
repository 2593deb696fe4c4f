"""Rays that met a back face: those that began inside the object, and those that slipped by its surface.

Rays are cast in single precision, so that one which runs along the object's outline, or between two of its
triangles, may miss the face in front and meet the one behind.  A hair's breadth aside it does not.
"""

import numpy as np
from numba import njit
from numpy.typing import NDArray

from primitives.arrays import Bools, Floats, Ints
from primitives.surface import TriangleSurface

MISS, HIT, INSIDE = 0, 1, 2  # what a corner's ray met
_ASIDE = 1e-3 * np.array([[0.8, 0.6], [-0.6, 0.8], [-0.8, -0.6]])  # [mm] where slipped rays are cast again
Singles = NDArray[np.float32]
Indices = NDArray[np.int32]


def cast_again(
    surface: TriangleSurface,
    pose: Floats,
    origins: Singles,
    directions: Singles,
    vertices: Floats,
    triangles: Indices,
    hits: Indices,
) -> None:
    """Put right the (n,) triangles that rays hit from behind, of those that did so by slipping past a front."""
    behind = np.flatnonzero(_from_behind(directions, vertices, triangles, hits))
    for aside in _ASIDE if len(behind) else ():
        moved = origins[behind] + (pose[:3, :2] @ aside).astype(np.float32)
        _, found = surface.first_hits(moved, directions[behind])
        slipped = ~_from_behind(directions[behind], vertices, triangles, found)
        hits[behind[slipped]] = found[slipped]
        behind = behind[~slipped]


@njit(cache=True, error_model="numpy")
def _from_behind(directions: Singles, vertices: Floats, triangles: Indices, hits: Indices) -> Bools:
    """(n,) whether rays met a face that looks their way."""
    found = np.zeros(len(hits), np.bool_)
    for i in range(len(hits)):
        if hits[i] >= 0:
            nx, ny, nz = _normal(vertices, triangles, hits[i])
            found[i] = nx * directions[i, 0] + ny * directions[i, 1] + nz * directions[i, 2] >= 0.0
    return found


@njit(cache=True, error_model="numpy")
def plane_of(pose: Floats, vertices: Floats, triangles: Ints, t: int) -> tuple[float, float, float, float]:
    """Height at the sensor's axis and slopes of a triangle's plane, and its normal's part along the rays."""
    a = triangles[t, 0]
    nx, ny, nz = _normal(vertices, triangles, t)
    along_x = nx * pose[0, 0] + ny * pose[1, 0] + nz * pose[2, 0]
    along_y = nx * pose[0, 1] + ny * pose[1, 1] + nz * pose[2, 1]
    along_z = nx * pose[0, 2] + ny * pose[1, 2] + nz * pose[2, 2]
    reach = (
        nx * (vertices[a, 0] - pose[0, 3])
        + ny * (vertices[a, 1] - pose[1, 3])
        + nz * (vertices[a, 2] - pose[2, 3])
    )
    return reach / along_z, -along_x / along_z, -along_y / along_z, along_z


@njit(cache=True, error_model="numpy", inline="always")
def _normal(vertices: Floats, triangles: Ints, t: int) -> tuple[float, float, float]:
    """Of a triangle, twice its area long."""
    a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
    ux, uy, uz = (
        vertices[b, 0] - vertices[a, 0],
        vertices[b, 1] - vertices[a, 1],
        vertices[b, 2] - vertices[a, 2],
    )
    vx, vy, vz = (
        vertices[c, 0] - vertices[a, 0],
        vertices[c, 1] - vertices[a, 1],
        vertices[c, 2] - vertices[a, 2],
    )
    return uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
