"""From a wish, a twist or a goal, to the jogs that are sent next: short, and no further ahead than needed.

What is sent ahead is what would still be done if everything above died, so it reaches only to a horizon: what the
controller needs to keep its speed, v / (2 a) [s], and a margin, which shrinks at speed, so that all of it, braking
included, is over in time.  A twist is old after a moment and then counts as none.  The plan keeps joint positions
twice: as meant, and as the controller rounds them, so that rounding does not add up.
"""

from collections import deque
from dataclasses import dataclass
from math import hypot

import numpy as np

from exploration.devices import grbl_text
from exploration.devices.guard import Collision
from exploration.devices.kinematic_chain import KinematicChain
from exploration.devices.protocols import StageLimits
from primitives import pose as se3
from primitives.arrays import Floats

_TURN = 0.04  # [rad] of one jog of a straight move
_LAG = 0.008  # [s] by which a report may be old
_THERE, _THERE_TURN = 0.05, 2e-3  # [mm], [rad] to which a goal is reached
_SAME = 0.002  # [mm] or [deg] to which a report tells where the stage is


@dataclass(frozen=True)
class StreamConfig:
    """How motion is cut into jogs, and how long the controller may be silent."""

    margin: float = 0.02  # [s] of motion that is sent ahead at most, beyond what the speed needs
    least: float = 0.005  # [s] of the same at any speed
    over: float = 0.043  # [s] in which what was sent is over, where the speed allows that
    shortest: float = 0.008  # [s] of one jog
    stale: float = 0.15  # [s] after which a twist counts as none
    longest: float = 0.01  # [s] of one jog of a straight move
    ask: float = 0.004  # [s] between two questions for a report
    deaf: float = 0.1  # [s] without a report, after which nothing is sent
    dumb: float = 3.0  # [s] of listening in vain, after which the stage is lost
    again: float = 0.03  # [s] between two cancels
    obeys: float = 0.5  # [s] of canceling in vain, after which the controller is reset


@dataclass(frozen=True)
class Jog:
    """One line, and where it leads."""

    line: str  # empty where nothing moves by as much as the controller resolves
    joints: Floats  # (n,) as meant
    sent: Floats  # (n,) as the controller rounds them
    seconds: float
    of_way: bool


class JogPlan:
    """What is wished for, what was sent, and what comes next."""

    def __init__(self, chain: KinematicChain, limits: StageLimits, config: StreamConfig) -> None:
        self._chain, self._limits, self._config = chain, limits, config
        self._letters = "".join(axis.letter for axis in chain.axes)
        self._planned: Floats = np.zeros(len(chain.axes))
        self._sent = self._planned
        self._twist, self._speed, self._since = np.zeros(6), 0.0, 0.0  # the speed [mm/s]
        self._way: deque[tuple[Floats, float]] = deque()  # joint positions, and seconds to them
        self.goal: Floats | None = None
        self.until = 0.0  # [s] when what was sent will have been done

    @property
    def leads_to(self) -> Floats:
        """(n,) [mm, rad] where all that was sent leads."""
        return self._planned

    @property
    def twisting(self) -> bool:
        """Whether a twist is wished for."""
        return bool(self._twist.any())

    def follow(self, twist: Floats, now: float) -> None:
        """Wish for a (6,) twist in the flange frame."""
        self.drop()
        self._twist, self._speed, self._since = twist, hypot(*twist[:3].tolist()), now

    def head_for(self, goal: Floats) -> None:
        """Wish for a straight move; one that the axes cannot take is refused, and the wish stays as it was."""
        way = self._straight(goal)
        self._twist, self.goal, self._way = np.zeros(6), goal, way

    def resume(self) -> None:
        """Plan the way to the goal again, from where the stage was held."""
        if self.goal is not None:
            self._way = self._straight(self.goal)

    def forget_twist(self) -> None:
        """No twist is wished for any more; a goal stays."""
        self._twist = np.zeros(6)

    def drop(self) -> None:
        """Nothing is wished for any more."""
        self._twist, self.goal = np.zeros(6), None
        self._way.clear()

    def stands(self, here: Floats) -> None:
        """The stage stands, its whole way sent: the goal is reached, or what a lost line left is planned."""
        if self.goal is None or self._way:
            return
        off = se3.log(se3.inverse(self._chain.pose(here)) @ self.goal)
        if float(np.linalg.norm(off[:3])) < _THERE and float(np.linalg.norm(off[3:])) < _THERE_TURN:
            self.goal = None
        else:
            self._way = self._straight(self.goal)

    def resync(self, here: Floats) -> None:
        """What was sent counts for nothing any more: plan from where the stage is."""
        if float(np.abs((here - self._sent) * self._chain.to_wire).max()) > _SAME:
            self._planned = here
        self._sent = here

    def strayed(self, here: Floats) -> bool:
        """Whether the stage is farther from where it was sent than anything sent ahead explains."""
        room = (2.0 * self._ahead() + 0.1) * self._chain.speed
        return bool((np.abs(here - self._sent) > 2.0 * room + 1.0 / self._chain.to_wire).any())

    def due(self, now: float, here: Floats) -> Jog | None:
        """What to send now, the stage being at `here`; None while enough is on its way."""
        ahead = self._ahead()
        if self.until - now >= ahead or not (self._way or self._twist.any()):
            return None
        if float((np.abs(self._planned - here) / self._chain.speed).max()) >= ahead + _LAG:
            return None
        of_way = bool(self._way)
        if of_way:
            joints, seconds = self._way[0]
        elif now - self._since < self._config.stale:
            seconds = self._config.shortest
            goal = self._chain.pose(self._planned) @ se3.exp(self._twist * seconds)
            joints = self._chain.reach(goal, self._planned, 6).q
        else:
            return None
        seconds = max(seconds, float((np.abs(joints - self._planned) / self._chain.speed).max()))
        wire = np.round((joints - self._sent) * self._chain.to_wire, 3)
        feed = float(np.linalg.norm(wire)) / seconds * 60.0
        line = grbl_text.jog(self._letters, wire.tolist(), feed)
        sent = self._sent + wire / self._chain.to_wire if line else self._sent
        return Jog(line, joints, sent, seconds, of_way)

    def took(self, jog: Jog, now: float) -> None:
        """A jog was sent."""
        if jog.of_way:
            self._way.popleft()
        self._planned, self._sent = jog.joints, jog.sent
        self.until = (self.until if self.until > now else now + self._lag()) + jog.seconds

    def _ahead(self) -> float:
        """[s] of motion to send ahead."""
        lag, config = self._lag(), self._config
        left = config.over - 2.0 * lag - config.longest - _LAG
        return lag + max(config.least, min(config.margin, left))

    def _lag(self) -> float:
        """[s] that gaining speed costs, and losing it: v / (2 a)."""
        speed = self._limits.speed if self.goal is not None else self._speed
        return speed / (2.0 * self._limits.acceleration)

    def _straight(self, goal: Floats) -> deque[tuple[Floats, float]]:
        """The joint positions of a straight way from where everything sent leads."""
        start = self._chain.pose(self._planned)
        line = goal[:3, 3] - start[:3, 3]
        turn = se3.rotation_log(goal[:3, :3] @ start[:3, :3].T)
        length, angle = float(np.linalg.norm(line)), float(np.linalg.norm(turn))
        seconds = max(length / self._limits.speed, angle / self._limits.turn_speed)
        count = max(1, int(np.ceil(max(seconds / self._config.longest, angle / _TURN))))
        way: deque[tuple[Floats, float]] = deque()
        q = self._planned
        for k in range(1, count + 1):
            between = np.eye(4)
            between[:3, :3] = se3.rotation_exp(turn * k / count) @ start[:3, :3]
            between[:3, 3] = start[:3, 3] + line * k / count
            reached = self._chain.reach(between, q)
            if not reached and k == count:
                raise Collision(
                    f"the stage cannot take that pose ({reached.off:.1f} mm, "
                    f"{np.degrees(reached.turned):.1f} deg off); "
                    "what lies there stays unknown"
                )
            q = reached.q
            way.append((q, seconds / count))
        return way
