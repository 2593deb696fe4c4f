"""The next touch where the name is known: the one after which the object's surface would be least in doubt.

A touch tells how far the surface is along its normal n, at a place r from the object's center, and how that is
turned.  With the covariance C of (v, w) the place x is off by v + w x x, and what is left in doubt is::

    doubt^2 = mean over x of |v + w x x|^2 = tr(C M),   M = mean over x of A^T A,   A = [I, -[x]]

C after a touch is (C^-1 + J^T J)^-1, J = ([n, r x n] / sigma, [0, t_k] / tau) with t_k across n: optimal design
for a mean of variances, one touch ahead (Pukelsheim 2006, chapter 6; the choice of M is ours).  Where the skin's
own picture is matched too, an edge under it tells where the object is along the skin: what that adds to J^T J is
asked of the touches that promise most, and of some beside edges (`sharpened.known_by`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from exploration.planning.touching.lone_touch import Approach
from exploration.planning.ways.round_ball import Ball
from models.library import Entry
from primitives import pose as se3
from primitives.arrays import Floats, Ints
from primitives.evidence import Imprint
from recognition.matching.next_touch.candidates import toward
from recognition.matching.next_touch.held import Posed
from recognition.matching.next_touch.outcomes import Outcomes, foresee
from recognition.matching.sharpened import known_by


@dataclass(frozen=True)
class PlacingConfig:
    """What is looked at."""

    places: int = 120  # on the surface, that are aimed at
    risk: float = 0.3  # chance that a touch does not settle, beyond which it is not made
    pictured: int = 16  # touches whose whole picture is asked, and as many beside edges
    press: float = 0.6  # [mm] by which the skin is pressed in


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
    skin: Imprint | None = None,
) -> Approach | None:
    """From outside the ball, for a skin of `pad` [mm] with `noise` [mm], [rad]; None where nothing can be felt.

    `skin` is an imprint of this sensor, where such pictures are matched.
    """
    config = config or PlacingConfig()
    points = se3.transform_points(h.pose, entry.samples.points)
    normals = se3.rotate(h.pose, entry.samples.normals)
    rows = rng.permutation(len(points))[: config.places]
    offered = [toward(ball, points[r], -normals[r], rng) for r in rows]
    offered = [a for a in offered if reachable(a)]
    if not offered:
        return None
    foreseen = foresee(offered, (entry.solid.placed(h.pose),), pad)
    sound = foreseen.hit[:, 0] & foreseen.flush[:, 0] & (foreseen.risk[:, 0] <= config.risk)
    rows = np.flatnonzero(sound)
    if not len(rows):
        return None
    told = _told(h, entry, [offered[r] for r in rows], foreseen, rows, noise)
    before = np.linalg.inv(h.covariance + 1e-9 * np.eye(6))
    left = _left(before + told, entry)
    if skin is not None:
        asked = _pictured(left, foreseen.gaps[rows, 0], config)
        lying = [_lying(offered[r], foreseen, r, config) for r in rows[asked]]
        solid, center = entry.solid.placed(h.pose), _center(entry)
        more = np.stack([known_by(replace(skin, pose=at), solid, center) for at in lying])
        rows, left = rows[asked], _left(before + told[asked] + more, entry)
    best: Approach = offered[int(rows[int(np.argmin(left))])]
    return best


def _left(information: Floats, entry: Entry) -> Floats:
    """(c,) [mm^2] in doubt where (c, 6, 6) is known."""
    return np.asarray(np.einsum("cij,ji->c", np.linalg.inv(information), _displacing(entry)))


def _pictured(left: Floats, gaps: Floats, config: PlacingConfig) -> Ints:
    """Rows of the touches that promise most by (c,) what they leave, and of those beside edges by (c, k) gaps."""
    order = np.argsort(left, kind="stable")
    beside = order[(gaps[order] >= gaps.max()).any(axis=1)]
    return np.unique(np.concatenate([order[: config.pictured], beside[: config.pictured]]))


def _lying(made: Approach, foreseen: Outcomes, row: int, config: PlacingConfig) -> Floats:
    """(4, 4) world_from_sensor of the undented skin, as it lies flush and pressed."""
    normal = foreseen.normal[row, 0]
    across = made.start[:3, 0] - normal * float(normal @ made.start[:3, 0])
    x = across / float(np.linalg.norm(across))
    turn = np.column_stack([x, np.cross(-normal, x), -normal])
    reached = made.start[:3, 3] + foreseen.depth[row, 0] * made.direction
    return se3.pose(turn, reached - config.press * normal)


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
