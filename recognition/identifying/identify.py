"""Touch, match, choose: until it is sure which object it is, or nothing more can be told.

    find the object -> touch -> Evidence -> match() -> Belief -> the next approach -> touch -> ...

A generator, as exploring is: whoever runs it pulls, watches and stops it.  It sees the hand that touches and the
library, and never the object.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from exploration.planning.touching.lone_touch import Approach, LoneTouch
from exploration.planning.ways.round_ball import Ball
from models.library import Library
from primitives.arrays import Floats
from recognition.identifying.bounds import believed_ball, felt_ball
from recognition.identifying.exact import Exact, exact
from recognition.identifying.finish import finish
from recognition.identifying.hand import Hand
from recognition.identifying.learned import LearnConfig, evidence_of, learned
from recognition.identifying.placed import is_placed
from recognition.identifying.policies import POLICY, Policy, gap_touch
from recognition.matching import Belief, Evidence, Prior
from recognition.matching.belief import UNKNOWN
from recognition.matching.next_touch.choose import Choice, choose
from recognition.matching.next_touch.held import Held
from recognition.matching.next_touch.planar import planar
from recognition.matching.next_touch.sampled import sampled

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
    patience: int = 8  # touches in a row, for which a name may be sure and its pose not
    place: float = 0.15  # [mm] error of its place, and
    turn: float = np.deg2rad(0.25)  # [rad] of its attitude, down to which it is touched when it is sure,
    finishing: int = 3  # with so many touches at most
    blind: int = 1  # touches that met something, before which the widest gap is touched
    misses: int = 2  # touches in a row without a contact, after which belief is not asked where to touch
    idle: int = 3  # touches in a row that were chosen for want of one that tells
    refused: int = 64  # proposals of a policy that begin where the hand cannot go, for one touch
    learning: LearnConfig = field(default_factory=LearnConfig)


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

    hand: Hand
    library: Library
    box: Floats  # (6,) workspace [mm]
    config: IdentifyConfig = field(default_factory=IdentifyConfig)
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))
    announce: Announce = lambda kind, detail: None
    touches: list[LoneTouch] = field(default_factory=list)
    belief: Belief | None = None
    ended: str = ""
    _idle: int = 0
    _refused: int = 0  # proposals until now
    _agreed: int = 0
    _before: str = ""
    _drawn: Held | None = None
    _finishing: int = 0  # touches since it was sure, for the pose alone
    _exact: Exact | None = None  # where it is, as exactly as can be told

    def run(self) -> Iterator[Step]:
        """Touch and match, one touch at a time."""
        for touch in self.hand.find(self.box):
            yield self._learn(touch, None)
            if self._spent():
                return
        if self.belief is None:
            self.ended = "nothing was found in the workspace"
            return
        while not self.ended:
            ball = self.around()
            self.hand.leave(ball)
            approach, choice = self._next(ball)
            if self.ended:
                return
            yield self._learn(self.hand.touch(approach, ball), choice)

    @property
    def evidence(self) -> Evidence:
        """All that was felt."""
        return evidence_of(self.touches, self.config.learning)

    def ball(self) -> Ball:
        """Holds the object, as far as is believed."""
        met = len({t.touch for t in self.touches if t.met})
        known = self._known()
        return believed_ball(
            self.evidence.contacts, met, self.belief, self.library, self.hand.pad, known=known
        )

    def _known(self) -> Held | None:
        """Poses drawn from the belief, once after each touch, where the policy looks at the belief at all."""
        if self.belief is None or not self.belief.hypotheses or self.config.policy != "information":
            return None
        if self._drawn is None:
            self._drawn = sampled(self.belief, self.library, self.evidence, self.rng)
        return self._drawn

    def around(self) -> Ball:
        """The ball that the next approach begins outside of."""
        if self._missed() < self.config.misses:
            return self.ball()
        return felt_ball(self.evidence.contacts, self.library, self.hand.pad)

    def _missed(self) -> int:
        """How many touches there were since one that told of a contact."""
        told = [bool(len(t.contacts)) for t in reversed(self.touches)]
        return told.index(True) if True in told else len(told)

    def _spent(self) -> bool:
        if self.hand.cost.touches >= self.config.max_touches:
            self.ended = "budget"
        return bool(self.ended)

    def _learn(self, touch: LoneTouch, choice: Choice | None) -> Step:
        self.touches.append(touch)
        self._drawn = None
        self.announce("touch", {"number": touch.touch, "felt": touch.note, "met": touch.met})
        if touch.told:
            config, before = self.config, self.belief
            self.belief = learned(
                self.touches, self.library, self._prior(), config.unknown, before, config.learning
            )
            self._exact = self._exactly()
            self._judge()
        return Step(touch, self.belief, choice, self.hand.cost.seconds)

    def _exactly(self) -> Exact | None:
        """Where the object is that is decided for, if its pose is known."""
        belief, config = self.belief, self.config
        best = None if belief is None else belief.best(belief.decision)
        if (
            belief is None
            or best is None
            or not is_placed(belief, self.library[best.name], config.confidence)
        ):
            return None
        return exact(best, self.library[best.name], self.touches, self._prior(), config.learning)

    @property
    def told(self) -> Belief | None:
        """The belief, with the object that it decides for where its touches put it.

        Touches are chosen by what was matched: rivals of one name must be known alike well to be told apart.
        """
        if self.belief is None or self._exact is None:
            return self.belief
        old, better = self.belief.best(self.belief.decision), self._exact.hypothesis
        return replace(
            self.belief, hypotheses=tuple(better if h is old else h for h in self.belief.hypotheses)
        )

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
        wanted = self.config.place, self.config.turn
        placed = name == UNKNOWN or is_placed(self.belief, self.library[name], self.config.confidence)
        if self._agreed < (self.config.confirmed if placed else self.config.patience):
            self._finishing = 0
        elif self._exact is None or self._finishing >= self.config.finishing or self._exact.within(*wanted):
            self.ended = "sure"
        else:
            self._finishing += 1

    def _next(self, ball: Ball) -> tuple[Approach, Choice | None]:
        if self._spent():
            return self.touches[-1].approach, None
        policy = self.config.policy
        if policy == "planar":
            return self._planar(ball) or self._by(gap_touch, ball), None
        if policy != "information":
            return self._by(POLICY[policy] if isinstance(policy, str) else policy, ball), None
        if self._finishing and (finish := self._finish(ball)) is not None:
            return finish, None
        met = sum(t.met for t in self.touches)
        if self.belief is not None and met >= self.config.blind and self._missed() < self.config.misses:
            made = [t.pose for t in self.touches if t.met or t.stopped]
            found = choose(
                self.belief, self.library, self.hand.here, ball, self.hand.pad, self.hand.pace, self.rng,
                reachable=self.hand.reachable, known=self._known(), made=made,
            )  # fmt: skip
            if isinstance(found, Choice):
                self._idle = 0
                return found.approach, found
            if self._agreed and (confirm := self._finish(ball)) is not None:
                return confirm, None
            self._idle += 1
            if self._idle > self.config.idle:
                self.ended = found.reason
        return self._by(gap_touch, ball), None

    def _by(self, policy: Policy, ball: Ball) -> Approach:
        """What a policy proposes, that begins where the hand can go: not under a table."""
        places = self._places(ball)
        for _ in range(self.config.refused):
            made = policy(ball, places, len(self.touches) + self._refused, self.rng)
            if self.hand.reachable(made):
                break
            self._refused += 1
            places = np.concatenate([places, made.start[None, :3, 3]])  # as though it had been tried
        return made

    def _planar(self, ball: Ball) -> Approach | None:
        if self.belief is None or self._missed() >= self.config.misses:
            return None
        return planar(self.belief, self.library, ball, self.hand.pad, self.rng, self.hand.reachable)

    def _finish(self, ball: Ball) -> Approach | None:
        """The touch that tells most of where the object is that it is sure of."""
        best = None if self.told is None else self.told.best(self.told.decision)
        if best is None:
            return None
        asked = best, self._exact, self.touches, self.evidence.contacts, self._known()
        return finish(*asked, self.library, self.hand, ball, self.rng)

    def _places(self, ball: Ball) -> Floats:
        """(n, 3) [mm] where the pad lay, or whence it came where it met nothing."""
        at = [t.pose[:3, 3] if t.met else t.approach.start[:3, 3] for t in self.touches]
        return np.array(at).reshape(-1, 3)
