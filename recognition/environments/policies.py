"""Our planners as policies of the environments, so that learned ones compare with them.

    env = gymnasium.make("palpate/Identify-v0")
    policy = InformationPolicy()
    observation, info = env.reset(seed=0)
    while True:
        observation, reward, terminated, truncated, info = env.step(policy(env))
        if terminated or truncated:
            break

A policy looks into the environment for what an observation tells of it only in part: the whole belief, with its
poses.  It sees no more than `palpate identify` does, and never the object.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from recognition.environments.actions import SIZE, action_of
from recognition.environments.explore import ExploreEnv
from recognition.environments.identify import IdentifyEnv
from recognition.identifying.policies import POLICY, gap_touch
from recognition.matching.next_touch.choose import Choice, choose


@dataclass
class InformationPolicy:
    """Of `palpate/Identify-v0`: the approach that is expected to tell most in its time, until it is sure."""

    confidence: float = 0.95
    confirmed: int = 2  # touches in a row, after each of which the same name is sure enough
    least: int = 4  # touches that met something, before which nothing is sure
    misses: int = 2  # touches in a row without a contact, after which the widest gap is touched
    seed: int = 0

    def __post_init__(self) -> None:
        self._rng = np.random.default_rng(self.seed)
        self._agreed, self._name = 0, ""

    def __call__(self, env: Any) -> np.ndarray:
        """The next action."""
        me = cast(IdentifyEnv, env.unwrapped).identifier
        if self._sure(me):
            self._agreed = 0
            return np.array([*np.zeros(SIZE), 1.0], dtype=np.float32)
        ball, hand = me.around(), me.hand
        found = None
        told = [bool(len(t.contacts)) for t in me.touches[-self.misses :]]
        if me.belief is not None and any(told):
            found = choose(me.belief, me.library, hand.here, ball, hand.pad, hand.pace, self._rng)
        places = np.array([t.pose[:3, 3] if t.met else t.approach.start[:3, 3] for t in me.touches])
        approach = (
            found.approach if isinstance(found, Choice) else gap_touch(ball, places, len(places), self._rng)
        )
        return np.array([*action_of(approach, ball), -1.0], dtype=np.float32)

    def _sure(self, me: Any) -> bool:
        belief, met = me.belief, sum(t.met for t in me.touches)
        if belief is None or met < self.least or belief.confidence < self.confidence:
            self._agreed = 0
            return False
        self._agreed = self._agreed + 1 if belief.decision == self._name else 1
        self._name = belief.decision
        return self._agreed >= self.confirmed


@dataclass
class EvenPolicy:
    """Of both environments: `random`, `grid` or `largest-gap`, which ask nothing of what is believed."""

    name: str = "largest-gap"
    seed: int = 0

    def __post_init__(self) -> None:
        self._rng = np.random.default_rng(self.seed)

    def __call__(self, env: Any) -> np.ndarray:
        """The next action; in `palpate/Identify-v0` one that never stops."""
        inside = env.unwrapped
        me = inside.toucher if isinstance(inside, ExploreEnv) else inside.identifier
        ball = me.around()
        places = np.array([t.pose[:3, 3] if t.met else t.approach.start[:3, 3] for t in me.touches])
        action = action_of(POLICY[self.name](ball, places, len(places), self._rng), ball)
        return action if isinstance(inside, ExploreEnv) else np.array([*action, -1.0], dtype=np.float32)
