"""Where else an object may be, whose pose is known but loosely: sigma points along its covariance's widest axes.

A mode stands for all poses that its covariance spans.  A pose that may still slide along a face foresees one
outcome at its middle and others where it would have slid to, and only those others show that a touch of its end
would tell where it is.  The sigma points of an axis e with the variance s^2 are +-1.2 s e (our derivation).
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from models.library import Entry
from primitives.arrays import Floats
from primitives.pose import exp, pose

_CROSSED = (-1.5, -0.5, 0.5, 1.5)  # sigmas along each axis, which have a normal variable's variance nearly


@dataclass(frozen=True)
class LooseConfig:
    """When a pose is loose, and how many poses stand for it."""

    axes: int = 3  # at most
    moved: float = 0.4  # [mm] mean distance of the surface from itself, from which poses differ
    sigmas: tuple[float, ...] = (1.2,)  # to both sides of the middle
    turned: float = 0.6  # [rad] of a sigma point, at most
    shifted: float = 0.35  # of the object's size, likewise
    samples: int = 60  # of the surface, that are asked


def sigma_points(
    at: Floats, covariance: Floats, entry: Entry, config: LooseConfig | None = None
) -> list[Floats]:
    """The pose (4, 4) itself and, where it is loose, those beside it; all alike probable.

    `covariance` (6, 6) is of (v [mm], w [rad]) in the object's frame, about the middle of its box.
    """
    config = config or LooseConfig()
    steps, middle = _steps(covariance, entry, config)
    shares = [way * s / max(config.sigmas) for s in config.sigmas for way in (1.0, -1.0)]
    return [at, *(at @ _moved(share * step, middle) for step in steps for share in shares)]


def cross_points(
    at: Floats, covariance: Floats, entry: Entry, config: LooseConfig | None = None
) -> list[Floats]:
    """Poses (4, 4) all over what a loose one stands for: every combination of steps along its axes."""
    config = config or LooseConfig()
    steps, middle = _steps(covariance, entry, config)
    shares = np.array(_CROSSED) / max(config.sigmas)
    combined = itertools.product(shares, repeat=len(steps)) if steps else ()
    return [at @ _moved(np.asarray(each) @ np.array(steps), middle) for each in combined]


def _moved(step: Floats, middle: Floats) -> Floats:
    return np.asarray(pose(np.eye(3), middle) @ exp(step) @ pose(np.eye(3), -middle))


def _steps(covariance: Floats, entry: Entry, config: LooseConfig) -> tuple[list[Floats], Floats]:
    """(6,) steps of the widest sigma along each loose axis, and the (3,) point that they turn about."""
    points = np.asarray(entry.samples.points, dtype=float)
    low, high = points.min(axis=0), points.max(axis=0)
    size, middle = float(np.linalg.norm(high - low)), 0.5 * (low + high)
    scale = np.array([1.0, 1.0, 1.0, 0.35 * size, 0.35 * size, 0.35 * size])  # [mm] of every component
    values, axes = np.linalg.eigh(covariance * np.outer(scale, scale))
    few, solid = points[: config.samples], entry.solid.placed(np.eye(4))
    found: list[Floats] = []
    for k in np.argsort(-values)[: 2 * config.axes]:
        if len(found) >= config.axes or values[k] < config.moved**2:
            break
        step = max(config.sigmas) * np.sqrt(values[k]) * axes[:, k] / scale
        step *= min(1.0, config.turned / max(float(np.linalg.norm(step[3:])), 1e-9))
        step *= min(1.0, config.shifted * size / max(float(np.linalg.norm(step[:3])), 1e-9))
        beside = _moved(-step, middle)
        moved = few @ beside[:3, :3].T + beside[:3, 3]
        if float(np.abs(solid.signed_distance(moved)).mean()) > config.moved:
            found.append(step)
    return found, middle
