"""Bodies with no face of a named shape, and what common ways make of contacts on them."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import trimesh
from scipy.interpolate import RBFInterpolator
from scipy.spatial import ConvexHull

from models.solid import Solid
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.pose import random_rotation

MARGIN = 8.0  # [mm] around a body that a grid covers
STEP = 1.5  # [mm] between points of the grids that rivals are meshed on
_OFFSET = 2.0  # [mm] before and behind the surface, where a distance is given to the interpolation
_NEIGHBORS = 60  # of the interpolation at a place


def smooth_body(rng: np.random.Generator) -> Solid:
    """One to four ellipsoids in a chain, melted into each other; its longest side is 60 to 160 mm."""
    places, place = [np.zeros(3)], np.zeros(3)
    for _ in range(int(rng.integers(0, 4))):
        way = rng.normal(size=3)
        place = place + rng.uniform(0.7, 1.1) * way / np.linalg.norm(way)
        places.append(place)
    centers = np.array(places)
    frames = [random_rotation(rng) for _ in centers]
    semi = rng.uniform(0.5, 1.0, size=(len(centers), 3))
    blend = rng.uniform(0.08, 0.2)

    def field(points: Floats) -> Floats:
        each = [
            _ellipsoid((points - center) @ frame, axes)
            for center, frame, axes in zip(centers, frames, semi, strict=True)
        ]
        # the logarithm of a sum of exponentials: least of all distances, with its creases rounded
        return -blend * np.logaddexp.reduce(-np.array(each) / blend, axis=0)

    low, high = centers.min(axis=0) - 1.6, centers.max(axis=0) + 1.6
    found = Solid.from_field(field, low, high, 0.03)
    scale = rng.uniform(60.0, 160.0) / float(found.extent.max())
    return Solid.from_mesh(scale * found.vertices, found.triangles)


def _ellipsoid(points: Floats, semi: Floats) -> Floats:
    """Distances from an ellipsoid, to first order."""
    out, slope = points / semi, points / semi**2
    radius = np.linalg.norm(out, axis=1)
    return (radius - 1.0) * radius / np.maximum(np.linalg.norm(slope, axis=1), 1e-9)


def hull(contacts: Contacts) -> Solid:
    """What the contacts span."""
    found = trimesh.convex.convex_hull(ConvexHull(contacts.points).points)
    return Solid.from_mesh(found.vertices, found.faces)


def radial(contacts: Contacts) -> Solid:
    """Distances at, before and behind each contact, interpolated by radial functions (Carr et al. 2001)."""
    points, normals = contacts.points, contacts.normals
    places = np.concatenate([points, points + _OFFSET * normals, points - _OFFSET * normals])
    values = np.repeat([0.0, _OFFSET, -_OFFSET], len(points))
    through = RBFInterpolator(
        places, values, neighbors=_NEIGHBORS, kernel="thin_plate_spline", smoothing=0.1, degree=1
    )
    return meshed(lambda at: np.asarray(through(at)), contacts)


def meshed(field: Callable[[Floats], Floats], contacts: Contacts) -> Solid:
    """The largest part of where a field is negative."""
    low, high = contacts.points.min(axis=0) - MARGIN, contacts.points.max(axis=0) + MARGIN
    return Solid.from_field(field, low, high, STEP).largest_part()
