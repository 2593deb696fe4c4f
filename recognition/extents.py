"""How far a face reaches, in the two lengths that its shape has.

=========  ====================================================================================
plane      length, width of the least rectangle round the face
cylinder   length along the axis, arc length round it
cone       distances from the apex, along the axis, where the face begins and ends
sphere     diameter of the face's rim circle (0 if whole), height of the cap
torus      arc length round the tube, round the axis
=========  ====================================================================================

The least rectangle has a side along the convex hull (Freeman and Shapira 1975).  A sphere's pole is its mean
normal; a face that lies evenly all round has no pole, and counts as whole.
"""

from collections.abc import Callable

import numpy as np
from scipy.spatial import ConvexHull

from primitives.arrays import Floats
from primitives.shapes import Cone, Cylinder, Plane, Shape, Sphere, Torus

_NO_POLE = 0.05  # length of the mean normal below which a spherical face lies evenly all round


def extent(shape: Shape, corners: Floats) -> tuple[float, float]:
    """The two lengths [mm] of a connected face given by its (t, 3, 3) triangles on the shape."""
    return _EXTENTS[type(shape)](shape, corners)


def _of_plane(shape: Plane, corners: Floats) -> tuple[float, float]:
    flat = (corners.reshape(-1, 3) - shape.origin) @ shape.frame[:, :2]
    rim = flat[ConvexHull(flat).vertices]
    sides = np.roll(rim, -1, axis=0) - rim
    sides /= np.linalg.norm(sides, axis=1, keepdims=True)
    across = np.stack([-sides[:, 1], sides[:, 0]], axis=1)
    reach = np.stack([np.ptp(rim @ sides.T, axis=0), np.ptp(rim @ across.T, axis=0)], axis=1)
    least = reach[np.argmin(reach.prod(axis=1))]
    return float(least.max()), float(least.min())


def _of_cylinder(shape: Cylinder, corners: Floats) -> tuple[float, float]:
    local = (corners - shape.origin) @ shape.frame
    turn = _covered(np.arctan2(local[..., 1], local[..., 0]))
    return float(np.ptp(local[..., 2])), shape.radius * turn


def _of_cone(shape: Cone, corners: Floats) -> tuple[float, float]:
    along = (corners - shape.apex) @ shape.axis
    return float(max(along.min(), 0.0)), float(along.max())


def _of_sphere(shape: Sphere, corners: Floats) -> tuple[float, float]:
    away = corners - shape.center
    area = np.linalg.norm(np.cross(away[:, 1] - away[:, 0], away[:, 2] - away[:, 0]), axis=1)
    pole = (area[:, None] * away.mean(axis=1)).sum(axis=0) / (area.sum() * shape.radius)
    if np.linalg.norm(pole) < _NO_POLE:
        return 0.0, 2 * shape.radius
    lowest = float((away @ (pole / np.linalg.norm(pole))).min())
    lowest = max(lowest, -shape.radius)
    return 2 * float(np.sqrt(max(shape.radius**2 - lowest**2, 0.0))), shape.radius - lowest


def _of_torus(shape: Torus, corners: Floats) -> tuple[float, float]:
    local = (corners - shape.anchor) @ shape.frame
    round_axis = np.arctan2(local[..., 1], local[..., 0])
    tube = np.arctan2(local[..., 2], np.hypot(local[..., 0], local[..., 1]) - shape.radius)
    return shape.minor_radius * _covered(tube), shape.radius * _covered(round_axis)


def _covered(angles: Floats) -> float:
    """The angle [rad] that (t, 3) triangles cover together: a full turn less the widest gap between them."""
    first = angles[:, :1]
    unwound = first + np.mod(angles - first + np.pi, 2 * np.pi) - np.pi
    low, high = unwound.min(axis=1), unwound.max(axis=1)
    begin = np.mod(low, 2 * np.pi)
    order = np.argsort(begin)
    begin, end = begin[order], (begin + high - low)[order]
    reached = np.maximum.accumulate(end)
    gaps = np.append(begin[1:], begin[0] + 2 * np.pi) - np.maximum(reached, reached[-1] - 2 * np.pi)
    widest = float(gaps.max())
    return 2 * np.pi - widest if widest > 1e-6 else 2 * np.pi


_EXTENTS: dict[type, Callable[..., tuple[float, float]]] = {
    Plane: _of_plane,
    Cylinder: _of_cylinder,
    Cone: _of_cone,
    Sphere: _of_sphere,
    Torus: _of_torus,
}
