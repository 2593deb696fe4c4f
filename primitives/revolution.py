"""What the five shapes share: each is the surface that a line or an arc sweeps round an axis.

In the frame (t1, t2, axis) at the shape's anchor, with rho = hypot(x, y), the signed distance of a point is
that of (rho, z) to the profile.  A planar distance field has a unit gradient (c, s) and bends only across it,
so with e the radial and f the tangential direction (our derivation)::

    n = c e + s axis,    T = -s e + c axis,    Hessian = bend T T' + (c / rho) f f'.

`bend` and `around` = c / rho are at once the principal curvatures, and the derivatives that a fit needs.

A local step is (translations [mm] along chosen frame axes, tilts [rad] of the axis toward t1 and t2, changes
of the sizes); `retract` applies it, `local` finds it.  Tilts turn the axis about the anchor.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import ClassVar, NamedTuple, Self

import numpy as np

from primitives.arrays import Floats, frozen
from primitives.errors import PalpateError
from primitives.surface import RayHits

TINY = 1e-12  # [mm] distances below this are on the axis


class Profile(NamedTuple):
    """The planar distance field at n points (rho, z), and how it changes with the shape's k sizes."""

    distance: Floats  # (n,) [mm]
    radial: Floats  # (n,) c, the radial part of the unit gradient
    axial: Floats  # (n,) s, the axial part
    bend: Floats  # (n,) [1/mm] curvature of the level curve through the point
    around: Floats  # (n,) [1/mm] c / rho, the curvature round the axis
    size_distance: Floats  # (n, k) derivative of `distance` by each size
    size_turn: Floats  # (n, k) [rad per unit] turn of the gradient toward T by each size


class Revolution(ABC):
    """A surface of revolution, with everything that follows from its profile."""

    kind: ClassVar[str]
    dof: ClassVar[int]
    translations: ClassVar[tuple[int, ...]]  # frame axes along which `retract` moves the anchor
    tilts: ClassVar[int]  # 2 where the axis matters, 0 for the sphere

    @property
    @abstractmethod
    def anchor(self) -> Floats:
        """(3,) origin of the shape's frame [mm]."""

    @property
    @abstractmethod
    def direction(self) -> Floats:
        """(3,) unit axis of revolution."""

    @property
    @abstractmethod
    def sizes(self) -> tuple[float, ...]:
        """Radii [mm] and angles [rad], in the order in which `retract` changes them."""

    @abstractmethod
    def with_parts(self, anchor: Floats, direction: Floats, sizes: tuple[float, ...]) -> Self:
        """A shape of the same kind from its parts."""

    @abstractmethod
    def profile(self, rho: Floats, z: Floats) -> Profile:
        """The planar distance field at (n,) rho >= 0 and z."""

    @abstractmethod
    def roots(self, origins: Floats, directions: Floats) -> Floats:
        """(n, m) ray parameters where rays in the shape's own frame meet the surface; inf for none."""

    @abstractmethod
    def area(self, extent: tuple[float, float] | None = None) -> float:
        """Area [mm^2] of a patch of the given extent (see each shape), or of the whole; inf if unbounded."""

    @cached_property
    def frame(self) -> Floats:
        """(3, 3) rotation with columns t1, t2, axis."""
        return frozen(_basis(*self.direction.tolist()))

    def profile_at(self, points: Floats) -> tuple[Floats, Floats, Profile]:
        """Points in the shape's frame (n, 3), their unit radial directions (n, 2), and the profile."""
        local: Floats = (points - self.anchor) @ self.frame
        rho = np.sqrt(local[:, 0] ** 2 + local[:, 1] ** 2)
        if rho.size and rho.min() <= TINY:
            radial = np.where(
                rho[:, None] > TINY, local[:, :2] / np.maximum(rho, TINY)[:, None], np.array([1.0, 0.0])
            )
        else:
            radial = local[:, :2] / rho[:, None]
        return local, radial, self.profile(rho, local[:, 2])

    def signed_distance(self, points: Floats) -> Floats:
        """Distance of (n, 3) points [mm] to the surface, negative inside the solid: (n,) [mm]."""
        return self.profile_at(points)[2].distance

    def normals(self, points: Floats) -> Floats:
        """Outward unit normals at the surface points nearest to (n, 3) points: (n, 3)."""
        _, radial, field = self.profile_at(points)
        local = np.concatenate([radial * field.radial[:, None], field.axial[:, None]], axis=1)
        normals: Floats = local @ self.frame.T
        return normals

    def project(self, points: Floats) -> Floats:
        """The surface points nearest to (n, 3) points: (n, 3) [mm]."""
        return points - self.signed_distance(points)[:, None] * self.normals(points)

    def principal_curvatures(self, points: Floats) -> Floats:
        """(n, 2) curvatures k1 >= k2 [1/mm] at the nearest surface points; a convex solid's are positive."""
        field = self.profile_at(self.project(points))[2]
        pair = np.stack([field.bend, field.around], axis=1)
        return np.sort(pair, axis=1)[:, ::-1]

    def cast_rays(self, origins: Floats, directions: Floats) -> RayHits:
        """First hits, at t >= 0, of (n, 3) origins [mm] along (n, 3) unit directions."""
        start = (origins - self.anchor) @ self.frame
        along = directions @ self.frame
        shift = -np.einsum(
            "ij,ij->i", start, along
        )  # solve from the point nearest the anchor: far rays stay exact
        t = self.roots(start + shift[:, None] * along, along) + shift[:, None]
        first = np.where(t >= 0, t, np.inf).min(axis=1, initial=np.inf)
        hit = np.isfinite(first)
        reached = np.where(
            hit[:, None], origins + np.where(hit, first, 0.0)[:, None] * directions, self.anchor
        )
        normals = np.where(hit[:, None], self.normals(reached), 0.0)
        return RayHits(first, normals, np.where(hit, 0, -1).astype(np.int64))

    def transformed(self, a_from_b: Floats) -> Self:
        """The shape moved by a pose."""
        rotation, shift = a_from_b[:3, :3], a_from_b[:3, 3]
        return self.with_parts(rotation @ self.anchor + shift, rotation @ self.direction, self.sizes)

    def retract(self, step: Floats) -> Self:
        """The shape after a (dof,) local step, whose parameters the class's docstring orders."""
        count = len(self.translations)
        frame = self.frame
        anchor = self.anchor + frame[:, list(self.translations)] @ step[:count]
        axis = self.direction
        if self.tilts:
            tilt = step[count : count + 2]
            angle = float(np.hypot(tilt[0], tilt[1]))
            axis = np.cos(angle) * axis + np.sinc(angle / np.pi) * (frame[:, :2] @ tilt)
        changed = tuple(float(a + b) for a, b in zip(self.sizes, step[count + self.tilts :], strict=True))
        return self.with_parts(anchor, axis, changed)

    def local(self, other: Self, frame: Floats | None = None) -> Floats:
        """The (dof,) step that takes this shape to `other`, nearly enough alike that their axes agree.

        It is told in another (3, 3) `frame` near its own where it is told of nudged shapes, too: their own turn by
        a half where the axis crosses the horizontal.
        """
        frame = self.frame if frame is None else frame
        axis = self._aligned(other.direction)
        tilt: list[float] = []
        if self.tilts:
            side = frame[:, :2].T @ (axis - (axis @ self.direction) * self.direction)
            sine = float(np.hypot(*side))
            angle = np.arctan2(sine, float(self.direction @ axis))
            tilt = list(side * (angle / sine if sine > TINY else 1.0))
        move = self._anchor_step(other.anchor, axis, frame)
        grown = np.subtract(other.sizes, self.sizes)
        return np.concatenate([move, tilt, grown])

    def _aligned(self, axis: Floats) -> Floats:
        """`axis`, or its opposite where both mean the same shape and the opposite is nearer."""
        return axis

    def _anchor_step(self, anchor: Floats, axis: Floats, frame: Floats) -> Floats:
        moved: Floats = frame[:, list(self.translations)].T @ (anchor - self.anchor)
        return moved


def _basis(x: float, y: float, z: float) -> list[list[float]]:
    """Rows of a rotation whose last column is (x, y, z) (Duff et al., JCGT 6(1), 2017)."""
    sign = 1.0 if z >= 0 else -1.0
    a = -1.0 / (sign + z)
    b = x * y * a
    return [[1.0 + sign * x * x * a, b, x], [sign * b, sign + y * y * a, y], [-sign * x, -y, z]]


def point(value: object, name: str) -> Floats:
    """A read-only finite (3,) point."""
    array = frozen(np.asarray(value, dtype=float))
    if array.shape != (3,) or not np.isfinite(array).all():
        raise PalpateError(f"{name} must be three finite numbers in mm, not {value}")
    return array


def unit(value: object, name: str) -> Floats:
    """A read-only (3,) direction of length one."""
    array = np.asarray(value, dtype=float)
    length = float(np.sqrt((array**2).sum()))
    if array.shape != (3,) or not np.isfinite(length) or length < TINY:
        raise PalpateError(f"{name} must be three finite numbers, not all zero, not {value}")
    array = array / length
    array.flags.writeable = False
    return array


def size(value: float, name: str, below: float = np.inf) -> float:
    """A finite number between 0 and `below`, both left out."""
    if not 0.0 < value < below:
        bound = "a positive finite number" if np.isinf(below) else f"between 0 and {below:.6g}"
        raise PalpateError(f"{name} must be {bound}, not {value}")
    return float(value)
