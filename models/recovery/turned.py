"""The axis that a neighborhood of facets was turned about, of all their normals at once.

On a surface of revolution every normal line meets the axis.  A line through p along n has the Pluecker coordinates
(n, m = p x n) and meets the axis (c, v), through x with v = x x c, where n . v + m . c = 0 (Pottmann and Wallner
2001), so that the axis is the least singular vector, with v eliminated, of all facets weighed by their area.  A
patch of a dozen fine facets tells no curvature along and across; about a known axis it does (`coaxial`).
"""

from __future__ import annotations

import numpy as np

from models.recovery.grow import Mesh
from primitives.arrays import Floats, Ints

_FEWEST = 60  # facets; of fewer a patch is a large part
_MISSED = 0.02  # of their distance from the axis, by which normal lines may miss it: root mean square
_ALONE = 10.0  # times as well as any other axis has this one to do, or it is a ball's or a bar's


def axis_of(mesh: Mesh, facets: Ints) -> tuple[Floats, Floats] | None:
    """A (3,) point [mm] of the axis and its (3,) direction, or None where facets have none in common."""
    thick = facets[~mesh.thin[facets]]
    if len(thick) < _FEWEST:
        return None
    weights = np.sqrt(mesh.flats.area[thick] / mesh.flats.area[thick].sum())[:, None]
    centers, normals = mesh.flats.center[thick], mesh.flats.normal[thick]
    middle = (weights**2 * centers).sum(axis=0)
    moments = np.cross(centers - middle, normals)
    needed = np.linalg.lstsq(weights * normals, weights * moments, rcond=1e-6)[0]
    left = weights * (moments - normals @ needed)
    values, axes = np.linalg.eigh(left.T @ left)
    along = axes[:, 0]
    point = middle + np.cross(along, -needed @ along)
    arms = np.linalg.norm(np.cross(centers - point, along), axis=1)
    missed, across = float(np.sqrt(max(values[0], 0.0))), float(np.sqrt((weights[:, 0] ** 2) @ arms**2))
    if missed > _MISSED * across or values[1] < _ALONE**2 * values[0]:
        return None
    return point, along
