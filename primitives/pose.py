"""Rigid motions as (..., 4, 4) float64 arrays, in mm and rad.

Names cancel: ``world_from_taxel = world_from_sensor @ sensor_from_taxel``.  A twist is (v, w), linear part
first; `exp` and `log` are the closed forms of SE(3) (Murray, Li and Sastry 1994, section 2.3) with series
where the angle is small.
"""

import math

import numba
import numpy as np
from numpy.typing import ArrayLike

from primitives.arrays import Floats

_SMALL_ANGLE = 1e-6  # [rad] below this the series is exact to double precision


def pose(rotation: ArrayLike | None = None, translation: ArrayLike | None = None) -> Floats:
    """A pose from a (..., 3, 3) rotation and a (..., 3) translation [mm]; each is the identity if absent."""
    r = np.eye(3) if rotation is None else np.asarray(rotation, dtype=float)
    t = np.zeros(3) if translation is None else np.asarray(translation, dtype=float)
    shape = () if r.ndim == 2 and t.ndim == 1 else np.broadcast_shapes(r.shape[:-2], t.shape[:-1])
    out = np.zeros((*shape, 4, 4))
    out[..., :3, :3] = r
    out[..., :3, 3] = t
    out[..., 3, 3] = 1.0
    return out


def inverse(a_from_b: Floats) -> Floats:
    """b_from_a."""
    r = np.swapaxes(a_from_b[..., :3, :3], -1, -2)
    return pose(r, -(r @ a_from_b[..., :3, 3, None])[..., 0])


def transform_points(a_from_b: Floats, points_b: Floats) -> Floats:
    """(..., n, 3) points of frame b in frame a."""
    moved: Floats = points_b @ np.swapaxes(a_from_b[..., :3, :3], -1, -2) + a_from_b[..., None, :3, 3]
    return moved


def rotate(a_from_b: Floats, vectors_b: Floats) -> Floats:
    """(..., n, 3) directions of frame b in frame a."""
    turned: Floats = vectors_b @ np.swapaxes(a_from_b[..., :3, :3], -1, -2)
    return turned


def hat(w: Floats) -> Floats:
    """The (..., 3, 3) skew matrix with hat(w) @ x == cross(w, x)."""
    out = np.zeros((*w.shape[:-1], 3, 3))
    out[..., 0, 1], out[..., 0, 2], out[..., 1, 2] = -w[..., 2], w[..., 1], -w[..., 0]
    out[..., 1, 0], out[..., 2, 0], out[..., 2, 1] = w[..., 2], -w[..., 1], w[..., 0]
    return out


def cross(a: Floats, b: Floats) -> Floats:
    """The product a x b of two (3,) vectors, for loops that take one at a time."""
    out: Floats = _cross(np.array(a), np.array(b))  # one layout, for which the kernel is compiled
    return out


@numba.njit(cache=True, error_model="numpy")
def _cross(a: Floats, b: Floats) -> Floats:
    out = np.empty(3)
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        out[i] = a[j] * b[k] - a[k] * b[j]
    return out


def rotation_exp(w: ArrayLike) -> Floats:
    """Rodrigues: the (..., 3, 3) rotation about w by |w| rad."""
    v = np.asarray(w, dtype=float)
    angle = np.linalg.norm(v, axis=-1)[..., None, None]
    k = hat(v)
    small = angle < _SMALL_ANGLE
    safe = np.where(small, 1.0, angle)
    a = np.where(small, 1.0 - angle**2 / 6.0, np.sin(safe) / safe)
    b = np.where(small, 0.5 - angle**2 / 24.0, (1.0 - np.cos(safe)) / safe**2)
    out: Floats = np.eye(3) + a * k + b * (k @ k)
    return out


def rotation_log(rotation: Floats) -> Floats:
    """The (..., 3) rotation vector, of length in [0, pi]."""
    q = quaternion_wxyz(rotation)
    vector = q[..., 1:]
    sine = np.linalg.norm(vector, axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, q[..., :1])
    scale = np.where(sine < _SMALL_ANGLE, 2.0, angle / np.where(sine < _SMALL_ANGLE, 1.0, sine))
    out: Floats = scale * vector
    return out


def turn_between(a: Floats, b: Floats) -> float:
    """[rad] from one pose's attitude to another's: `rotation_log`'s length, for loops that ask often."""
    r = (a[:3, :3].T @ b[:3, :3]).tolist()
    across = math.hypot(r[2][1] - r[1][2], r[0][2] - r[2][0], r[1][0] - r[0][1])
    return math.atan2(across, r[0][0] + r[1][1] + r[2][2] - 1.0)


def exp(twist: ArrayLike) -> Floats:
    """The pose reached by following a (..., 6) twist (v [mm], w [rad]) for unit time."""
    x = np.asarray(twist, dtype=float)
    if x.ndim == 1:
        one: Floats = _exp_one(x)
        return one
    v, w = x[..., :3], x[..., 3:]
    return pose(rotation_exp(w), (_left_jacobian(w) @ v[..., None])[..., 0])


@numba.njit(cache=True, error_model="numpy")
def _exp_one(x: Floats) -> Floats:
    """`exp` of one (6,) twist, for loops that take one at every tick."""
    angle = np.sqrt(x[3] * x[3] + x[4] * x[4] + x[5] * x[5])
    square = angle * angle
    if angle < 1e-4:
        a, b, c = 1.0 - square / 6.0, 0.5 - square / 24.0, 1.0 / 6.0 - square / 120.0
    else:
        half = np.sin(0.5 * angle)
        a, b = np.sin(angle) / angle, 2.0 * half * half / square
        c = (1.0 - a) / square
    k = np.array([[0.0, -x[5], x[4]], [x[5], 0.0, -x[3]], [-x[4], x[3], 0.0]])
    out = np.eye(4)
    for i in range(3):
        for j in range(3):
            kk = k[i, 0] * k[0, j] + k[i, 1] * k[1, j] + k[i, 2] * k[2, j]
            out[i, j] += a * k[i, j] + b * kk
            out[i, 3] += (b * k[i, j] + c * kk + (1.0 if i == j else 0.0)) * x[j]
    return out


def log(a_from_b: Floats) -> Floats:
    """The (..., 6) twist whose `exp` is the pose."""
    w = rotation_log(a_from_b[..., :3, :3])
    v = np.linalg.solve(_left_jacobian(w), a_from_b[..., :3, 3, None])[..., 0]
    return np.concatenate([v, w], axis=-1)


def _left_jacobian(w: Floats) -> Floats:
    angle = np.linalg.norm(w, axis=-1)[..., None, None]
    k = hat(w)
    small = angle < 1e-4
    safe = np.where(small, 1.0, angle)
    a = np.where(small, 0.5 - angle**2 / 24.0, (1.0 - np.cos(safe)) / safe**2)
    b = np.where(small, 1.0 / 6.0 - angle**2 / 120.0, (safe - np.sin(safe)) / safe**3)
    out: Floats = np.eye(3) + a * k + b * (k @ k)
    return out


def frame_along(normal: ArrayLike, x_hint: ArrayLike | None = None) -> Floats:
    """A (3, 3) rotation whose z column is `normal` and whose x column is nearest to `x_hint`."""
    hint = np.zeros(3) if x_hint is None else np.array(x_hint, dtype=float)
    out: Floats = _frame(np.array(normal, dtype=float), hint)
    return out


@numba.njit(cache=True, error_model="numpy")
def _frame(z: Floats, hint: Floats) -> Floats:
    """`frame_along` of (3,) vectors; the axis least along `z` stands in for a hint that says nothing."""
    out = np.empty((3, 3))
    z = z / np.sqrt((z * z).sum())
    x = hint - (hint @ z) * z
    if (x * x).sum() <= 1e-18 * max(1.0, (hint * hint).sum()):
        x = np.zeros(3)
        x[np.argmin(np.abs(z))] = 1.0
        x = x - (x @ z) * z
    x /= np.sqrt((x * x).sum())
    out[:, 0], out[:, 1], out[:, 2] = x, _cross(z, x), z
    return out


def quaternion_wxyz(rotation: Floats) -> Floats:
    """(..., 4) unit quaternions with w >= 0 of (..., 3, 3) rotations or (..., 4, 4) poses."""
    r = np.array(
        rotation[..., :3, :3], dtype=float, order="C"
    )  # one layout, for which the kernel is compiled
    out: Floats = _quaternions(r.reshape(-1, 3, 3)).reshape(*r.shape[:-2], 4)
    return out


@numba.njit(cache=True, error_model="numpy")
def _quaternions(rotations: Floats) -> Floats:
    """(n, 4) of (n, 3, 3): 4 q_k q from whichever component q_k is largest (Shepperd 1978), normalized."""
    out = np.empty((len(rotations), 4))
    for n in range(len(rotations)):
        r, q = rotations[n], out[n]
        trace = r[0, 0] + r[1, 1] + r[2, 2]
        k = -1
        largest = trace
        for i in range(3):
            if r[i, i] > largest:
                k, largest = i, r[i, i]
        for i in range(3):
            i1, i2 = (i + 1) % 3, (i + 2) % 3
            q[1 + i] = r[i2, i1] - r[i1, i2] if k < 0 else r[k, i] + r[i, k]
        if k < 0:
            q[0] = 1.0 + trace
        else:
            k1, k2 = (k + 1) % 3, (k + 2) % 3
            q[0], q[1 + k] = r[k2, k1] - r[k1, k2], 1.0 + 2.0 * r[k, k] - trace
        length = np.sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3])
        if q[0] < 0.0:
            length = -length
        for i in range(4):
            q[i] /= length
    return out


def from_quaternion(wxyz: ArrayLike, translation: ArrayLike | None = None) -> Floats:
    """The pose of a (..., 4) quaternion, normalized first, and a (..., 3) translation [mm]."""
    q = np.array(wxyz, dtype=float, order="C")
    return pose(_rotations(q.reshape(-1, 4)).reshape(*q.shape[:-1], 3, 3), translation)


@numba.njit(cache=True, error_model="numpy")
def _rotations(quaternions: Floats) -> Floats:
    """(n, 3, 3) of (n, 4), normalized here: one recorded pose after another is read with it."""
    out = np.empty((len(quaternions), 3, 3))
    for n in range(len(quaternions)):
        w, x, y, z = quaternions[n] / np.sqrt((quaternions[n] ** 2).sum())
        out[n, 0] = 1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)
        out[n, 1] = 2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)
        out[n, 2] = 2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)
    return out


def random_rotation(rng: np.random.Generator) -> Floats:
    """A (3, 3) rotation, uniform over SO(3)."""
    return from_quaternion(rng.standard_normal(4))[:3, :3]


@numba.njit(cache=True, error_model="numpy")
def apart(a_from_b: Floats, a_from_c: Floats) -> float:
    """[mm] between the origins of two (4, 4) poses."""
    total = 0.0
    for i in range(3):
        total += (a_from_b[i, 3] - a_from_c[i, 3]) ** 2
    return float(np.sqrt(total))


def turn_about(point: ArrayLike, axis: ArrayLike, angle: float) -> Floats:
    """The pose that turns the world by `angle` [rad] about a line through `point` [mm] along unit `axis`."""
    p = np.asarray(point, dtype=float)
    r = rotation_exp(np.asarray(axis, dtype=float) * angle)
    return pose(r, p - r @ p)
