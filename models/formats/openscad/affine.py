"""OpenSCAD's transformations as (4, 4) matrices, and what of one is a rigid motion.

A linear part L with orthogonal columns is Q diag(d): Q a rotation, d the columns' lengths, one of them negative
where L mirrors.  OpenSCAD writes six digits, so Q is taken to be the rotation nearest to them (Higham 1986), and
the length of a slanting column the one of five digits that they come from.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from models.formats.openscad.functions import cosine, sine
from models.formats.openscad.shapes import Shape
from models.formats.openscad.values import Value, is_number
from primitives.arrays import Floats
from primitives.pose import hat, pose

SIX_DIGITS = (
    4e-6  # [1] how far from orthogonal columns of unit length may be that were written with six digits
)
_EXACT_DIGITS = 12  # of a length that was computed


class Split(NamedTuple):
    """`rigid` after a stretch along x, y and z."""

    rigid: Floats  # (4, 4)
    stretch: Floats  # (3,) at most one is negative


def split(matrix: Floats) -> Split | None:
    """A (4, 4) matrix taken apart; None where it shears."""
    stretch = _rounded(np.linalg.norm(matrix[:3, :3], axis=0), _EXACT_DIGITS)
    turn = matrix[:3, :3] / stretch
    if np.abs(turn.T @ turn - np.eye(3)).max() > SIX_DIGITS:
        return None
    if np.linalg.det(turn) < 0:
        axis = int(np.argmin(np.diag(turn)))
        turn[:, axis] *= -1
        stretch[axis] *= -1
    if np.abs(turn.T @ turn - np.eye(3)).max() > 1e-10:
        u, _, v = np.linalg.svd(turn)
        turn = u @ v
    return Split(pose(turn, matrix[:3, 3]), stretch)


def matrix_of(shape: Shape) -> Floats:
    """The (4, 4) matrix of `multmatrix`, `translate`, `rotate`, `scale` or `mirror`."""
    made = _MATRICES[shape.name](shape)
    if not np.isfinite(made).all():
        raise shape.error(f"{shape.name} needs finite numbers; check them")
    if abs(np.linalg.det(made[:3, :3])) < 1e-12:
        raise shape.error(f"{shape.name} flattens what it holds; give factors other than zero")
    return made


def vector(shape: Shape, value: Value, fill: float, what: str) -> Floats:
    """(3,) numbers; two are filled up, and a single one stands for all three where `fill` is 1."""
    if is_number(value) and fill == 1.0:
        value = (value,) * 3
    if not isinstance(value, tuple) or not 1 <= len(value) <= 3 or not all(map(is_number, value)):
        raise shape.error(f"{shape.name} needs {what}; write it as [x, y, z]")
    if not np.isfinite(value).all():
        raise shape.error(f"{shape.name} needs finite numbers; check them")
    return np.array([*value, *[fill] * (3 - len(value))])


def _multmatrix(shape: Shape) -> Floats:
    rows = shape.arguments.get("m")
    out = np.eye(4)
    if not isinstance(rows, tuple) or not 3 <= len(rows) <= 4:
        raise shape.error("multmatrix needs a matrix of four rows of four numbers")
    for i, row in enumerate(rows):
        if not isinstance(row, tuple) or len(row) > 4 or not all(map(is_number, row)):
            raise shape.error("multmatrix needs a matrix of four rows of four numbers")
        out[i, : len(row)] = row
    if not np.array_equal(out[3], [0, 0, 0, 1]):
        raise shape.error("multmatrix's last row must be [0, 0, 0, 1]")
    if np.array_equal(out[:3, :3], _rounded(out[:3, :3], 6)):
        out[:3, :3] = _as_meant(out[:3, :3])
    return out


def _as_meant(linear: Floats) -> Floats:
    """A matrix of six digits with the lengths that its slanting columns were rounded from."""
    length = np.linalg.norm(linear, axis=0)
    near = _rounded(length, 5)
    meant = (np.count_nonzero(linear, axis=0) > 1) & (np.abs(length - near) <= SIX_DIGITS * near)
    scaled: Floats = linear * np.divide(near, length, out=np.ones(3), where=meant)
    return scaled


def _rounded(values: Floats, digits: int) -> Floats:
    short: Floats = np.array([float(f"{v:.{digits}g}") for v in values.flat]).reshape(values.shape)
    return short


def _translate(shape: Shape) -> Floats:
    return pose(None, vector(shape, shape.arguments.get("v"), 0.0, "a shift"))


def _rotate(shape: Shape) -> Floats:
    angle, axis = shape.arguments.get("a"), shape.arguments.get("v")
    if isinstance(angle, tuple):
        x, y, z = vector(shape, angle, 0.0, "an angle or three, in degrees")
        return pose(_turn("z", z) @ _turn("y", y) @ _turn("x", x))
    if not is_number(angle):
        raise shape.error("rotate needs an angle or three, in degrees")
    if axis is None:
        return pose(_turn("z", angle))
    along = vector(shape, axis, 0.0, "an axis")
    length = float(np.linalg.norm(along))
    if not length > 0:
        return np.eye(4)
    k = hat(along / length)
    return pose(np.eye(3) + sine(angle) * k + (1 - cosine(angle)) * (k @ k))


def _scale(shape: Shape) -> Floats:
    return np.diag([*vector(shape, shape.arguments.get("v"), 1.0, "a factor or three"), 1.0])


def _mirror(shape: Shape) -> Floats:
    normal = vector(shape, shape.arguments.get("v"), 0.0, "a direction")
    length = float(normal @ normal)
    out = np.eye(4)
    if length > 0:
        out[:3, :3] -= 2 * np.outer(normal, normal) / length
    return out


def _turn(axis: str, degrees: float) -> Floats:
    c, s = cosine(degrees), sine(degrees)
    rows = {
        "x": [[1, 0, 0], [0, c, -s], [0, s, c]],
        "y": [[c, 0, s], [0, 1, 0], [-s, 0, c]],
        "z": [[c, -s, 0], [s, c, 0], [0, 0, 1]],
    }
    return np.array(rows[axis], dtype=float)


_MATRICES = {
    "multmatrix": _multmatrix,
    "translate": _translate,
    "rotate": _rotate,
    "scale": _scale,
    "mirror": _mirror,
}
TRANSFORMS = frozenset(_MATRICES)
