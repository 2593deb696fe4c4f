"""Poses that a likely one slides or turns to: along what the contacts tell least, and about the principal axes.

Where a body is nearly one of revolution, or nearly a bar, a few contacts in a hole or at an end alone tell how far
it is turned or shifted.  A descent finds them only from close by; elsewhere they pass for contacts that stray.  So
the whole way is tried: with the covariance C of (v, w) and the size s, the twist x is the eigenvector of
D C D, D = diag(1, s / 2), that belongs to its largest value, as a turn or a shift, whichever it is more of.  A
body that looks nearly the same a turn further is not loose there: a gear with a keyway, by a tooth.  The axis of
such turns is nearly a principal one of its surface, and all turns about these are tried as well.  Of poses along
the loosest twist those are kept that cost least on the distance field, neighbors too, for the field blurs what is
smaller than its cells; of turns those that cost less than both neighbors (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from primitives.arrays import Floats
from primitives.pose import exp, inverse, pose
from recognition.matching.belief import Hypothesis
from recognition.matching.hypotheses import Begun, SearchConfig, scored
from recognition.matching.target import Target


@dataclass(frozen=True)
class SlideConfig:
    """How far, how finely, and how many."""

    step: float = 0.8  # [mm] at half the size from the middle
    kept: int = 12  # poses along the loosest twist, the best, and as many turns


def slid(h: Hypothesis, begun: Begun, target: Target, search: SearchConfig,
         config: SlideConfig = SlideConfig()) -> Floats:  # fmt: skip
    """(k, 3, 4) poses object_from_world beside that of a hypothesis, best first."""
    arm = 0.5 * target.size
    middle, axes = _principal(target)
    turns = [_along(middle, np.append(np.zeros(3), axis / arm), np.pi * arm, config.step) for axis in axes]
    slides = _along(target.center, *_loosest(h.covariance, arm), config.step)

    def placed(moves: Floats) -> tuple[Floats, Floats]:
        poses = np.ascontiguousarray((moves @ inverse(h.pose))[:, :3])
        return poses, scored(begun, target, poses, search)

    turned = _together([_dips(*placed(way)) for way in turns])
    both = _together([_best(*lot, config.kept) for lot in (placed(slides), turned)])
    return _best(*both, 2 * config.kept)[0]


def _together(lots: Sequence[tuple[Floats, Floats]]) -> tuple[Floats, Floats]:
    return np.concatenate([poses for poses, _ in lots]), np.concatenate([costs for _, costs in lots])


def _best(poses: Floats, costs: Floats, count: int) -> tuple[Floats, Floats]:
    order = np.argsort(costs, kind="stable")[:count]
    return poses[order], costs[order]


def _dips(poses: Floats, costs: Floats) -> tuple[Floats, Floats]:
    """Those of poses all round that cost no more than both neighbors."""
    low = (costs <= np.roll(costs, 1)) & (costs <= np.roll(costs, -1))
    return poses[low], costs[low]


def _along(middle: Floats, twist: Floats, longest: float, step: float) -> Floats:
    """(k, 4, 4) moves by a (6,) twist a millimeter [1/mm], up to the longest [mm] to either side."""
    count = max(3, int(longest / step))
    shares = np.linspace(-longest, longest, 2 * count + 1)
    return np.asarray(pose(None, middle) @ exp(shares[:, None] * twist) @ pose(None, -middle))


def _principal(target: Target) -> tuple[Floats, Floats]:
    """(3,) the middle of the surface and (3, 3) its principal axes, one a row."""
    middle = target.points.mean(axis=0)
    return middle, np.linalg.eigh(np.cov((target.points - middle).T))[1].T


def _loosest(covariance: Floats, arm: float) -> tuple[Floats, float]:
    """(6,) twist of a millimeter at the end of an arm [mm], and how many of these there are to either side."""
    scale = np.array([1.0, 1.0, 1.0, arm, arm, arm])
    x = np.linalg.eigh(covariance * np.outer(scale, scale))[1][:, -1] / scale
    v, w = x[:3], x[3:]
    if arm * float(np.linalg.norm(w)) > float(np.linalg.norm(v)):
        v = v - w * float(w @ v) / float(w @ w)  # a turn about an axis, without a pitch
        return np.concatenate([v, w]) / (arm * float(np.linalg.norm(w))), np.pi * arm
    return np.concatenate([v / float(np.linalg.norm(v)), np.zeros(3)]), arm
