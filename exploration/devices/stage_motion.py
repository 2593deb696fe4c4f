"""The motion of a double integrator within limits, as kernels: one tick of a twist, and a straight move.

A twist in the flange frame is approached at the acceleration limits, linear and angular apart; speeds beyond the
limits are shortened.  A straight move follows s(t), a trapezoid from 0 to 1, along a line and a fixed axis.
"""

import numpy as np
from numba import njit

from primitives.arrays import Floats

_SUBSTEP = 0.001  # [s] over which the flange frame is taken as fixed


@njit(cache=True, error_model="numpy")
def follow(pose: Floats, velocity: Floats, twist: Floats, limits: Floats, duration: float) -> None:
    """Advance a (4, 4) pose and its (6,) world velocity, in place; limits (4,): speeds, accelerations."""
    steps = max(1, int(np.ceil(duration / _SUBSTEP - 1e-9)))
    dt = duration / steps
    wanted, mean = np.zeros(6), np.zeros(6)
    for _ in range(steps):
        for part in range(2):
            k = 3 * part
            size = 0.0
            for i in range(3):
                wanted[k + i] = 0.0
                for j in range(3):
                    wanted[k + i] += pose[i, j] * twist[k + j]
                size += wanted[k + i] ** 2
            size = np.sqrt(size)
            shorten = limits[part] / size if size > limits[part] else 1.0
            change = 0.0
            for i in range(3):
                wanted[k + i] *= shorten
                change += (wanted[k + i] - velocity[k + i]) ** 2
            change = np.sqrt(change)
            most = limits[2 + part] * dt
            share = most / change if change > most else 1.0
            for i in range(3):
                after = velocity[k + i] + share * (wanted[k + i] - velocity[k + i])
                mean[k + i] = 0.5 * (velocity[k + i] + after)
                velocity[k + i] = after
        for i in range(3):
            pose[i, 3] += mean[i] * dt
        if mean[3] != 0.0 or mean[4] != 0.0 or mean[5] != 0.0:
            turn(pose, mean[3] * dt, mean[4] * dt, mean[5] * dt)


@njit(cache=True, error_model="numpy")
def turn(pose: Floats, wx: float, wy: float, wz: float) -> None:
    """Turn a pose's rotation by a world rotation vector [rad], in place (Rodrigues)."""
    angle = np.sqrt(wx * wx + wy * wy + wz * wz)
    if angle < 1e-15:
        return
    a = np.sin(angle) / angle
    b = 2.0 * (np.sin(0.5 * angle) / angle) ** 2
    for j in range(3):
        x, y, z = pose[0, j], pose[1, j], pose[2, j]
        ux, uy, uz = wy * z - wz * y, wz * x - wx * z, wx * y - wy * x
        pose[0, j] = x + a * ux + b * (wy * uz - wz * uy)
        pose[1, j] = y + a * uy + b * (wz * ux - wx * uz)
        pose[2, j] = z + a * uz + b * (wx * uy - wy * ux)


@njit(cache=True, error_model="numpy")
def progress(time: float, speed: float, acceleration: float) -> tuple[float, float]:
    """Progress (0 to 1) and rate of a trapezoid `time` [s] after it began; speed [1/s], acceleration [1/s^2]."""
    ramp = min(speed / acceleration, np.sqrt(1.0 / acceleration))
    top = ramp * acceleration
    total = ramp + 1.0 / top
    if time >= total:
        return 1.0, 0.0
    if time < ramp:
        return 0.5 * acceleration * time * time, acceleration * time
    if time > total - ramp:
        left = total - time
        return 1.0 - 0.5 * acceleration * left * left, acceleration * left
    return top * (time - 0.5 * ramp), top


@njit(cache=True, error_model="numpy")
def run(
    pose: Floats,
    velocity: Floats,
    start: Floats,
    path: Floats,
    time: float,
    speed: float,
    acceleration: float,
) -> bool:
    """Set pose and velocity, in place, on a straight move along a (6,) path; whether it has ended."""
    s, rate = progress(time, speed, acceleration)
    pose[:] = start
    turn(pose, s * path[3], s * path[4], s * path[5])
    for i in range(3):
        pose[i, 3] += s * path[i]
    for i in range(6):
        velocity[i] = rate * path[i]
    return bool(s >= 1.0)
