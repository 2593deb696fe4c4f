"""What poses one mode stands for: its covariance, the volume of pose space, and the symmetric poses in it.

A direction that nothing was felt in is bounded by the object's size, or by half a turn.  Poses that a covariance
spans are one mode.
"""

from __future__ import annotations

import numpy as np

from models.library import Entry
from models.symmetry import nearest_pose
from primitives.arrays import Floats
from primitives.pose import hat, inverse, log, pose, rotation_log
from recognition.matching.belief import Hypothesis
from recognition.matching.target import Target

_FREE_TURN = 1.71  # [rad] sigma of a direction of turning that nothing bounds: its cube gives all of SO(3)
_SPANNED = 9.0  # squared sigmas of a mode's covariance, within which a pose is of that mode
_MERGED = 0.005, 0.01  # of the size, and [rad]: poses closer than that are one, however sharp they are
_BENDS = 0.1  # [rad] of a turn from which on its way is an arc, not a straight line


def spread_of(information: Floats, found: Floats, points: Floats, target: Target) -> tuple[Floats, float]:
    """Covariance about the object's center, and the logarithm of the volume of pose space that it stands for."""
    middle = found[:, :3] @ points.mean(axis=0) + found[:, 3]
    shift = np.eye(6)
    shift[:3, 3:] = hat(middle - target.center).T
    about = shift.T @ information @ shift
    values, axes = np.linalg.eigh(about + bounds(target))
    values = np.maximum(values, 1e-14 * values[-1])
    log_volume = 3 * np.log(2 * np.pi) - 0.5 * np.log(values).sum()
    return np.asarray((axes / values) @ axes.T), float(log_volume)


def bounds(target: Target) -> Floats:
    """(6, 6) information of (v, w) where nothing was felt."""
    return np.diag([(3.0 / target.size) ** 2] * 3 + [1 / _FREE_TURN**2] * 3)


def but_for_turns(entry: Entry, covariance: Floats) -> Floats:
    """Without the turns of a continuous symmetry, which are no other pose: given that there was none of these."""
    group = entry.symmetry
    if not group.continuous:
        return covariance
    axes = np.eye(3) if group.axis is None else group.axis[None]
    rows = np.hstack([np.zeros((len(axes), 3)), axes])
    across = covariance @ rows.T
    return np.asarray(covariance - across @ np.linalg.solve(rows @ across, across.T))


def log_copies(entry: Entry, covariance: Floats, target: Target) -> float:
    """Logarithm of how many symmetric poses a mode stands for besides those that its covariance spans already.

    Turns about an axis of revolution are left out: the volume counts them.
    """
    turns = entry.symmetry.rotations
    if len(turns) == 1:
        return 0.0
    center = pose(None, target.center)
    twists = log(inverse(center) @ turns @ center)
    spanned = np.einsum("ki,ij,kj->k", twists, np.linalg.inv(covariance + _least(target)), twists) <= _SPANNED
    return float(np.log(len(turns)) - np.log(max(int(spanned.sum()), 1)))


def same(entry: Entry, h: Hypothesis, world: Floats, target: Target) -> bool:
    """Whether a pose is one that is there already, up to symmetry and to what the covariance spans."""
    near = nearest_pose(entry.symmetry, world, h.pose)
    turn = h.pose[:3, :3].T @ near[:3, :3]
    shift = (near - h.pose)[:3, :3] @ target.center + (near - h.pose)[:3, 3]
    spans = h.covariance + _least(target)
    between = np.concatenate([h.pose[:3, :3].T @ shift, _axis(turn)])
    if between[3:] @ between[3:] > _BENDS**2:
        between = log(pose(turn, between[:3]))
    return bool(between @ np.linalg.solve(spans, between) <= _SPANNED)


def _axis(turn: Floats) -> Floats:
    """(3,) rotation vector [rad]; `rotation_log` where it is near a half turn, which takes longer."""
    cosine = 0.5 * float(turn[0, 0] + turn[1, 1] + turn[2, 2] - 1.0)
    if cosine < -0.95:
        return rotation_log(turn)
    twice = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    angle = float(np.arccos(min(cosine, 1.0)))
    return np.asarray(0.5 * twice / max(float(np.sinc(angle / np.pi)), 1e-9))


def _least(target: Target) -> Floats:
    """(6, 6) covariance within which poses are one, however sharp they are."""
    least = np.array([_MERGED[0] * target.size] * 3 + [_MERGED[1]] * 3) ** 2
    return np.diag(least) / _SPANNED
