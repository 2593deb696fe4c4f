"""What touches for the identifier: the pad behind its guard, or whatever stands for it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from exploration.control.procedures.approach import retreat
from exploration.devices.guard import Collision, Cost, Guard, OverPress
from exploration.planning.known.told import Told
from exploration.planning.touching.lone_touch import Approach, LoneTouch, blocked, touch_once
from exploration.planning.touching.pace import Pace
from exploration.planning.touching.within_reach import begun_within
from exploration.planning.ways.round_ball import Ball, way_out, way_round
from exploration.planning.ways.search import beside_first, coarse_first, from_above, not_below
from exploration.planning.ways.travel import kept_within
from primitives.arrays import Floats

_STEEP = 0.6  # of an approach's way that leads down, from which it comes from above
_NEARLY = 0.42  # of its length, at half of which it passes the middle of where it is made for


class Hand(Protocol):
    """Goes to where an approach begins, makes it, and comes back."""

    @property
    def cost(self) -> Cost:
        """What touching has cost so far."""
        ...

    @property
    def here(self) -> Floats:
        """(4, 4) world_from_sensor."""
        ...

    @property
    def pad(self) -> tuple[float, float]:
        """[mm] of the skin along x and y."""
        ...

    @property
    def pace(self) -> Pace:
        """What touching takes."""
        ...

    def find(self, box: Floats) -> Iterator[LoneTouch]:
        """Sweeps through a (6,) box [mm], from its middle outward, until one meets something."""
        ...

    def touch(self, approach: Approach, ball: Ball) -> LoneTouch:
        """Round a ball to where the approach begins, and the approach; it tells nothing if that was blocked."""
        ...

    def leave(self, ball: Ball | None = None) -> None:
        """Back to where the last approach began, or only out of the ball."""
        ...

    def reachable(self, approach: Approach) -> bool:
        """Whether the stage gets to where it begins."""
        ...


@dataclass
class GuardedHand:
    """One array on one stage; faults become warnings."""

    guard: Guard
    warnings: list[str] = field(default_factory=list)
    told: Told | None = None  # what stands beside the object, and is no part of it
    feature: float = 10.0  # [mm] of the smallest object that a search must not miss
    _last: LoneTouch | None = None

    @property
    def cost(self) -> Cost:
        """Of the guard."""
        return self.guard.cost

    @property
    def here(self) -> Floats:
        """(4, 4) world_from_sensor."""
        return self.guard.world_from_sensor

    @property
    def pad(self) -> tuple[float, float]:
        """[mm] of the array in use."""
        return self.guard.sensor.array.size

    @property
    def pace(self) -> Pace:
        """Of the array in use."""
        return Pace.of(self.guard)

    def find(self, box: Floats) -> Iterator[LoneTouch]:
        """Sweep until the pad meets something; where it was stopped, but not at the skin, beside there first."""
        floor = box[2] if self.told is None else max(box[2], self.told.floor)
        room = np.array([*box[:2], floor, *box[3:]])
        left = list(coarse_first(room, self.pad, self.feature, standing=self.told is not None))
        while left:
            start, end = left.pop(0)
            try:
                for stop in from_above(self.here, start, box[5]):
                    self.guard.go_to(stop)
                length = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))
                made = self._last = self._touched(Approach(start, length))
            except (OverPress, Collision) as error:
                self.warnings.append(str(error))
                self._free_itself(start)
                continue
            yield made
            if made.met and len(made.contacts):
                return
            if made.stopped:
                place = made.pose[:3, 3]
                left = beside_first(not_below(left, place), place)
            self.leave()

    def touch(self, approach: Approach, ball: Ball) -> LoneTouch:
        """One guarded approach."""
        approach = begun_within(approach, self._reach)
        try:
            for stop in way_round(self.here, approach.start, ball):
                self.guard.go_to(kept_within(stop, self._reach))
            if approach.flown:
                self.guard.go_to(approach.felt.start)
            self._last = self._touched(approach)
        except (OverPress, Collision) as error:
            self.warnings.append(str(error))
            self.guard.cost.touches += 1
            return blocked(self.guard.cost.touches, approach, self.here)
        return self._last

    def leave(self, ball: Ball | None = None) -> None:
        """The way that the pad came."""
        if self._last is None:
            return
        start, self._last = self._last.approach.start, None
        try:
            retreat(self.guard, 8.0)
            if ball is not None:
                start = way_out(self.here, start, ball)
            start = kept_within(start, self._reach)
            self.guard.go_to(start)
        except (OverPress, Collision) as error:
            self.warnings.append(str(error))
            self._free_itself(start)

    def reachable(self, approach: Approach) -> bool:
        """Within the guard's box."""
        low, high = self._reach[:3], self._reach[3:]
        at = approach.start[:3, 3]
        within = bool((at > low).all() and (at < high).all())
        return within and (self.told is None or self._past(self.told, approach))

    def _past(self, told: Told, approach: Approach) -> bool:
        """Whether an approach begins clear of what is told, and does not come to that first.

        What comes from well above comes to the object first; what comes from aside, where it is over the table yet
        as it comes near the object's middle.
        """
        begin, ahead = approach.start, approach.start.copy()
        ahead[:3, 3] += _NEARLY * approach.length * approach.direction
        aside = float(approach.direction[2]) > -_STEEP
        return told.leads_past(begin) and not (
            aside and told.table is not None and not told.leads_past(ahead)
        )

    @property
    def _reach(self) -> Floats:
        """(6,) [mm] of the stage."""
        return np.array(self.guard.limits.reach)

    def _touched(self, approach: Approach) -> LoneTouch:
        """One touch; what it felt of other bodies is left out."""
        made = replace(touch_once(self.guard, approach.felt), approach=approach)
        if self.told is None:
            return made
        own = self.told.without(made.contacts)
        alone = made.imprint is not None and not self.told.under(made.imprint)
        return replace(
            made,
            contacts=own,
            met=made.met and len(own) == len(made.contacts),
            imprint=made.imprint if alone else None,
        )

    def _free_itself(self, start: Floats) -> None:
        """After a fault the guard has backed off; the way to `start` is tried once more."""
        try:
            self.guard.go_to(start)
        except (OverPress, Collision) as error:
            self.warnings.append(str(error))
