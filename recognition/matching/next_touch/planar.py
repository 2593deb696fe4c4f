"""The next touch as Schneiter has it: the path in one plane that most probably tells interpretations apart.

Objects are thought of as outlines in a plane, and a touch as where it met, and the normal there.  An
interpretation is an object at a pose.  Two are told apart by a path on which one is met and the other is not, or
where the places or the normals differ by more than they err.  Of all straight paths that is taken on which two
interpretations, drawn by their weights w, most probably are::

    1 - sum over i, j of w_i w_j [i and j would feel the same]

Our own code from the description that Berger and Khosla give (section 2.2.2.2 of their report).  The plane is the
level one through the middle of what is touched; how long a path takes does not count.  It is there to be measured
against.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from exploration.planning.touching.lone_touch import Approach
from exploration.planning.ways.round_ball import Ball
from models.library import Library
from primitives.arrays import Floats
from recognition.matching.next_touch.candidates import toward
from recognition.matching.next_touch.held import Believed, held
from recognition.matching.next_touch.outcomes import Outcomes, foresee


@dataclass(frozen=True)
class PlanarConfig:
    """Which paths are looked at, and what is told apart."""

    directions: int = 24  # in the plane
    beside: tuple[float, ...] = (-0.6, -0.3, 0.0, 0.3, 0.6)  # places of each, times the ball's radius
    depth: float = 1.0  # [mm] by which places differ,
    normal: float = 0.12  # [rad] or normals
    least: float = 1e-3  # probability of telling two apart, below which a path is not worth its while


def planar(
    belief: Believed,
    library: Library,
    ball: Ball,
    pad: tuple[float, float],
    rng: np.random.Generator,
    reachable: Callable[[Approach], bool] = lambda approach: True,
    config: PlanarConfig | None = None,
) -> Approach | None:
    """From outside the ball, for a skin of `pad` [mm]; None where no path in the plane tells any apart."""
    config = config or PlanarConfig()
    known = held(belief, library)
    offered = [a for a in _paths(ball, rng, config) if reachable(a)]
    if not len(known) or not offered:
        return None
    share = known.weights / max(float(known.weights.sum()), 1e-12)
    apart = told_apart(foresee(offered, known.solids, pad), share, config)
    best = int(np.argmax(apart))
    return offered[best] if apart[best] >= config.least else None


def told_apart(outcomes: Outcomes, share: Floats, config: PlanarConfig | None = None) -> Floats:
    """(c,) probability that two of h interpretations with (h,) weights, which sum to one, feel unlike."""
    config = config or PlanarConfig()
    hit, depth, normal = outcomes.hit, outcomes.depth, outcomes.normal
    near = np.abs(depth[:, :, None] - depth[:, None]) <= config.depth
    chord = np.linalg.norm(normal[:, :, None] - normal[:, None], axis=-1)
    same = (hit[:, :, None] == hit[:, None]) & near & (chord <= config.normal)
    return np.asarray(1.0 - np.einsum("i,cij,j->c", share, same.astype(float), share))


def _paths(ball: Ball, rng: np.random.Generator, config: PlanarConfig) -> list[Approach]:
    """Level, through the middle's height, from all sides and at places beside each other."""
    turns = rng.uniform(0.0, 2.0 * np.pi) + 2.0 * np.pi * np.arange(config.directions) / config.directions
    found = []
    for turn in turns:
        way = np.array([np.cos(turn), np.sin(turn), 0.0])
        across = np.array([-way[1], way[0], 0.0])
        found += [toward(ball, ball.center + off * ball.radius * across, way, rng) for off in config.beside]
    return found
