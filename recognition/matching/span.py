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


def spread_of(
    information: Floats, found: Floats, points: Floats, entry: Entry, target: Target
) -> tuple[Floats, float]:
    """Covariance about the object's center, and the logarithm of the volume of pose space that it stands for.

    Turns of a continuous symmetry are no other pose: the covariance is given that there was none of these, and the
    volume has all of them, whatever facets say of them.
    """
    middle = found[:, :3] @ points.mean(axis=0) + found[:, 3]
    shift = np.eye(6)
    shift[:3, 3:] = hat(middle - target.center).T
    about = shift.T @ information @ shift + bounds(target)
    if not entry.symmetry.continuous:
        return _inverted(about)
    axis = entry.symmetry.axis
    other = _but_for(np.eye(3) if axis is None else axis[None])
    covariance, log_volume = _inverted(other.T @ about @ other)
    whole = 8 * np.pi**2 if axis is None else 2 * np.pi
    return np.asarray(other @ covariance @ other.T), log_volume + float(np.log(whole))


def _inverted(information: Floats) -> tuple[Floats, float]:
    """Covariance of (n, n) information, and the logarithm of the volume of its normal density."""
    values, axes = np.linalg.eigh(information)
    values = np.maximum(values, 1e-14 * values[-1])
    log_volume = 0.5 * len(values) * np.log(2 * np.pi) - 0.5 * np.log(values).sum()
    return np.asarray((axes / values) @ axes.T), float(log_volume)


def _but_for(axes: Floats) -> Floats:
    """(6, 6 - k) moves (v, w) that do not turn about (k, 3) orthonormal axes: with turns they span one volume."""
    across = np.linalg.svd(axes)[2][len(axes) :]
    other = np.zeros((6, 6 - len(axes)))
    other[:3, :3] = np.eye(3)
    other[3:, 3:] = across.T
    return other


def bounds(target: Target) -> Floats:
    """(6, 6) information of (v, w) where nothing was felt."""
    return np.diag([(3.0 / target.size) ** 2] * 3 + [1 / _FREE_TURN**2] * 3)


def log_copies(entry: Entry, covariance: Floats, target: Target) -> float:
    """Logarithm of how many symmetric poses a mode stands for besides those that its covariance spans already.

    Turns of a continuous symmetry are left out: the volume counts them.
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
