"""What poses one mode stands for: its covariance, the volume of pose space, and the symmetric poses in it.

A direction that nothing was felt in is bounded by the object's size, or by half a turn.  Poses that a covariance
spans are one mode.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from models.library import Entry
from models.symmetry import nearest_pose
from primitives.arrays import Bools, Floats
from primitives.pose import hat, inverse, log, pose
from recognition.matching.belief import Hypothesis
from recognition.matching.target import Target

_FREE_TURN = 1.71  # [rad] sigma of a direction of turning that nothing bounds: its cube gives all of SO(3)
_SPANNED = 9.0  # squared sigmas of a mode's covariance, within which a pose is of that mode
_MERGED = 0.005, 0.01  # of the size, and [rad]: poses closer than that are one, however sharp they are


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


def same(entry: Entry, there: Sequence[Hypothesis], world: Floats, target: Target) -> Bools:
    """(k,) whether a pose is one that is there already, up to symmetry and to what its covariance spans."""
    if not there:
        return np.zeros(0, dtype=bool)
    poses = np.stack([h.pose for h in there])
    spans = np.stack([h.covariance for h in there]) + _least(target)
    near, back = nearest_pose(entry.symmetry, world, poses), np.swapaxes(poses[:, :3, :3], 1, 2)
    shift = (near - poses)[:, :3, :3] @ target.center + (near - poses)[:, :3, 3]
    between = log(pose(back @ near[:, :3, :3], np.einsum("kij,kj->ki", back, shift)))
    squared = np.einsum("ki,ki->k", between, np.linalg.solve(spans, between[..., None])[..., 0])
    return np.asarray(squared <= _SPANNED)


def _least(target: Target) -> Floats:
    """(6, 6) covariance within which poses are one, however sharp they are."""
    least = np.array([_MERGED[0] * target.size] * 3 + [_MERGED[1]] * 3) ** 2
    return np.diag(least) / _SPANNED
