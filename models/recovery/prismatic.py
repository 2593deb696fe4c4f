"""Cylinders and cones whose chords a boolean cut, from the planes of the chords.

A modeler that builds round things from n-sided ones cuts their sides, and then few corners are left on the
surface; but every side keeps its plane, and all of them touch one inscribed cylinder or pass through one apex.
With n the normals and c the middles of the sides (our derivation)::

    n . axis = s            the same for all; s = 0 for a cylinder, -sin(semi-angle inscribed) for a cone
    n . (c - origin) = a    for a cylinder, a the apothem; the corners were at a / cos(turn / 2)
    n . (c - apex) = 0      for a cone

which are linear, and hold to rounding: no freeform surface passes by chance.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.recovery.grow import Mesh
from primitives.arrays import Bools, Floats, Ints
from primitives.shapes import Cone, Cylinder

_STRAIGHT = 3e-3  # [1] a cosine of normal and axis below this is a cylinder's


@dataclass(frozen=True)
class Prismatic:
    """A round surface through the corners that an uncut n-sided solid would have, and its inscribed one."""

    shape: Cylinder | Cone
    convex: bool
    inscribed: Cylinder | Cone

    def touched(self, mesh: Mesh, facets: Ints, noise: float) -> Bools:
        """(n,) whether the planes of facets touch the inscribed surface, to rounding."""
        normal = mesh.flats.normal[facets] * (1.0 if self.convex else -1.0)
        rounding = 3e-4 + 4 * noise / np.sqrt(mesh.flats.area[facets])
        axis, offset = self.inscribed.axis, mesh.flats.center[facets] - self.inscribed.anchor
        slope, away = normal @ axis, np.einsum("ij,ij->i", normal, offset)
        if isinstance(self.inscribed, Cone):
            across = np.linalg.norm(offset, axis=1)
            slope = slope + np.sin(self.inscribed.semi_angle)
            return np.asarray((np.abs(slope) < rounding) & (np.abs(away) < 4 * noise + rounding * across))
        off = np.abs(away - slope * (offset @ axis) - self.inscribed.radius)
        return np.asarray((np.abs(slope) < rounding) & (off < 4 * noise + 1e-4 * self.inscribed.radius))


def fit_planes(mesh: Mesh, facets: Ints, turn: float) -> Prismatic | None:
    """The round surface that facets, which turn by `turn` [rad] from one to the next, were sides of."""
    normal, center = mesh.flats.normal[facets], mesh.flats.center[facets]
    mean = normal.mean(axis=0)
    spread = np.linalg.svd(normal - mean)[2]
    axis = spread[2]
    slope = float(mean @ axis)
    if abs(slope) < max(_STRAIGHT, 0.05 * turn):
        return _cylinder(normal, center, turn)
    return _cone(normal, center, axis * -np.sign(slope), turn)


def _cylinder(normal: Floats, center: Floats, turn: float) -> Prismatic | None:
    axis = np.linalg.svd(normal)[2][2]
    middle = center.mean(axis=0)
    offset = np.einsum("ij,ij->i", normal, center - middle)
    solution = _solved(np.column_stack([normal, np.ones(len(normal))]), offset)
    apothem = float(solution[3])
    if not 1e-9 < abs(apothem) < 1e6:
        return None
    origin = middle + solution[:3] - axis * (solution[:3] @ axis)
    outer = abs(apothem) / np.cos(turn / 2)
    return Prismatic(Cylinder(origin, axis, outer), apothem > 0, Cylinder(origin, axis, abs(apothem)))


def _cone(normal: Floats, center: Floats, axis: Floats, turn: float) -> Prismatic | None:
    middle = center.mean(axis=0)
    apex = middle + _solved(normal, np.einsum("ij,ij->i", normal, center - middle))
    inward = axis if (middle - apex) @ axis > 0 else -axis
    inner = float(np.arcsin(np.clip(abs(normal.mean(axis=0) @ axis), 1e-6, 1 - 1e-9)))
    # the sides turn by `turn` about the cone's axis only as far as their normals are across it
    round_axis = 2 * np.arcsin(np.clip(np.sin(turn / 2) / np.cos(inner), 0.0, 0.9))
    outer = float(np.arctan(np.tan(inner) / np.cos(round_axis / 2)))
    convex = bool((normal.mean(axis=0) @ inward) < 0)
    return Prismatic(Cone(apex, inward, outer), convex, Cone(apex, inward, inner))


def _solved(rows: Floats, values: Floats) -> Floats:
    return np.asarray(np.linalg.lstsq(rows, values, rcond=1e-7)[0])
