"""`palpate/Explore-v0`: feel as much of an unknown object as possible with few touches.

action: `Box(-1, 1, (6,))`, an approach as `actions` says
observation:
    contacts  `Box((512, 7))` x, y, z [mm] from the workspace's middle, the normal (0 where not felt), 1 where the
              row is filled; the newest first
    ball      `Box((4,))` center [mm], as above, and radius of the ball that actions refer to
    touches   `Box((1,))` touches made, as a share of those allowed
reward: the share of the object's surface that this touch brought within `reach_mm` of a contact, less `cost`
terminated: when `enough` of the surface is felt; truncated: after `max_touches` touches since it was found
info: `covered`, `met`, `device_seconds`, `part`

The reward is the evaluator's, who knows the object; observations hold what was felt, and nothing else.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from scipy.spatial import cKDTree

from primitives.arrays import Floats
from recognition.config import ExploreOptions
from recognition.environments.actions import SIZE, approach_of
from recognition.environments.asked import (
    checked_action,
    part_names,
    require_between,
    require_no_rendering,
    require_touching,
)
from recognition.environments.toucher import Toucher
from recognition.running.simulation import guarded, load_world
from recognition.truth import LabeledFaces, TruthOptions, sample_surface

_FAR = 2000.0  # [mm] of anything from the workspace's middle
_ROWS = 512  # contacts that are observed
_SAMPLES = 3000  # of the object's surface
Observation = dict[str, np.ndarray]


class ExploreEnv(gymnasium.Env[Observation, np.ndarray]):
    """One object after another, each at a pose of its own."""

    metadata = {"render_modes": []}  # noqa: RUF012  as gymnasium has it

    def __init__(
        self,
        part: str | Sequence[str] = ("block", "bracket", "cylinder", "flange", "wedge"),
        sensor: str = "lts210",
        noise: float | None = 0.05,
        max_touches: int = 40,
        reach_mm: float = 6.0,
        cost: float = 0.005,
        enough: float = 0.95,
        largest_mm: float = 75.0,
        render_mode: str | None = None,
    ) -> None:
        self.parts = part_names(part)
        require_touching(sensor, noise, max_touches)
        require_between("reach_mm", reach_mm, 0.0)
        require_between("cost", cost, 0.0)
        require_between("enough", enough, 0.0, 1.0)
        require_between("largest_mm", largest_mm, 1.0)
        require_no_rendering(render_mode)
        self.render_mode = render_mode
        self.sensor, self.noise, self.max_touches = sensor, noise, max_touches
        self.reach, self.cost, self.enough, self.largest = reach_mm, cost, enough, largest_mm
        self.action_space = spaces.Box(-1.0, 1.0, (SIZE,), np.float32)
        observed: Any = spaces.Dict(
            {
                "contacts": spaces.Box(-_FAR, _FAR, (_ROWS, 7), np.float32),
                "ball": spaces.Box(-_FAR, _FAR, (4,), np.float32),
                "touches": spaces.Box(0.0, 1.0, (1,), np.float32),
            }
        )
        self.observation_space = observed

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """The object is found by the first touch; `options["part"]` names it, else it is drawn."""
        super().reset(seed=seed)
        self.part = (options or {}).get("part") or self.parts[int(self.np_random.integers(len(self.parts)))]
        told = ExploreOptions(
            self.part, sensors=(self.sensor,), noise=self.noise, seed=int(self.np_random.integers(2**31))
        )
        world = load_world(told)
        self.middle = world.box.mean(axis=0)
        self.toucher = Toucher(
            guarded(world, told, lambda guard, seen: None), world.box.ravel(), self.largest
        )
        self.surface, _ = sample_surface(
            world.solid, TruthOptions(samples=_SAMPLES), LabeledFaces.of(world.solid)
        )
        self.toucher.find()
        self._before = self.toucher.guard.cost.touches
        self.covered = self._covered()
        return self._observed(), self._info(True)

    def step(self, action: np.ndarray) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """One touch."""
        made = self.toucher.touch(approach_of(checked_action(action, SIZE), self.toucher.around()))
        before, self.covered = self.covered, self._covered()
        reward = self.covered - before - self.cost
        spent = self._made() >= self.max_touches
        info = self._info(made is not None and made.met)
        return self._observed(), float(reward), self.covered >= self.enough, spent, info

    def _covered(self) -> float:
        """The share of the object's area that was felt."""
        felt = self.toucher.contacts.points
        if not len(felt):
            return 0.0
        away, _ = cKDTree(felt).query(self.surface.points)
        return self.surface.mean((np.asarray(away) < self.reach).astype(float))

    def _made(self) -> int:
        """Touches since the object was found."""
        return self.toucher.guard.cost.touches - self._before

    def _observed(self) -> Observation:
        return {
            "contacts": contact_rows(self.toucher.contacts, self.middle),
            "ball": ball_row(self.toucher.around(), self.middle),
            "touches": touched_share(self._made(), self.max_touches),
        }

    def _info(self, met: bool) -> dict[str, Any]:
        return {
            "covered": self.covered,
            "met": met,
            "device_seconds": self.toucher.guard.cost.seconds,
            "part": self.part,
        }


def contact_rows(contacts: Any, middle: Floats) -> np.ndarray:
    """(512, 7) the newest contacts first: place, normal, 1 where filled."""
    out = np.zeros((_ROWS, 7), dtype=np.float32)
    count = min(len(contacts), _ROWS)
    newest = slice(len(contacts) - count, None)
    rows = np.column_stack([contacts.points[newest] - middle, np.nan_to_num(contacts.normals[newest])])
    out[:count, :6] = np.clip(rows[::-1], -_FAR, _FAR)
    out[:count, 6] = 1.0
    return out


def ball_row(ball: Any, middle: Floats) -> np.ndarray:
    """(4,) center and radius."""
    return np.asarray(np.clip([*(ball.center - middle), ball.radius], -_FAR, _FAR), dtype=np.float32)


def touched_share(touches: int, most: int) -> np.ndarray:
    """(1,) of the touches that are allowed."""
    return np.array([min(1.0, touches / most)], dtype=np.float32)
