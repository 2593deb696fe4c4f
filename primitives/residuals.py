"""How badly a shape explains contacts, whitened, and the derivatives by its local step.

A point leaves its signed distance / sigma.  A felt normal m leaves the angle from the shape's normal n, split
along the tangents T and f of `revolution`: (m . T, m . f) angle / sin(angle) / normal_sigma, which unlike the
bare components does not vanish where m = -n.  With q the point in the shape's frame, a translation t and a
turn w of the shape move it by dq = -t - w x q there, so (our derivation)::

    d distance = n . dq + size terms
    T . dn = T . (w x n) + bend T . dq + size turns,    f . dn = f . (w x n) + around f . dq.

The cone's apex may lie far from its contacts, where a step of it is ill-conditioned: `Chart` gives each shape
coordinates that belong to the contacts, and the matrix that leads back to `retract`'s.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from primitives.arrays import Bools, Floats, Ints
from primitives.cone import Cone
from primitives.evidence import Contacts
from primitives.revolution import TINY, Revolution
from primitives.shapes import Shape

_LEAST_ANGLE = 1e-4  # [rad] a cone closer than this to a cylinder is held here
_LARGEST_ANGLE = np.pi / 2 - 1e-3  # [rad] and one this close to a plane here


@dataclass(frozen=True)
class Problem:
    """Contacts made ready for least squares."""

    points: Floats  # (n, 3) [mm]
    weight: Floats  # (n,) 1 / sigma
    felt: Ints  # (k,) rows that carry a normal
    normals: Floats  # (k, 3)
    normal_weight: Floats  # (k,) 1 / normal_sigma
    center: Floats  # (3,) mean of the points [mm]

    @staticmethod
    def of(contacts: Contacts, rows: Bools | None = None) -> Problem:
        """The problem of all contacts, or of the rows of a mask."""
        table = contacts if rows is None else contacts.select(rows)
        felt = np.flatnonzero(table.has_normal)
        points = table.points
        return Problem(
            points,
            1.0 / table.sigma,
            felt,
            table.normals[felt],
            1.0 / table.normal_sigma[felt],
            np.asarray(points.sum(axis=0) / max(len(points), 1)),
        )

    @property
    def count(self) -> int:
        """Number of residuals."""
        return len(self.points) + 2 * len(self.felt)

    def squares(self, residuals: Floats) -> Floats:
        """(n,) sum of each contact's squared residuals."""
        n, k = len(self.points), len(self.felt)
        squared = residuals**2
        total = squared[:n].copy()
        total[self.felt] += squared[n : n + k] + squared[n + k :]
        return total

    def spread(self, values: Floats) -> Floats:
        """Values of contacts (n,) repeated for each of their residuals."""
        return np.concatenate([values, values[self.felt], values[self.felt]])


def linearize(shape: Shape, problem: Problem, sign: float) -> tuple[Floats, Floats]:
    """Residuals (n + 2k,) and Jacobian (n + 2k, dof); `sign` is -1 where the face is concave."""
    q, radial, field = shape.profile_at(problem.points)
    c, s = field.radial, field.axial
    gradient = np.stack([c * radial[:, 0], c * radial[:, 1], s], axis=1)
    n, k, dof = len(q), len(problem.felt), shape.dof
    residuals, jacobian = np.empty(n + 2 * k), np.empty((n + 2 * k, dof))
    _moved(shape, gradient, q, jacobian[:n])
    jacobian[:n, dof - field.size_distance.shape[1] :] = field.size_distance
    jacobian[:n] *= problem.weight[:, None]
    residuals[:n] = field.distance * problem.weight
    if k:
        rows = problem.felt
        g, at, e, c, s = gradient[rows], q[rows], radial[rows], c[rows], s[rows]
        along = np.stack([-s * e[:, 0], -s * e[:, 1], c], axis=1)
        round_ = np.stack([-e[:, 1], e[:, 0], np.zeros(k)], axis=1)
        felt = (sign * problem.normals) @ shape.frame
        a, b = (felt * along).sum(axis=1), (felt * round_).sum(axis=1)
        sine = np.sqrt(a * a + b * b)
        scale = problem.normal_weight * np.where(
            sine > 1e-9, np.arctan2(sine, (felt * g).sum(axis=1)) / np.maximum(sine, 1e-9), 1.0
        )
        residuals[n : n + k], residuals[n + k :] = a * scale, b * scale
        for slot, tangent, bend in ((n, along, field.bend[rows]), (n + k, round_, field.around[rows])):
            block = jacobian[slot : slot + k]
            _moved(shape, tangent, at * bend[:, None] - g, block, bend)
            block *= -problem.normal_weight[:, None]
        sizes = field.size_turn.shape[1]
        if sizes:
            jacobian[n : n + k, dof - sizes :] = -field.size_turn[rows] * problem.normal_weight[:, None]
    return residuals, jacobian


def _moved(shape: Shape, v: Floats, q: Floats, out: Floats, bend: Floats | float = 1.0) -> None:
    """Fill `out` with v . dq of each translation (scaled by `bend`) and tilt, and zeros for the sizes."""
    count = len(shape.translations)
    for column, axis in enumerate(shape.translations):
        out[:, column] = -bend * v[:, axis]
    if shape.tilts:
        out[:, count] = v[:, 2] * q[:, 0] - v[:, 0] * q[:, 2]
        out[:, count + 1] = v[:, 2] * q[:, 1] - v[:, 1] * q[:, 2]
    out[:, count + shape.tilts :] = 0.0


def chart(shape: Shape, center: Floats) -> Floats:
    """(dof, dof) matrix from chart coordinates to `retract`'s.

    They agree but for the cone, whose chart is (axis sideways at the contacts' height h, tilts about the
    axis there, radius there, semi-angle): with L = radius / tan(angle) the apex moves by -h tilt and -dL.
    """
    if not isinstance(shape, Cone):
        return np.eye(shape.dof)
    height, tangent = _height(shape, center), np.tan(shape.semi_angle)
    matrix = np.zeros((6, 6))  # rows x, y, z, tilt, tilt, angle; columns x, y, tilt, tilt, radius, angle
    matrix[[0, 1, 3, 4, 5], [0, 1, 2, 3, 5]] = 1.0
    matrix[0, 2] = matrix[1, 3] = -height
    matrix[2, 4] = -1.0 / tangent
    matrix[2, 5] = height * tangent / np.sin(shape.semi_angle) ** 2
    return matrix


def advance(shape: Shape, center: Floats, step: Floats) -> Shape | None:
    """The shape after a step in chart coordinates; None where it would cease to be one."""
    if isinstance(shape, Cone):
        return _advance_cone(shape, center, step)
    first = shape.dof - len(shape.sizes)
    if any(old + new <= 1e-3 * old for old, new in zip(shape.sizes, step[first:], strict=True)):
        return None
    return Revolution.retract(shape, step)


def _height(shape: Cone, center: Floats) -> float:
    return max(
        float((center - shape.apex) @ shape.axis), 1e-3 * float(np.linalg.norm(center - shape.apex)), TINY
    )


def _advance_cone(shape: Cone, center: Floats, step: Floats) -> Cone | None:
    height = _height(shape, center)
    radius, angle = height * np.tan(shape.semi_angle) + step[4], shape.semi_angle + step[5]
    if radius <= 0 or abs(angle) >= _LARGEST_ANGLE:
        return None
    if abs(angle) < _LEAST_ANGLE:  # through the cylinder to the cone that opens the other way
        angle = np.copysign(_LEAST_ANGLE, angle)
    tilt = step[2:4]
    turn = float(np.hypot(tilt[0], tilt[1]))
    axis = np.cos(turn) * shape.axis + np.sinc(turn / np.pi) * (shape.frame[:, :2] @ tilt)
    pivot = shape.apex + height * shape.axis + shape.frame[:, :2] @ step[:2]
    return Cone(pivot - radius / np.tan(angle) * axis, np.copysign(1.0, angle) * axis, abs(float(angle)))
