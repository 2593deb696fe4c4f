"""A stage's axes, from its base to its flange: joint positions to a pose, and back.

    base_from_flange(q) = prod_i ( fixed_i . motion_i(q_i) ) . tool

with a shift along or a turn about each axis's direction.  The way back is damped least squares on the
pose's error, q += J^T (J J^T + l^2)^-1 e, with lengths and angles on one scale; a pose that the axes
cannot take leaves a rest, and the caller sees how much.  Positions are mm and rad inside, mm and degrees
on the controller's wire.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.devices.chain_kernels import reach, walk
from primitives import pose as se3
from primitives.arrays import Floats

_ARM = 50.0  # [mm] that one radian counts as
_DAMPING = 1e-3
_TURNS = 100.0  # [rad] that a gantry's turning axes may wind up, where nobody told their limits
_WAYS = {"X": (1.0, 0.0, 0.0), "Y": (0.0, 1.0, 0.0), "Z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class Axis:
    """One axis of a stage."""

    letter: str
    turns: bool
    direction: tuple[float, float, float] = (1.0, 0.0, 0.0)
    least: float = -1e9  # [mm] or [rad]
    most: float = 1e9
    speed: float = 100.0  # [mm/s] or [rad/s]
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)  # [mm] from the axis before it


@dataclass(frozen=True)
class Reached:
    """Joint positions, and what they leave of the pose that was asked."""

    q: Floats  # (n,)
    off: float  # [mm]
    turned: float  # [rad]

    def __bool__(self) -> bool:
        return self.off < 0.02 and self.turned < 1e-3


class KinematicChain:
    """Three to six axes."""

    def __init__(self, axes: Sequence[Axis], tool: Floats | None = None) -> None:
        self.axes = tuple(axes)
        self.tool = np.eye(4) if tool is None else np.asarray(tool, dtype=float)
        self.turns = np.array([axis.turns for axis in axes])
        self.least = np.array([axis.least for axis in axes])
        self.most = np.array([axis.most for axis in axes])
        self.speed = np.array([axis.speed for axis in axes])
        self.to_wire = np.where(self.turns, 180.0 / np.pi, 1.0)
        self._ways = np.array([axis.direction for axis in axes], dtype=float)
        self._ways /= np.linalg.norm(self._ways, axis=1, keepdims=True)
        self._offsets = np.array([axis.offset for axis in axes], dtype=float)
        self._limits = np.stack([self.least, self.most])

    def pose(self, q: Floats) -> Floats:
        """(4, 4) base_from_flange."""
        at, _ = walk(np.asarray(q, dtype=float), self._offsets, self._ways, self.turns, self.tool)
        return np.asarray(at)

    def from_wire(self, numbers: Sequence[float], order: Sequence[int]) -> Floats:
        """(n,) [mm, rad] joint positions from a controller's numbers [mm, deg], the k-th of axis order[k]."""
        joints = np.zeros(len(self.axes))
        joints[list(order)] = numbers
        return np.asarray(joints / self.to_wire)

    def reach(self, goal: Floats, near: Floats, steps: int = 40) -> Reached:
        """Joint positions near `near` [mm, rad] that bring the flange to a (4, 4) pose, within limits."""
        start = np.array(near, dtype=float)
        geometry = (self._offsets, self._ways, self.turns, self.tool)
        q, off, turned = reach(
            np.ascontiguousarray(goal), start, *geometry, self._limits, _ARM, _DAMPING, steps
        )
        return Reached(q, float(off), float(turned))

    @staticmethod
    def arm(ways: str, lengths: Sequence[float], most: float = 3.0, speed: float = 2.0) -> "KinematicChain":
        """Turning joints 1, 2, ... one above the other: the way of each, X, Y or Z, its length over the last [mm].

        All turn by `most` [rad] either way at most, at `speed` [rad/s]; at zero the arm stands upright.
        """
        joints = enumerate(zip(ways, lengths, strict=True), 1)
        return KinematicChain(
            [Axis(str(k), True, _WAYS[way], -most, most, speed, (0.0, 0.0, up)) for k, (way, up) in joints]
        )

    @staticmethod
    def gantry(
        letters: str = "XYZABC", travel: float = 700.0, speed: float = 150.0, turn_speed: float = 6.0
    ) -> "KinematicChain":
        """Three linear axes carry up to three turning ones (C about z, B about y, A about x); zero looks down."""
        turn = {"A": _WAYS["X"], "B": _WAYS["Y"], "C": _WAYS["Z"]}
        axes = [Axis(c, False, _WAYS[c], -travel, travel, speed) for c in letters if c in _WAYS]
        axes += [Axis(c, True, turn[c], -_TURNS, _TURNS, turn_speed) for c in "CBA" if c in letters]
        return KinematicChain(axes, se3.pose(np.diag([1.0, -1.0, -1.0])))
