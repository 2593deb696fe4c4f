"""Touch, match, choose: until it is sure which object it is, or nothing more can be told.

    find the object -> touch -> Evidence -> match() -> Belief -> the next approach -> touch -> ...

A generator, as exploring is: whoever runs it pulls, watches and stops it.  It sees the guard and the library, and
never the object.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from exploration.control.procedures.approach import retreat
from exploration.devices.guard import Collision, Guard, OverPress
from exploration.planning.lone_touch import Approach, LoneTouch, joined, touch_once
from exploration.planning.round_ball import Ball, way_round
from exploration.planning.search import sweeps
from models.library import Library
from primitives.arrays import Floats, frozen
from primitives.evidence import Contacts
from recognition.identifying.bounds import believed_ball, felt_ball
from recognition.identifying.placed import is_placed
from recognition.identifying.policies import POLICY, Policy, gap_touch
from recognition.identifying.untouched import swept, weighed
from recognition.matching import Belief, Evidence, Prior, match
from recognition.matching.belief import UNKNOWN
from recognition.matching.next_touch.choose import Choice, choose

Announce = Callable[[str, Mapping[str, object]], None]


@dataclass(frozen=True)
class IdentifyConfig:
    """When to stop, and how far away to keep."""

    policy: str | Policy = "information"
    confidence: float = 0.95
    max_touches: int = 40
    unknown: float = 0.1  # prior probability of none of these
    least: int = 4  # touches that met something, before which nothing is sure
    confirmed: int = 2  # touches in a row, after each of which the same name is sure enough
    bounding: int = 4  # touches with normals, from which swept space tells poses apart
    blind: int = 1  # touches that met something, before which the widest gap is touched
    misses: int = 2  # touches in a row without a contact, after which belief is not asked where to touch
    idle: int = 3  # touches in a row that were chosen for want of one that tells
    starts: int = 40  # hypotheses that are tried again after the next touch
    made: float = 0.12  # [mm] by which an object differs from its model
    made_angle: float = 0.02  # [rad] likewise


@dataclass(frozen=True)
class Step:
    """One touch, and what is believed after it."""

    touch: LoneTouch
    belief: Belief | None  # None while nothing was met
    choice: Choice | None  # why it was touched there; None where the policy asks nothing
    seconds: float  # [s] of the device until now

    @property
    def entropy(self) -> float | None:
        """[bits] over the names, `unknown` among them."""
        return None if self.belief is None else self.belief.entropy_bits


@dataclass
class Identifier:
    """One identification; `evidence`, `belief` and `ended` are read whenever `run` yields."""

    guard: Guard
    library: Library
    box: Floats  # (6,) workspace [mm]
    config: IdentifyConfig = field(default_factory=IdentifyConfig)
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))
    announce: Announce = lambda kind, detail: None
    touches: list[LoneTouch] = field(default_factory=list)
    belief: Belief | None = None
    ended: str = ""
    warnings: list[str] = field(default_factory=list)
    _last: LoneTouch | None = None
    _idle: int = 0
    _agreed: int = 0
    _before: str = ""

    def run(self) -> Iterator[Step]:
        """Touch and match, one touch at a time."""
        for touch in self._find():
            yield self._learn(touch, None)
        if self.belief is None:
            self.ended = self.ended or "nothing was found in the workspace"
            return
        while not self.ended:
            ball = self.around()
            self._leave()
            approach, choice = self._next(ball)
            if self.ended:
                return
            made = self._touch(approach, ball)
            if made is not None:
                yield self._learn(made, choice)

    @property
    def evidence(self) -> Evidence:
        """All that was felt."""
        met = [t for t in self.touches if t.met]
        contacts = _as_modeled(Contacts.concatenate([t.contacts for t in met]), self.config)
        traces = tuple(trace for t in met for trace in t.edges)
        held_still = sum(bool(t.contacts.has_normal.any()) for t in met) >= self.config.bounding
        return Evidence(contacts, traces, joined([t.free for t in self.touches]) if held_still else None)

    def ball(self) -> Ball:
        """Holds the object, as far as is believed."""
        met = len({t.touch for t in self.touches if t.met})
        return believed_ball(self.evidence.contacts, met, self.belief, self.library, self._pad)

    def around(self) -> Ball:
        """The ball that the next approach begins outside of."""
        if self._missed() < self.config.misses:
            return self.ball()
        return felt_ball(self.evidence.contacts, self.library, self._pad)

    def _missed(self) -> int:
        """How many touches there were since one that told of a contact."""
        told = [bool(len(t.contacts)) for t in reversed(self.touches)]
        return told.index(True) if True in told else len(told)

    @property
    def _pad(self) -> tuple[float, float]:
        return self.guard.sensor.array.size

    def _find(self) -> Iterator[LoneTouch]:
        """Sweeps through the workspace, from its middle outward, until one meets something."""
        for start, end in sweeps(self.box, self._pad):
            if self._spent():
                return
            try:
                self.guard.go_to(start)
                length = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))
                touch = touch_once(self.guard, Approach(start, length))
            except (OverPress, Collision) as error:
                self.warnings.append(str(error))
                self.guard.go_to(start)
                continue
            yield touch
            if touch.met and len(touch.contacts):
                return
            self._leave()

    def _spent(self) -> bool:
        if self.guard.cost.touches >= self.config.max_touches:
            self.ended = "budget"
        return bool(self.ended)

    def _learn(self, touch: LoneTouch, choice: Choice | None) -> Step:
        self._last = touch
        self.touches.append(touch)
        if len(self.evidence.contacts):
            starts = [] if self.belief is None else [(h.name, h.pose) for h in self.belief.hypotheses]
            self.belief = match(
                self.evidence, self.library, self._prior(), self.config.unknown, starts[: self.config.starts]
            )
            cells = np.concatenate([t.untouched for t in self.touches])
            missed = [t.free for t in self.touches if not t.met]
            self.belief = weighed(self.belief, self.library, cells)
            self.belief = swept(self.belief, self.library, joined(missed))
        self.announce("touch", {"number": touch.touch, "felt": touch.note, "met": touch.met})
        self._judge()
        return Step(touch, self.belief, choice, self.guard.cost.seconds)

    def _prior(self) -> Prior:
        low, high = self.box[:3], self.box[3:]
        return Prior(0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low)))

    def _judge(self) -> None:
        """Whether it is sure."""
        met = sum(t.met for t in self.touches)
        if self.belief is None or met < self.config.least:
            return
        name = self.belief.decision
        self._agreed = self._agreed + 1 if name == self._before else 1
        self._before = name
        if self.belief.confidence < self.config.confidence:
            self._agreed = 0
        if self._agreed >= self.config.confirmed and (
            name == UNKNOWN or is_placed(self.belief, self.library[name], self.config.confidence)
        ):
            self.ended = "sure"

    def _next(self, ball: Ball) -> tuple[Approach, Choice | None]:
        if self._spent():
            return self.touches[-1].approach, None
        tried, places = len(self.touches), self._places(ball)
        if self.config.policy != "information":
            policy = self.config.policy
            chosen = POLICY[policy] if isinstance(policy, str) else policy
            return chosen(ball, places, tried, self.rng), None
        met = sum(t.met for t in self.touches)
        if self.belief is not None and met >= self.config.blind and self._missed() < self.config.misses:
            here = self.guard.world_from_sensor
            limits = self.guard.stage.limits
            found = choose(
                self.belief, self.library, here, ball, self._pad, limits, self.rng, reachable=self._reachable
            )
            if isinstance(found, Choice):
                self._idle = 0
                return found.approach, found
            self._idle += 1
            if self._idle > self.config.idle:
                self.ended = found.reason
        return gap_touch(ball, places, tried, self.rng), None

    def _places(self, ball: Ball) -> Floats:
        """(n, 3) [mm] where the pad lay, or whence it came where it met nothing."""
        return np.array([t.pose[:3, 3] if t.met else t.approach.start[:3, 3] for t in self.touches])

    def _reachable(self, approach: Approach) -> bool:
        low, high = np.array(self.guard.limits.reach[:3]), np.array(self.guard.limits.reach[3:])
        at = approach.start[:3, 3]
        return bool((at > low).all() and (at < high).all())

    def _leave(self) -> None:
        """Back to where the last approach began, the way that the pad came."""
        if self._last is None:
            return
        start, self._last = self._last.approach.start, None
        try:
            retreat(self.guard, 8.0)
            self.guard.go_to(start)
        except (OverPress, Collision) as error:
            self.warnings.append(str(error))
            self._free_itself(start)

    def _free_itself(self, start: Floats) -> None:
        """After a fault the guard has backed off; the way to `start` is tried once more."""
        try:
            self.guard.go_to(start)
        except (OverPress, Collision) as error:
            self.warnings.append(str(error))

    def _touch(self, approach: Approach, ball: Ball) -> LoneTouch | None:
        here = self.guard.world_from_sensor
        try:
            for stop in way_round(here, approach.start, ball):
                self.guard.go_to(stop)
            return touch_once(self.guard, approach)
        except (OverPress, Collision) as error:
            self.warnings.append(str(error))
            self.guard.cost.touches += 1
            return None


def _as_modeled(contacts: Contacts, config: IdentifyConfig) -> Contacts:
    """With what an object may differ from its model added to the noise."""
    return replace(
        contacts,
        sigma=frozen(np.hypot(contacts.sigma, config.made)),
        normal_sigma=frozen(np.hypot(contacts.normal_sigma, config.made_angle)),
    )
