"""The kernels of a chain of axes: its pose and Jacobian, and the damped least squares back.

They run with every report and every jog, in the thread that watches over the stage.
"""

import numpy as np
from numba import njit

from primitives.arrays import Bools, Floats

_CLOSE, _CLOSE_TURN = 1e-4, 1e-6  # [mm], [rad] where the search for joint positions ends
_MOST_TURN = 0.5  # [rad] of one axis in one step


@njit(cache=True, nogil=True, error_model="numpy")
def walk(q: Floats, offsets: Floats, ways: Floats, turns: Bools, tool: Floats) -> tuple[Floats, Floats]:
    """(4, 4) base_from_flange and its (6, n) Jacobian at joint positions (n,), as v and w in the base's frame."""
    count = len(q)
    at = np.eye(4)
    lines, centers = np.zeros((count, 3)), np.zeros((count, 3))
    for i in range(count):
        turn = np.ascontiguousarray(at[:3, :3])
        at[:3, 3] += turn @ offsets[i]
        line = turn @ ways[i]
        lines[i], centers[i] = line, at[:3, 3]
        if turns[i]:
            at[:3, :3] = _rotation(line, q[i]) @ turn
        else:
            at[:3, 3] += q[i] * line
    at = at @ tool
    jacobian = np.zeros((6, count))
    for i in range(count):
        if turns[i]:
            jacobian[:3, i] = np.cross(lines[i], at[:3, 3] - centers[i])
            jacobian[3:, i] = lines[i]
        else:
            jacobian[:3, i] = lines[i]
    return at, jacobian


@njit(cache=True, nogil=True, error_model="numpy")
def reach(
    goal: Floats,
    near: Floats,
    offsets: Floats,
    ways: Floats,
    turns: Bools,
    tool: Floats,
    limits: Floats,
    arm: float,
    damping: float,
    steps: int,
) -> tuple[Floats, float, float]:
    """Joint positions near `near` for a (4, 4) pose, and what they leave of it [mm], [rad]; limits (2, n)."""
    q = near.copy()
    off = turned = 0.0
    error = np.zeros(6)
    for _ in range(steps):
        at, matrix = walk(q, offsets, ways, turns, tool)
        error[:3] = goal[:3, 3] - at[:3, 3]
        error[3:] = _turn_of(np.ascontiguousarray(goal[:3, :3]) @ np.ascontiguousarray(at[:3, :3].T))
        off, turned = np.sqrt(np.sum(error[:3] ** 2)), np.sqrt(np.sum(error[3:] ** 2))
        if off < _CLOSE and turned < _CLOSE_TURN:
            break
        matrix[3:] *= arm
        error[3:] *= arm
        gain = matrix @ matrix.T + (damping + 1e-3 * turned) * np.eye(6)
        step = matrix.T @ np.linalg.solve(gain, error)
        most = 0.0
        for i in range(len(q)):
            if turns[i]:
                most = max(most, abs(step[i]))
        step *= min(1.0, _MOST_TURN / max(most, 1e-9))
        q = np.minimum(np.maximum(q + step, limits[0]), limits[1])
    return q, off, turned


@njit(cache=True, nogil=True, error_model="numpy")
def _rotation(axis: Floats, angle: float) -> Floats:
    """(3, 3) about a unit axis (Rodrigues)."""
    x, y, z = axis
    c, s = np.cos(angle), np.sin(angle)
    k = 1.0 - c
    return np.array(
        [
            [c + x * x * k, x * y * k - z * s, x * z * k + y * s],
            [y * x * k + z * s, c + y * y * k, y * z * k - x * s],
            [z * x * k - y * s, z * y * k + x * s, c + z * z * k],
        ]
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _turn_of(r: Floats) -> Floats:
    """(3,) rotation vector of a (3, 3) rotation; at a half turn, one of its two."""
    w = 0.5 * np.array([r[2, 1] - r[1, 2], r[0, 2] - r[2, 0], r[1, 0] - r[0, 1]])
    sine, cosine = np.sqrt(np.sum(w**2)), 0.5 * (r[0, 0] + r[1, 1] + r[2, 2] - 1.0)
    if sine > 1e-9:
        w *= np.arctan2(sine, cosine) / sine
        return w
    if cosine > 0.0:
        return w
    k = 0
    for i in range(3):
        k = i if r[i, i] > r[k, k] else k
    axis = r[:, k].copy()
    axis[k] += 1.0
    axis *= np.pi / np.sqrt(np.sum(axis**2))
    return axis
