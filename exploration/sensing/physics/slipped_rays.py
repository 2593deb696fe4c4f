"""Rays that met a back face: those that began inside the object, and those that slipped by its surface.

Rays are cast in single precision, so that one which runs along the object's outline, or between two of its
triangles, may miss the face in front and meet the one behind.
"""

import numpy as np
from numba import njit

from primitives.arrays import Floats, Ints

MISS, HIT, INSIDE = 0, 1, 2  # what a corner's ray met
_GRAZE = 1e-4  # [mm] beside an edge in the sensor's view, within which rays may slip by it


@njit(cache=True, error_model="numpy")
def plane_of(pose: Floats, vertices: Floats, triangles: Ints, t: int) -> tuple[float, float, float, float]:
    """Height at the sensor's axis and slopes of a triangle's plane, and its normal's part along the rays."""
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
    nx, ny, nz = uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx
    along_x = nx * pose[0, 0] + ny * pose[1, 0] + nz * pose[2, 0]
    along_y = nx * pose[0, 1] + ny * pose[1, 1] + nz * pose[2, 1]
    along_z = nx * pose[0, 2] + ny * pose[1, 2] + nz * pose[2, 2]
    reach = (
        nx * (vertices[a, 0] - pose[0, 3])
        + ny * (vertices[a, 1] - pose[1, 3])
        + nz * (vertices[a, 2] - pose[2, 3])
    )
    return reach / along_z, -along_x / along_z, -along_y / along_z, along_z


@njit(cache=True, error_model="numpy")
def grazed(
    pose: Floats, x: float, y: float, vertices: Floats, triangles: Ints, neighbors: Ints, t: int
) -> bool:
    """Whether a ray that met a back face passed the object's outline: along the edge of a face turned to it."""
    for i in range(3):
        n = neighbors[t, i]
        if n < 0 or plane_of(pose, vertices, triangles, n)[3] >= 0.0:
            continue
        p, q = vertices[triangles[t, i]], vertices[triangles[t, (i + 1) % 3]]
        px = py = along_x = along_y = 0.0
        for k in range(3):
            px += pose[k, 0] * (p[k] - pose[k, 3])
            py += pose[k, 1] * (p[k] - pose[k, 3])
            along_x += pose[k, 0] * (q[k] - p[k])
            along_y += pose[k, 1] * (q[k] - p[k])
        beside = (x - px) * along_y - (y - py) * along_x
        if abs(beside) <= _GRAZE * np.hypot(along_x, along_y):
            return True
    return False


@njit(cache=True, error_model="numpy")
def settle_inside(corners: Floats, kinds: Ints, x_edges: Floats, y_edges: Floats, start: float) -> bool:
    """Turn rays that slipped between triangles into misses; whether any other began inside the object."""
    any_inside = False
    for r in range(kinds.shape[0]):
        for c in range(kinds.shape[1]):
            if kinds[r, c] == INSIDE:
                if _leaked(r, c, corners, kinds, x_edges, y_edges, start):
                    kinds[r, c] = MISS
                else:
                    any_inside = True
    return any_inside


@njit(cache=True, error_model="numpy")
def _leaked(
    r: int, c: int, corners: Floats, kinds: Ints, x_edges: Floats, y_edges: Floats, start: float
) -> bool:
    """Whether a ray that met a back face slipped between two triangles: a neighbor expects it to be outside."""
    for i in range(max(r - 1, 0), min(r + 2, kinds.shape[0])):
        for j in range(max(c - 1, 0), min(c + 2, kinds.shape[1])):
            if kinds[i, j] == HIT:
                z = corners[0, i, j] + corners[1, i, j] * (x_edges[c] - x_edges[j])
                if z + corners[2, i, j] * (y_edges[r] - y_edges[i]) > -start:
                    return True
    return False
