"""What is left to be told where a touch was made already.

Rivals that stayed after a touch foresee its like no better than they foresaw it: what their poses and models get
wrong there is the same the next time, and the bits that seemed to be in it are not.  Of what a touch promises the
share that is left is (our derivation)::

    product over the touches made of  1 - again exp(-1/2 ((d / place)^2 + (angle / turn)^2))

with d between where the pads lie and the angle between their normals.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from primitives.arrays import Floats


@dataclass(frozen=True)
class NoveltyConfig:
    """What counts as the same place."""

    again: float = 0.8  # share of its bits that a touch loses where one was made
    place: float = 0.5  # times the pad's mean side
    turn: float = 0.35  # [rad]


def novelty(lying: Floats, made: Sequence[Floats], pad: tuple[float, float],
            config: NoveltyConfig | None = None) -> Floats:  # fmt: skip
    """(c,) shares left of pads that would lie at (c, 4, 4), after touches at (4, 4) each."""
    config, left = config or NoveltyConfig(), np.ones(len(lying))
    wide = config.place * float(np.mean(pad))
    for other in made:
        away = np.linalg.norm(lying[:, :3, 3] - other[:3, 3], axis=1) / wide
        turned = np.arccos(np.clip(lying[:, :3, 2] @ other[:3, 2], -1.0, 1.0)) / config.turn
        left *= 1.0 - config.again * np.exp(-0.5 * (away**2 + turned**2))
    return left
