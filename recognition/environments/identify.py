"""`palpate/Identify-v0`: say which object of a library it is, with few touches.

action: `Box(-1, 1, (7,))`, an approach as `actions` says; the seventh above 0: stop, and say the likeliest name
observation:
    belief    `Box(0, 1, (n + 1,))` probability of each object of the library, and last of none of them
    contacts, ball, touches  as in `palpate/Explore-v0`
reward: -`cost` for each touch; when stopped, 1 for the right name, -1 for a wrong one
terminated: when stopped; truncated: after `max_touches` touches, when nothing is said
info: `names`, `decision`, `confidence`, `met`, `device_seconds`; when stopped `answer` and `correct`

An approach that cannot be made, because the housing met something first, is replaced by one at the widest gap.
With `unknown` the object is, with that probability, none of the library's.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces

from exploration.planning.touching.lone_touch import Approach
from exploration.planning.ways.round_ball import Ball
from models import parts
from models.part import Part
from primitives.arrays import Floats
from primitives.errors import PalpateError
from recognition.config import ExploreOptions
from recognition.environments.actions import SIZE, approach_of
from recognition.environments.asked import (
    checked_action,
    library_of,
    require_between,
    require_no_rendering,
    require_touching,
)
from recognition.environments.explore import Observation, ball_row, contact_rows, touched_share
from recognition.identifying.hand import GuardedHand
from recognition.identifying.identify import Identifier, IdentifyConfig, Step
from recognition.identifying.learned import unfelt
from recognition.identifying.policies import gap_touch
from recognition.matching import Belief
from recognition.matching.next_touch.held import UNKNOWN
from recognition.running.simulation import guarded, load_world

_NEVER = 2.0  # a confidence that is never reached: whoever acts says when to stop


class IdentifyEnv(gymnasium.Env[Observation, np.ndarray]):
    """One object after another, each at a pose of its own."""

    metadata = {"render_modes": []}  # noqa: RUF012  as gymnasium has it

    def __init__(
        self,
        library: str | Path | Sequence[str] = ("block", "bracket", "cylinder", "flange", "hex_nut", "wedge"),
        sensor: str = "lts210",
        noise: float | None = 0.05,
        max_touches: int = 25,
        cost: float = 0.03,
        unknown: float = 0.0,
        render_mode: str | None = None,
    ) -> None:
        require_touching(sensor, noise, max_touches)
        require_between("cost", cost, 0.0)
        require_between("unknown", unknown, 0.0, 1.0)
        require_no_rendering(render_mode)
        self.render_mode = render_mode
        self.library = library_of(library)
        self.names = list(self.library)
        self.strangers = [name for name in parts.names() if name not in self.names]
        if unknown > 0 and not self.strangers:
            raise PalpateError("the library holds every built-in part, so none is unknown; give unknown=0")
        self.sensor, self.noise, self.max_touches = sensor, noise, max_touches
        self.cost, self.unknown = cost, unknown
        self.action_space = spaces.Box(-1.0, 1.0, (SIZE + 1,), np.float32)
        observed: Any = spaces.Dict(
            {
                "belief": spaces.Box(0.0, 1.0, (len(self.names) + 1,), np.float32),
                "contacts": spaces.Box(-2000.0, 2000.0, (512, 7), np.float32),
                "ball": spaces.Box(-2000.0, 2000.0, (4,), np.float32),
                "touches": spaces.Box(0.0, 1.0, (1,), np.float32),
            }
        )
        self.observation_space = observed

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """The object is found by the first touches; `options["part"]` names it, else it is drawn."""
        super().reset(seed=seed)
        strange = self.unknown > 0 and self.np_random.random() < self.unknown
        among = self.strangers if strange else self.names
        self.part = (options or {}).get("part") or among[int(self.np_random.integers(len(among)))]
        drawn = int(self.np_random.integers(2**31))
        told = ExploreOptions(self.part, sensors=(self.sensor,), noise=self.noise, seed=drawn)
        world = load_world(told, part=self._of_library())
        self.middle = world.box.mean(axis=0)
        self._action: np.ndarray | None = None
        config = IdentifyConfig(self._policy, _NEVER, 10 * self.max_touches)
        guard, rng = guarded(world, told, lambda guard, seen: None), np.random.default_rng(drawn)
        self.identifier = Identifier(GuardedHand(guard), self.library, world.box.ravel(), config, rng)
        self._steps: Iterator[Step] = self.identifier.run()
        step = next(self._steps, None)
        while step is not None and step.belief is None:
            step = next(self._steps, None)
        self._met, self._before = step is not None, guard.cost.touches
        return self._observed(), self._info()

    def step(self, action: np.ndarray) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """One touch, or the answer."""
        told = checked_action(action, SIZE + 1)
        if told[SIZE] > 0.0:
            answer = self.part if self.part in self.names else UNKNOWN
            info = self._info()
            right = info["decision"] == answer
            return (
                self._observed(),
                1.0 if right else -1.0,
                True,
                False,
                info | {"answer": answer, "correct": right},
            )
        self._action = told
        made = next(self._steps, None)
        self._met = made is not None and made.touch.met
        spent = made is None or self._made() >= self.max_touches
        return self._observed(), -self.cost, False, spent, self._info()

    def _of_library(self) -> Part | None:
        """The part as the library has it, with the units that its folder says."""
        if self.part not in self.names:
            return None
        return Part(self.part, self.library[self.part].solid, None)

    def _policy(self, ball: Ball, places: Floats, tried: int, rng: np.random.Generator) -> Approach:
        action, self._action = self._action, None
        return gap_touch(ball, places, tried, rng) if action is None else approach_of(action, ball)

    def _made(self) -> int:
        """Touches since the object was found."""
        return self.identifier.hand.cost.touches - self._before

    def _observed(self) -> Observation:
        me, told = self.identifier, self._belief().probabilities
        found = me.touches and any(t.met for t in me.touches)
        ball = me.around() if found else Ball(self.middle, 0.0)
        shares = [told.get(name, 0.0) for name in (*self.names, UNKNOWN)]
        return {
            "belief": np.clip(shares, 0.0, 1.0).astype(np.float32),
            "contacts": contact_rows(me.evidence.contacts, self.middle),
            "ball": ball_row(ball, self.middle),
            "touches": touched_share(self._made(), self.max_touches),
        }

    def _belief(self) -> Belief:
        """What is believed; before anything was met, the prior."""
        me = self.identifier
        return me.belief or unfelt(self.library, me.config.unknown)

    def _info(self) -> dict[str, Any]:
        belief = self._belief()
        return {
            "names": [*self.names, UNKNOWN],
            "decision": belief.decision,
            "confidence": belief.confidence,
            "met": self._met,
            "device_seconds": self.identifier.hand.cost.seconds,
        }
