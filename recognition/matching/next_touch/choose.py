"""The next touch: of many reachable approaches, the one that is expected to tell most in its time.

    worth = (bits about the name + share * bits about the pose) * (1 - risk) / seconds

with the seconds of the way there and back, the advance, settling, and what a failed landing costs (our derivation;
`Pace` has them).  The utility is a callable, so that a planner can be handed another.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from exploration.planning.touching.lone_touch import Approach
from exploration.planning.touching.pace import Pace
from exploration.planning.ways.round_ball import Ball, way_round
from models.library import Library
from primitives.arrays import Floats
from recognition.matching.next_touch.candidates import CandidateConfig, candidates
from recognition.matching.next_touch.flight import FlightConfig, flown, foreseen_flight, least_turned
from recognition.matching.next_touch.held import Believed, Held, held
from recognition.matching.next_touch.information import TouchNoise, information
from recognition.matching.next_touch.novelty import novelty
from recognition.matching.next_touch.outcomes import Outcomes, foresee
from recognition.matching.next_touch.placing import doubt, placing

Utility = Callable[[Outcomes, Held], Floats]  # (c,) bits of each approach


@dataclass(frozen=True)
class ChooseConfig:
    """What bits are worth."""

    pose_share: float = 0.4  # of a bit about the name, that one about its pose is worth
    flight: FlightConfig = field(default_factory=FlightConfig)
    least: float = 0.01  # [bits] below which a touch tells nothing
    open: float = 0.25  # [mm] error of places of its surface, from which a pose is worth settling,
    touch: tuple[float, float] = (0.15, 0.02)  # [mm], [rad] by touches that err so
    hurried: bool = True  # whether bits are counted by the second
    candidates: CandidateConfig = field(default_factory=CandidateConfig)
    noise: TouchNoise = field(default_factory=TouchNoise)


@dataclass(frozen=True)
class Choice:
    """An approach, and what is expected of it."""

    approach: Approach
    way: tuple[Floats, ...]  # poses to its start
    bits: float  # about the name and, by its share, the pose
    name_bits: float
    seconds: float

    @property
    def bits_per_second(self) -> float:
        """What it was chosen by."""
        return self.bits / self.seconds


@dataclass(frozen=True)
class NoChoice:
    """No reachable touch would tell anything; false in a condition."""

    reason: str

    def __bool__(self) -> Literal[False]:
        return False


def choose(
    belief: Believed,
    library: Library,
    here: Floats,
    ball: Ball,
    pad: tuple[float, float],
    pace: Pace,
    rng: np.random.Generator,
    config: ChooseConfig | None = None,
    utility: Utility | None = None,
    reachable: Callable[[Approach], bool] = lambda approach: True,
    known: Held | None = None,
    made: Sequence[Floats] = (),
) -> Choice | NoChoice:
    """From the pose (4, 4) `here`, outside a ball that holds the object.

    `known` is what stands for the belief; without it that is its modes.  `made` are (4, 4) where the pad lay.
    """
    config = config or ChooseConfig()
    known = held(belief, library) if known is None else known
    if not len(known):
        return NoChoice("no object of the library is likely")
    offered = [least_turned(a, here) for a in candidates(known, library, ball, rng, config.candidates)]
    offered = [a for a in offered if reachable(a)]
    if not offered:
        return NoChoice("no approach is within the stage's reach")
    outcomes = foresee(offered, known.solids, pad)
    names, poses = information(outcomes, known, config.noise)
    bits = names + config.pose_share * poses if utility is None else utility(outcomes, known)
    bits = bits * novelty(_lying(offered, outcomes, known), made, pad)
    share = known.weights / max(float(known.weights.sum()), 1e-12)
    risk = outcomes.risk @ share
    hits = outcomes.hit @ share
    length = np.array([a.length for a in offered])
    advance = outcomes.depth @ share + (1.0 - hits) * length
    ways = [way_round(here, a.start, ball) for a in offered]
    travel = np.array([pace.travel(here, way) for way in ways])
    flight = foreseen_flight(np.where(outcomes.hit, outcomes.depth, np.inf), known, config.flight)
    seconds = travel + pace.approach(flight, advance - flight) + pace.back(advance)
    seconds += pace.settling * hits + pace.failing * risk
    worth = bits * (1.0 - risk)
    best = int(np.argmax(worth / seconds if config.hurried else worth))
    if worth[best] < config.least:
        return NoChoice("no reachable touch would tell what is left apart")
    return Choice(
        flown(offered[best], known, library, pad, config.flight),
        tuple(ways[best]),
        float(worth[best]),
        float(names[best]),
        float(seconds[best]),
    )


def _lying(offered: list[Approach], outcomes: Outcomes, known: Held) -> Floats:
    """(c, 4, 4) where pads would come to lie, in the mean of those hypotheses that they meet."""
    weights = outcomes.hit * known.weights
    depth = (outcomes.depth * weights).sum(axis=1) / np.maximum(weights.sum(axis=1), 1e-12)
    lying = np.stack([a.start for a in offered])
    lying[:, :3, 3] += depth[:, None] * lying[:, :3, 2]
    return lying


def separating(
    belief: Believed,
    library: Library,
    here: Floats,
    ball: Ball,
    pad: tuple[float, float],
    pace: Pace,
    rng: np.random.Generator,
    reachable: Callable[[Approach], bool] = lambda approach: True,
    known: Held | None = None,
) -> Choice | NoChoice:
    """The touch that tells most of which object it is, however long it takes.

    Where none does while the pose is open, it is the one that settles the pose, and its bits about the name are 0.
    """
    config = replace(ChooseConfig(), pose_share=0.0, hurried=False)
    found = choose(belief, library, here, ball, pad, pace, rng, config, reachable=reachable, known=known)
    best = max(belief.hypotheses, key=lambda h: h.log_weight, default=None)
    if isinstance(found, Choice) or best is None or doubt(best, library[best.name]) <= config.open:
        return found
    settling = placing(best, library[best.name], ball, pad, config.touch, rng, reachable)
    if settling is None:
        return found
    way = way_round(here, settling.start, ball)
    seconds = pace.travel(here, way) + float(pace.approach(0.0, 0.5 * settling.length)) + pace.settling
    return Choice(settling, tuple(way), 0.0, 0.0, seconds)
