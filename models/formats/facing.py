"""How much of a closed surface shows its back to who looks from outside: none, unless it passes through itself.

A STEP file may have a round face trimmed to its other half, which still closes and is inside out there.
"""

import numpy as np

from models.solid import Solid

_LINES = 40  # of a grid, each way
_OFF = 0.31  # of a cell, that a grid is moved, so that no ray runs along what lies in the middle


def seen_from_behind(solid: Solid) -> float:
    """Share of the rays from outside, on grids along each axis, that meet the back of a triangle first."""
    low, high = solid.bounds
    size = high - low
    turned = met = 0
    for axis in range(3):
        u, v = (k for k in range(3) if k != axis)
        places = (np.arange(_LINES) + 0.5 + _OFF * np.array([[1.0], [-1.0]]) / 2.0) / _LINES
        grid = np.stack(np.meshgrid(places[0], places[1]), axis=-1).reshape(-1, 2)
        for end, way in ((low, 1.0), (high, -1.0)):
            origins = np.empty((len(grid), 3))
            origins[:, (u, v)] = low[[u, v]] + grid * size[[u, v]]
            origins[:, axis] = end[axis] - way * size.max()
            directions = np.zeros_like(origins)
            directions[:, axis] = way
            _, hit = solid.first_hits(origins.astype(np.float32), directions.astype(np.float32))
            corners = solid.vertices[solid.triangles[hit[hit >= 0]]]
            normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
            met += len(normals)
            turned += int((way * normals[:, axis] > 0.0).sum())
    return turned / met if met else 0.0
