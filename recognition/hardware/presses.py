"""The presses that a calibration needs, made by the stage on the artifact, or by hand where there is no stage.

The stage comes down on each place guarded, presses to a force, stands still while frames are read, and backs off.
The plate need not be level: presses on its flat tell its normal first.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import islice
from typing import Protocol

import numpy as np

from exploration.control.procedures.approach import approach, retreat
from exploration.devices.guard import Collision, Guard
from exploration.devices.serial_array import SerialArray
from exploration.sensing.calibrating.rest import mean_frame
from exploration.sensing.calibration import correct
from exploration.sensing.frame import TactileImage, TaxelFrame
from exploration.sensing.spec import SensorSpec
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.errors import PalpateError
from recognition.hardware.artifact import Artifact

FRAMES, AIR = 24, 60  # of one press, and in free air
COUNTS = {"flat": 10, "edge": 8, "step": 6, "ball": 12}
WORDS = {
    "flat": "a flat, larger than the pad; each time a little deeper, or tilted",
    "edge": "the flat's straight edge across the pad's middle; each time at another angle",
    "step": "the step across the pad's middle, until both its faces touch",
    "ball": "the ball",
}
_DOWN = np.diag([1.0, -1.0, -1.0])
_CLEAR = 40.0  # [mm] over the artifact, for going across
_BACK = 8.0  # [mm] before and behind a contact that is expected
_STILL = 0.1  # [s] before frames are read
_LEVELINGS = 3
_LEVEL_TURNS = (0.0, 2.0 * np.pi / 3.0, -2.0 * np.pi / 3.0)  # [rad]
_LEAN = 0.35  # of the nominal depth, by which the pad's rims may differ on the flat
_BALL_LEAN = 0.35  # [rad]
_SHARE = 0.5  # of the force limit, at most


@dataclass(frozen=True)
class Pressed:
    """One press."""

    frames: tuple[TaxelFrame, ...]
    world_from_flange: Floats | None = None  # (4, 4); None by hand


class Presses(Protocol):
    """Who presses."""

    def air(self) -> tuple[TaxelFrame, ...]:
        """Frames in free air."""
        ...

    def on(self, what: str) -> Iterator[Pressed]:
        """The presses on `flat`, `edge`, `step` or `ball`, those that could be made."""
        ...


class HandPresses:
    """A person presses the array; `ask` shows a line and waits."""

    def __init__(self, array: SerialArray, ask: Callable[[str], object]) -> None:
        self._array, self._ask = array, ask

    def air(self) -> tuple[TaxelFrame, ...]:
        """Frames in free air."""
        self._ask("leave the array untouched")
        return self._frames(AIR)

    def on(self, what: str) -> Iterator[Pressed]:
        """A person's presses; where the array sits on a flange, none can tell."""
        for k in range(COUNTS[what] if what != "ball" else 0):
            self._ask(f"{k + 1} of {COUNTS[what]}: press {WORDS[what]}, and hold still")
            yield Pressed(self._frames(FRAMES))

    def _frames(self, count: int) -> tuple[TaxelFrame, ...]:
        self._array.read()
        return tuple(self._array.read() for _ in range(count))


class StagePresses:
    """The stage presses, guarded."""

    def __init__(self, guard: Guard, spec: SensorSpec, artifact: Artifact, rng: np.random.Generator) -> None:
        self._guard, self._spec, self._artifact, self._rng = guard, spec, artifact, rng
        self._size = np.array(spec.array.size)
        stiff = spec.elastomer.stiffness
        self._flat_force = min(
            stiff * float(np.prod(self._size)) * spec.press_depth, _SHARE * guard.limits.force
        )
        ball = np.pi * stiff * artifact.ball_radius_mm * spec.press_depth**2
        self._ball_force = min(1.2 * ball, _SHARE * guard.limits.force)
        self._level, self._up = (
            _DOWN,
            -_DOWN[:, 2],
        )  # a pad's attitude flat on the flat, and the flat's normal

    def air(self) -> tuple[TaxelFrame, ...]:
        """Frames in free air, high over the flat."""
        self._guard.go_to(self._above(se3.pose(_DOWN, self._artifact.flat_mm)))
        return self._frames(AIR)

    def on(self, what: str) -> Iterator[Pressed]:
        """The presses on one thing; attitudes that the stage cannot take are left out."""
        if what == "flat":
            self._find_level()
        made = 0
        for target, force in islice(self._targets(what), 3 * COUNTS[what]):
            pressed = self._press(target, force)
            if pressed is not None:
                made += 1
                yield pressed
            if made == COUNTS[what]:
                break
        self._guard.go_to(self._above(self._guard.world_from_sensor))
        if not made:
            raise PalpateError(f"nothing was felt at {what}_mm; say in [artifact] where it is")

    def _targets(self, what: str) -> Iterator[tuple[Floats, float]]:
        """(4, 4) world_from_sensor at first contact, and the force to press to, again and again others."""
        told, rng, size = self._artifact, self._rng, self._size
        depth = self._spec.press_depth
        while True:
            if what == "ball":
                yield self._ball_target(), self._ball_force
                continue
            turn, share = rng.uniform(-np.pi, np.pi), rng.uniform(0.4, 1.0)
            place, lean = np.array(getattr(told, f"{what}_mm"), dtype=float), 0.0
            if what == "flat":
                lean = _LEAN * depth / (0.5 * float(size.max()))
                place[:2] += rng.uniform(-3.0, 3.0, 2)
                force = share * self._flat_force
            else:
                line = np.radians(getattr(told, f"{what}_deg"))
                place[:2] += rng.uniform(-0.15, 0.15) * size.min() * np.array([-np.sin(line), np.cos(line)])
                force = (0.5 if what == "edge" else 0.8) * self._flat_force
            tilt = se3.rotation_exp([*rng.uniform(-lean, lean, 2), 0.0]) if lean else np.eye(3)
            yield se3.pose(tilt @ se3.rotation_exp(turn * self._up) @ self._level, place), force

    def _ball_target(self) -> Floats:
        rng, told = self._rng, self._artifact
        lean = se3.rotation_exp([*rng.uniform(-_BALL_LEAN, _BALL_LEAN, 2), 0.0])
        turn = lean @ _DOWN @ se3.rotation_exp([0.0, 0.0, rng.uniform(-np.pi, np.pi)])
        off = np.array([*(rng.uniform(-0.2, 0.2, 2) * self._size), -told.ball_radius_mm])
        return se3.pose(turn, np.array(told.ball_mm) + turn @ off)

    def _find_level(self) -> None:
        """Lay the pad flat at several turns: for its own normal m and the flat's n, R_i m = -n at each.

        n and m maximize |sum R_i m|: m is the first right singular vector of that sum (our derivation).
        """
        turns = [se3.rotation_exp([0.0, 0.0, turn]) @ _DOWN for turn in _LEVEL_TURNS]
        laid = [level for turn in turns if (level := self._laid_flat(turn)) is not None]
        if laid:
            total = np.sum(laid, axis=0)
            own = np.linalg.svd(total)[2][0]
            own *= np.sign(own[2])
            self._up = -(total @ own) / float(np.linalg.norm(total @ own))
            self._level = laid[0]

    def _laid_flat(self, attitude: Floats) -> Floats | None:
        """(3, 3) the attitude near a given one in which the flat is felt to be level."""
        for _ in range(_LEVELINGS):
            pressed = self._press(se3.pose(attitude, self._artifact.flat_mm), 0.5 * self._flat_force)
            if pressed is None:
                return None
            felt = correct(
                mean_frame(pressed.frames), self._guard.calibrations[self._guard.active], self._spec.array
            )
            attitude = attitude @ _turning(np.array([0.0, 0.0, 1.0]), -_normal(felt))
        return attitude

    def _press(self, target: Floats, force: float) -> Pressed | None:
        """One guarded press; None where the stage cannot take the attitude, or nothing was met."""
        guard = self._guard
        before = target @ se3.pose(translation=[0.0, 0.0, -_BACK])
        try:
            guard.go_to(self._above(before))
            guard.go_to(before)
        except Collision:
            return None
        felt = approach(guard, target[:3, 2], 2.0 * _BACK, force)
        guard.hold(max(1, round(_STILL / guard.period)))
        frames = self._frames(FRAMES) if felt else ()
        flange = guard.stage.pose()
        retreat(guard, _BACK)
        return Pressed(frames, flange) if frames else None

    def _frames(self, count: int) -> tuple[TaxelFrame, ...]:
        return tuple(self._guard.hold().frame for _ in range(count))

    def _above(self, place: Floats) -> Floats:
        """The same attitude, high over the artifact."""
        high = place.copy()
        high[2, 3] = max(self._artifact.flat_mm[2], self._artifact.ball_mm[2]) + _CLEAR
        return high


def _normal(image: TactileImage) -> Floats:
    """(3,) outward normal of the flat that is pressed, in the sensor's frame."""
    x, y = np.meshgrid(image.array.x, image.array.y)
    touched = np.isfinite(image.sigma) & (image.depth > 0.3 * np.max(image.depth[np.isfinite(image.sigma)]))
    basis = np.stack([np.ones(touched.sum()), x[touched], y[touched]], axis=1)
    _, a, b = np.linalg.lstsq(basis, image.depth[touched], rcond=None)[0]
    return np.asarray(np.array([-a, -b, -1.0]) / np.sqrt(1.0 + a * a + b * b))


def _turning(before: Floats, after: Floats) -> Floats:
    """(3, 3) the shortest turn that brings one unit vector to another."""
    axis = np.cross(before, after)
    sine = float(np.linalg.norm(axis))
    angle = float(np.arctan2(sine, before @ after))
    return np.asarray(se3.rotation_exp(axis * (angle / sine) if sine > 1e-12 else axis))
