"""Where a simulated stage has been lately: poses of moments between its steps.

Between two steps the origin goes straight and the frame turns about one axis at one rate: with R the later
rotation seen from the earlier, and w its rotation vector,  p(s) = p0 + s (p1 - p0),  R(s) = R0 exp(s w).
"""

import numba
import numpy as np

from primitives.arrays import Floats

_KEPT = 64  # steps, at least


class StageTrail:
    """The latest poses of a stage."""

    def __init__(self, time: float, pose: Floats) -> None:
        self._times, self._poses = np.empty(2 * _KEPT), np.empty((2 * _KEPT, 4, 4))
        self._count = 0
        self.add(time, pose)

    def add(self, time: float, pose: Floats) -> None:
        """The stage is at a (4, 4) pose at `time` [s], later than any before."""
        if self._count == len(self._times):
            self._times[:_KEPT], self._poses[:_KEPT] = self._times[-_KEPT:], self._poses[-_KEPT:]
            self._count = _KEPT
        self._times[self._count], self._poses[self._count] = time, pose
        self._count += 1

    def at(self, times: Floats, mount: Floats) -> Floats:
        """(n, 4, 4) world_from_sensor at (n,) recent times [s], the sensor being mounted at (4, 4) `mount`."""
        out = np.empty((len(times), 4, 4))
        _poses_at(self._times[: self._count], self._poses, times, mount, out)
        return out


@numba.njit(cache=True, error_model="numpy")
def _poses_at(known: Floats, poses: Floats, times: Floats, mount: Floats, out: Floats) -> None:
    here, turn, turned = np.eye(4), np.zeros(3), -1
    for n in range(len(times)):
        k = len(known) - 1
        while k > 0 and known[k - 1] >= times[n]:
            k -= 1
        share = 1.0
        if k > 0:
            share = min(1.0, (times[n] - known[k - 1]) / (known[k] - known[k - 1]))
        before, after = poses[max(k - 1, 0)], poses[k]
        for i in range(3):
            here[i, 3] = before[i, 3] + share * (after[i, 3] - before[i, 3])
        if k != turned:
            _rotation_vector(before, after, turn)
            turned = k
        _turned(before, share * turn[0], share * turn[1], share * turn[2], here)
        for i in range(4):
            for j in range(4):
                total = 0.0
                for m in range(4):
                    total += here[i, m] * mount[m, j]
                out[n, i, j] = total


@numba.njit(cache=True, error_model="numpy")
def _rotation_vector(before: Floats, after: Floats, out: Floats) -> None:
    """(3,) [rad] by which one frame is turned from another, in the first; less than half a turn."""
    trace = 0.0
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        out[k] = 0.0
        for m in range(3):
            out[k] += 0.5 * (before[m, j] * after[m, i] - before[m, i] * after[m, j])
            trace += before[m, k] * after[m, k]
    sine = np.sqrt(out[0] ** 2 + out[1] ** 2 + out[2] ** 2)
    if sine > 1e-12:
        scale = np.arctan2(sine, 0.5 * (trace - 1.0)) / sine
        for k in range(3):
            out[k] *= scale


@numba.njit(cache=True, error_model="numpy")
def _turned(frame: Floats, wx: float, wy: float, wz: float, out: Floats) -> None:
    """A frame turned by a rotation vector [rad] of its own (Rodrigues)."""
    angle = np.sqrt(wx * wx + wy * wy + wz * wz)
    a, b = 1.0, 0.5
    if angle > 1e-8:
        half = np.sin(0.5 * angle) / angle
        a, b = np.sin(angle) / angle, 2.0 * half * half
    for i in range(3):
        x, y, z = frame[i, 0], frame[i, 1], frame[i, 2]
        ux, uy, uz = y * wz - z * wy, z * wx - x * wz, x * wy - y * wx
        out[i, 0] = x + a * ux + b * (uy * wz - uz * wy)
        out[i, 1] = y + a * uy + b * (uz * wx - ux * wz)
        out[i, 2] = z + a * uz + b * (ux * wy - uy * wx)
