"""Shapes through a few oriented contacts each, many at a time, in closed form.

With p the points of a group, n their outward normals, and all sums over the group (see `primitives.starts` for the
same one at a time; the plane's is our derivation)::

    plane      normal: least eigenvector of  sum (p - c)(p - c)' / sigma^2 - sum n n' / normal_sigma^2
    sphere     p - r n = c, linear in (c, r)
    cylinder   axis: least eigenvector of sum n n'; then as the sphere, across the axis
    cone       apex: n . (p - apex) = 0; axis: least eigenvector of the centered normals: n . axis is constant

Two contacts give a plane, a sphere and a cylinder; three give a cone too.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from primitives.arrays import Bools, Floats, Ints
from primitives.segmentation.misfit import turned
from primitives.shapes import Cone, Cylinder, Plane, Shape, Sphere

_LEAST_ANGLE, _LARGEST_ANGLE = 0.05, 1.45  # [rad] semi-angles between which a cone is proposed


@dataclass(frozen=True)
class Proposals:
    """Shapes of one kind."""

    kind: str
    anchor: Floats  # (g, 3) a point of the plane, a point of the axis, the center, the apex [mm]
    axis: Floats  # (g, 3) unit: outward normal, axis, or from the apex into the cone
    size: Floats  # (g,) radius [mm], or semi-angle [rad]
    sign: Floats  # (g,) -1 where the material is outside
    group: Ints  # (g,) which group of contacts it goes through

    def __len__(self) -> int:
        return len(self.anchor)

    def select(self, rows: Bools | Ints) -> Proposals:
        """Some of them."""
        anchor, axis, size = self.anchor[rows], self.axis[rows], self.size[rows]
        return Proposals(self.kind, anchor, axis, size, self.sign[rows], self.group[rows])

    def shape(self, row: int) -> tuple[Shape, float]:
        """One of them, and its sign."""
        anchor, axis, size = self.anchor[row], self.axis[row], float(self.size[row])
        made: Shape
        if self.kind == "plane":
            made = Plane(anchor, axis)
        elif self.kind == "sphere":
            made = Sphere(anchor, size)
        elif self.kind == "cylinder":
            made = Cylinder(anchor, axis, size)
        else:
            made = Cone(anchor, axis, size)
        return made, float(self.sign[row])

    def misfit(
        self, points: Floats, normals: Floats, weight: Floats, turn_weight: Floats, felt: Bools
    ) -> Floats:
        """(g, n) chi2 of each contact; points (n, 3) for all, or (g, n, 3) for each its own."""
        offset = points - self.anchor[:, None]
        along = np.einsum("gnj,gj->gn", offset, self.axis)
        if self.kind == "plane":
            distance = along
            outward = np.broadcast_to(self.axis[:, None], offset.shape)
        elif self.kind == "sphere":
            reach = np.sqrt((offset**2).sum(axis=2))
            distance = reach - self.size[:, None]
            outward = offset / np.maximum(reach, 1e-9)[..., None]
        else:
            radial = offset - along[..., None] * self.axis[:, None]
            rho = np.sqrt((radial**2).sum(axis=2))
            radial /= np.maximum(rho, 1e-9)[..., None]
            if self.kind == "cylinder":
                distance, outward = rho - self.size[:, None], radial
            else:
                c, s = np.cos(self.size)[:, None], np.sin(self.size)[:, None]
                distance = rho * c - along * s
                outward = c[..., None] * radial - s[..., None] * self.axis[:, None]
        cosine = self.sign[:, None] * np.einsum(
            "gnj,gnj->gn", outward, np.broadcast_to(normals, outward.shape)
        )
        return np.asarray((distance * weight) ** 2 + turned(cosine, turn_weight, felt))


def proposals(points: Floats, normals: Floats, sigma: float, normal_sigma: float) -> Iterator[Proposals]:
    """All kinds through (g, k, 3) groups of points with their normals."""
    middle, mean = points.mean(axis=1), normals.mean(axis=1)
    p, n = points - middle[:, None], normals - mean[:, None]
    spread = np.einsum("gki,gkj->gij", normals, normals)
    scatter = np.einsum("gki,gkj->gij", p, p) / sigma**2 - spread / normal_sigma**2
    normal = np.linalg.eigh(scatter)[1][:, :, 0]
    normal = normal * np.where((normal * mean).sum(axis=1) < 0, -1.0, 1.0)[:, None]
    ones = np.ones(len(points))
    yield Proposals("plane", middle, normal, ones, ones, np.arange(len(points)))
    yield _round("sphere", p, n, middle, mean, np.tile([0.0, 0.0, 1.0], (len(points), 1)))
    axis = np.linalg.eigh(spread)[1][:, :, 0]
    across, turned = _across(p, axis), _across(n, axis)
    yield _round("cylinder", across, turned, middle, _across(mean[:, None], axis)[:, 0], axis)
    if points.shape[1] >= 3:
        yield _cones(p, normals, n, middle)


def _across(vectors: Floats, axis: Floats) -> Floats:
    return np.asarray(vectors - np.einsum("gkj,gj->gk", vectors, axis)[..., None] * axis[:, None])


def _round(kind: str, p: Floats, n: Floats, middle: Floats, mean: Floats, axis: Floats) -> Proposals:
    below = (n * n).sum(axis=(1, 2))
    radius = (p * n).sum(axis=(1, 2)) / np.maximum(below, 1e-9)
    made = Proposals(
        kind, middle - radius[:, None] * mean, axis, np.abs(radius), np.sign(radius), np.arange(len(p))
    )
    return made.select((below > 1e-6) & (np.abs(radius) > 1e-6))


def _cones(p: Floats, normals: Floats, n: Floats, middle: Floats) -> Proposals:
    gram = np.einsum("gki,gkj->gij", normals, normals)
    gram += 1e-9 * np.trace(gram, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    right = np.einsum("gki,gk->gi", normals, (p * normals).sum(axis=2))
    apex = np.linalg.solve(gram, right[..., None])[..., 0]
    axis = np.linalg.eigh(np.einsum("gki,gkj->gij", n, n))[1][:, :, 0]
    arms = p - apex[:, None]
    axis = axis * np.where((axis * arms.mean(axis=1)).sum(axis=1) < 0, -1.0, 1.0)[:, None]
    along = np.einsum("gkj,gj->gk", arms, axis)
    rho = np.sqrt(np.maximum((arms**2).sum(axis=2) - along**2, 0.0))
    angle = np.median(np.arctan2(rho, along), axis=1)
    lean = np.einsum("gkj,gj->gk", normals, axis).mean(axis=1)  # -sin(angle) where the material is inside
    made = Proposals("cone", middle + apex, axis, angle, np.where(lean <= 0, 1.0, -1.0), np.arange(len(p)))
    return made.select((angle > _LEAST_ANGLE) & (angle < _LARGEST_ANGLE))
