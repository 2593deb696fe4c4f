"""The next touch where the name is known: the one after which the object's surface would be least in doubt.

A touch tells how far the surface is along its normal n, at a place r from the object's center, and how that is
turned.  With the covariance C of (v, w) the place x is off by v + w x x, and what is left in doubt is::

    doubt^2 = mean over x of |v + w x x|^2 = tr(C M),   M = mean over x of A^T A,   A = [I, -[x]]

C after a touch is (C^-1 + J^T J)^-1, J = ([n, r x n] / sigma, [0, t_k] / tau) with t_k across n: optimal design
for a mean of variances, one touch ahead (Pukelsheim 2006, chapter 6; the choice of M is ours).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from exploration.planning.touching.lone_touch import Approach
from exploration.planning.ways.round_ball import Ball
from models.library import Entry
from primitives import pose as se3
from primitives.arrays import Floats, Ints
from recognition.matching.next_touch.candidates import toward
from recognition.matching.next_touch.held import Posed
from recognition.matching.next_touch.outcomes import Outcomes, foresee


@dataclass(frozen=True)
class PlacingConfig:
    """What is looked at."""

    places: int = 120  # on the surface, that are aimed at
    risk: float = 0.3  # chance that a touch does not settle, beyond which it is not made


def doubt(h: Posed, entry: Entry) -> float:
    """[mm] root mean square of how far places of the surface may be off."""
    return float(np.sqrt(max(np.trace(h.covariance @ _displacing(entry)), 0.0)))


def placing(
    h: Posed,
    entry: Entry,
    ball: Ball,
    pad: tuple[float, float],
    noise: tuple[float, float],
    rng: np.random.Generator,
    reachable: Callable[[Approach], bool] = lambda approach: True,
    config: PlacingConfig | None = None,
) -> Approach | None:
    """From outside the ball, for a skin of `pad` [mm] with `noise` [mm], [rad]; None where nothing can be felt."""
    config = config or PlacingConfig()
    points = se3.transform_points(h.pose, entry.samples.points)
    normals = se3.rotate(h.pose, entry.samples.normals)
    rows = rng.permutation(len(points))[: config.places]
    offered = [toward(ball, points[r], -normals[r], rng) for r in rows]
    offered = [a for a in offered if reachable(a)]
    if not offered:
        return None
    foreseen = foresee(offered, (entry.solid.placed(h.pose),), pad)
    sound = foreseen.hit[:, 0] & ~foreseen.sharp[:, 0] & (foreseen.risk[:, 0] <= config.risk)
    rows = np.flatnonzero(sound)
    if not len(rows):
        return None
    told = _told(h, entry, [offered[r] for r in rows], foreseen, rows, noise)
    before = np.linalg.inv(h.covariance + 1e-9 * np.eye(6))
    after = np.linalg.inv(before + told)
    left = np.einsum("cij,ji->c", after, _displacing(entry))
    best: Approach = offered[int(rows[int(np.argmin(left))])]
    return best


def _told(
    h: Posed,
    entry: Entry,
    made: list[Approach],
    foreseen: Outcomes,
    rows: Ints,
    noise: tuple[float, float],
) -> Floats:
    """(c, 6, 6) J^T J of each touch, in the object's frame about its center."""
    sigma, tau = noise
    turn, center = h.pose[:3, :3], _center(entry)
    starts = np.stack([a.start for a in made])
    reached = starts[:, :3, 3] + foreseen.depth[rows, 0][:, None] * starts[:, :3, 2]
    r = (reached - h.pose[:3, 3]) @ turn - center
    n = foreseen.normal[rows, 0] @ turn
    along = np.hstack([n, np.cross(r, n)]) / sigma
    told = along[:, :, None] * along[:, None]
    told[:, 3:, 3:] += (np.eye(3) - n[:, :, None] * n[:, None]) / tau**2
    return np.asarray(told)


def _displacing(entry: Entry) -> Floats:
    """(6, 6) M of the surface's samples."""
    x = entry.samples.points - _center(entry)
    moved = np.zeros((len(x), 3, 6))
    moved[:, :, :3] = np.eye(3)
    moved[:, :, 3:] = np.stack([np.cross(axis, x) for axis in np.eye(3)], axis=-1)
    return np.asarray(np.einsum("nai,naj->ij", moved, moved) / len(x))


def _center(entry: Entry) -> Floats:
    """(3,) [mm] of the box round the samples, which covariances are about."""
    return np.asarray(0.5 * (entry.samples.points.min(axis=0) + entry.samples.points.max(axis=0)))
