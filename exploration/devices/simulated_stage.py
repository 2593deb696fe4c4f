"""A simulated stage: a double integrator in the world frame, within speed and acceleration limits.

A twist is approached at the acceleration limit.  `go_to` first brakes, then runs a straight line and a slerp on
one trapezoid that keeps the speed and acceleration of both within limits (see `stage_motion`).
"""

from collections import deque
from dataclasses import dataclass

import numpy as np

from exploration.devices.protocols import StageEvent, StageLimits, checked_twist
from exploration.devices.stage_motion import follow, run
from exploration.devices.stage_trail import StageTrail
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.pose import exp, rotation_log

_STEP = 0.005  # [s] between the poses that are remembered


@dataclass(frozen=True)
class PoseNoise:
    """Errors of the stage's encoders, 1 sigma per axis."""

    white: float = 0.0  # [mm] fresh on every reading
    contact: float = 0.0  # [mm] one draw for each contact
    white_turn: float = 0.0  # [rad]
    contact_turn: float = 0.0  # [rad]

    def draw(self, linear: float, angular: float, rng: np.random.Generator) -> Floats:
        """A small (4, 4) motion."""
        return exp(rng.standard_normal(6) * np.repeat([linear, angular], 3))


@dataclass(frozen=True)
class _Move:
    """A trapezoid from one pose to another."""

    start: Floats
    path: Floats  # (6,) [mm, rad] in the world frame
    began: float
    speed: float  # [1/s] of s in 0..1
    acceleration: float  # [1/s^2]


class SimulatedStage:
    """A stage on a simulated clock; only the arrays that it carries advance it."""

    def __init__(
        self,
        start: Floats,
        rng: np.random.Generator,
        limits: StageLimits | None = None,
        noise: PoseNoise | None = None,
        latency: float = 0.0,
    ) -> None:
        self._limits = limits or StageLimits()
        lim = self._limits
        self._bounds = np.array([lim.speed, lim.turn_speed, lim.acceleration, lim.turn_acceleration])
        self._noise = noise or PoseNoise()
        self._white = np.repeat([self._noise.white, self._noise.white_turn], 3)
        self._errs = bool(self._white.any())
        self._rng = rng
        self._latency = latency
        self._time = 0.0
        self._true = np.array(start, dtype=float)
        self._velocity = np.zeros(6)
        self._twist = np.zeros(6)
        self._goal: Floats | None = None
        self._move: _Move | None = None
        self._commands: deque[tuple[float, str, Floats]] = deque()
        self._trail = StageTrail(0.0, self._true)
        self._bias = np.eye(4)
        self._events: list[StageEvent] = []

    @property
    def limits(self) -> StageLimits:
        """What it can do."""
        return self._limits

    @property
    def moving(self) -> bool:
        """Whether a `go_to` is under way."""
        pending = bool(self._commands) and self._commands[-1][1] == "go_to"
        return pending or self._goal is not None or self._move is not None

    def pose(self) -> Floats:
        """(4, 4) world_from_flange as the encoders say."""
        where = self._true @ self._bias
        return where @ exp(self._white * self._rng.standard_normal(6)) if self._errs else where

    def move(self, twist: Floats) -> None:
        """Follow a (6,) twist in the flange frame until told otherwise."""
        self._commands.append((self._time + self._latency, "move", checked_twist(twist)))
        self._obey()

    def go_to(self, world_from_flange: Floats) -> None:
        """Start a straight move to a pose."""
        goal = np.array(world_from_flange, dtype=float)
        if goal.shape != (4, 4) or not np.isfinite(goal).all():
            raise PalpateError("a goal is a finite 4x4 pose")
        self._commands.append((self._time + self._latency, "go_to", goal))
        self._obey()

    def stop(self) -> None:
        """Come to rest at the acceleration limit."""
        self.move(np.zeros(6))

    @property
    def held(self) -> bool:
        """No: no frame stays away here."""
        return False

    def events(self) -> tuple[StageEvent, ...]:
        """What the drives have noticed since last asked."""
        found, self._events = tuple(self._events), []
        return found

    def _obey(self) -> None:
        while self._commands and self._commands[0][0] <= self._time + 1e-12:
            _, kind, value = self._commands.popleft()
            self._move = None
            self._twist = value if kind == "move" else np.zeros(6)
            self._goal = value if kind == "go_to" else None

    def _advance(self, until: float) -> None:
        while self._time < until - 1e-12:
            self._obey()
            step = min(_STEP, until - self._time)
            if self._commands:
                step = min(step, max(self._commands[0][0] - self._time, 1e-6))
            self._true = self._true.copy()
            self._integrate(step)
            self._trail.add(self._time, self._true)

    def _integrate(self, dt: float) -> None:
        if self._goal is not None and not self._velocity.any():
            self._plan(self._goal)
        self._time += dt
        move = self._move
        if move is None:
            follow(self._true, self._velocity, self._twist, self._bounds, dt)
        elif run(
            self._true,
            self._velocity,
            move.start,
            move.path,
            self._time - move.began,
            move.speed,
            move.acceleration,
        ):
            self._move = None

    def _plan(self, goal: Floats) -> None:
        self._goal = None
        line = goal[:3, 3] - self._true[:3, 3]
        turn = rotation_log(goal[:3, :3] @ self._true[:3, :3].T)
        length, angle = float(np.linalg.norm(line)), float(np.linalg.norm(turn))
        if length < 1e-9 and angle < 1e-12:
            return
        lim = self._limits
        speed = min(lim.speed / max(length, 1e-12), lim.turn_speed / max(angle, 1e-12))
        acceleration = min(lim.acceleration / max(length, 1e-12), lim.turn_acceleration / max(angle, 1e-12))
        self._move = _Move(self._true.copy(), np.concatenate([line, turn]), self._time, speed, acceleration)

    def _touch(self) -> None:
        """A contact begins: draw its constant error."""
        n = self._noise
        if n.contact or n.contact_turn:
            self._bias = n.draw(n.contact, n.contact_turn, self._rng)
