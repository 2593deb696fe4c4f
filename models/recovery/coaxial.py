"""Cones, cylinders and tori about an axis that is known already: what turned parts are made of.

About a known axis a surface of revolution is a curve of (h, rho), along the axis and away from it: a line for a
cone, a circle for a torus, both linear to fit (the circle after Kasa 1976).  A free fit of a cone to one row of
facets creeps along a valley, in which semi-angle and tilt of the axis make up for each other.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from models.recovery.fits import corners_of
from models.recovery.grow import Mesh
from primitives.arrays import Floats, Ints
from primitives.shapes import Cone, Cylinder, Shape, Torus

_LOOSE = 12.0  # corner noises that the corners' root mean square may be off
_ASIDE = 0.2  # [rad] by which normals may miss the axis
_LEAST = 1e-3  # [1] slope of a cone's side that is none
_RANK = 1e-3  # [1] ratio of singular values below which corners do not tell a circle


def coaxial(
    mesh: Mesh, patch: Ints, axes: Sequence[tuple[Floats, Floats]], noise: float
) -> Iterator[tuple[Shape, bool]]:
    """Shapes about one of the axes (a point, a direction) that hold the corners of a patch; and whether convex."""
    if not axes:
        return
    points = mesh.vertices[corners_of(mesh, patch)]
    normals, middles = mesh.flats.normal[patch], mesh.flats.center[patch]
    origins, directions = (np.array(rows) for rows in zip(*axes, strict=True))
    round_ = np.cross(middles - origins[:, None], directions[:, None])  # (axes, facets, 3)
    missed = np.abs((round_ * normals).sum(axis=2)) > _ASIDE * np.linalg.norm(round_, axis=2)
    held = np.flatnonzero(~missed.any(axis=1))
    for origin, along in (axes[k] for k in held[_distinct(origins[held], directions[held])]):
        h = (points - origin) @ along
        rho = np.linalg.norm(points - origin - np.outer(h, along), axis=1)
        for shape in (_straight(origin, along, h, rho), _round(origin, along, h, rho, _LOOSE * noise)):
            if shape is None:
                continue
            off = shape.signed_distance(points)
            if float(np.sqrt((off**2).mean())) < _LOOSE * noise:
                facing = np.einsum("ij,ij->i", shape.normals(middles), normals)
                yield shape, bool(facing.sum() > 0)


def _straight(origin: Floats, along: Floats, h: Floats, rho: Floats) -> Shape | None:
    if np.ptp(h) <= _LEAST * np.ptp(rho):
        return None
    slope, start = np.polyfit(h, rho, 1)
    if abs(slope) < _LEAST:
        return Cylinder(origin, along, float(rho.mean()))
    apex = origin - along * (start / slope)
    return Cone(apex, along * np.sign(slope), float(np.arctan(abs(slope))))


def _round(origin: Floats, along: Floats, h: Floats, rho: Floats, loose: float) -> Shape | None:
    """A torus; one whose tube passes its own axis, as a wide fillet's does, where no ball does as well."""
    middle = np.array([h.mean(), rho.mean()])
    size = float(np.hypot(np.ptp(h), np.ptp(rho)))
    if not size > 0:
        return None
    x, y = (h - middle[0]) / size, (rho - middle[1]) / size
    rows = np.column_stack([2 * x, 2 * y, np.ones(len(x))])
    if np.linalg.svd(rows, compute_uv=False)[-1] < _RANK:
        return None
    a, b, c = np.linalg.lstsq(rows, x * x + y * y, rcond=None)[0]
    minor, major = size * float(np.sqrt(max(c + a * a + b * b, 0.0))), float(middle[1] + size * b)
    if not (minor > 0 and major > 0):
        return None
    if minor >= major and ((rho < major - loose).any() or _is_ball(h, rho, loose)):
        return None
    return Torus(origin + along * float(middle[0] + size * a), along, major, minor)


def _is_ball(h: Floats, rho: Floats, loose: float) -> bool:
    """Whether a circle about a point of the axis goes through the corners."""
    height = h - h.mean()
    squares = height**2 + rho**2
    a, c = np.linalg.lstsq(np.column_stack([2 * height, np.ones(len(h))]), squares, rcond=None)[0]
    off = np.hypot(height - a, rho) - np.sqrt(max(c + a * a, 0.0))
    return float(np.sqrt((off**2).mean())) < loose


def _distinct(origins: Floats, directions: Floats) -> Ints:
    """(k,) rows of the axes that are no earlier one again."""
    tilted = np.linalg.norm(np.cross(directions[:, None], directions[None]), axis=2)
    apart = np.linalg.norm(np.cross(origins[:, None] - origins[None], directions[None]), axis=2)
    same = (tilted < 1e-4) & (apart < 1e-3)
    return np.flatnonzero(~np.tril(same, -1).any(axis=1))
