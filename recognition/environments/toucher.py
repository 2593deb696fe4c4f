"""Touches apart from each other in a simulated world: the object is found, then approached from where one likes.

Of the object nothing is known but what was felt, and how large it may be.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, field

import numpy as np

from exploration.control.procedures.approach import retreat
from exploration.devices.guard import Collision, Guard, OverPress
from exploration.planning.touching.lone_touch import Approach, LoneTouch, touch_once
from exploration.planning.ways.round_ball import Ball, way_round
from exploration.planning.ways.search import sweeps
from primitives.arrays import Floats
from primitives.evidence import Contacts

_MARGIN = 12.0  # [mm] round the object
_BACK = 8.0  # [mm] that the pad goes back before it turns


@dataclass
class Toucher:
    """Everything felt until now."""

    guard: Guard
    box: Floats  # (6,) workspace [mm]
    largest: float  # [mm] radius of a ball that holds the object
    touches: list[LoneTouch] = field(default_factory=list)
    _last: LoneTouch | None = None

    @property
    def contacts(self) -> Contacts:
        """Of all touches that met something."""
        return Contacts.concatenate([t.contacts for t in self.touches if t.met])

    @property
    def places(self) -> Floats:
        """(n, 3) [mm] where the pad lay, or whence it came where it met nothing."""
        out = [t.pose[:3, 3] if t.met else t.approach.start[:3, 3] for t in self.touches]
        return np.array(out).reshape(-1, 3)

    def find(self) -> bool:
        """Sweep the workspace, from its middle outward, until something is met."""
        for start, end in sweeps(self.box, self.guard.sensor.array.size):
            try:
                self.guard.go_to(start)
                made = touch_once(
                    self.guard, Approach(start, float(np.linalg.norm(end[:3, 3] - start[:3, 3])))
                )
            except (OverPress, Collision):
                with suppress(OverPress, Collision):
                    self.guard.go_to(start)
                continue
            self._keep(made)
            if made.met and len(made.contacts):
                return True
            self._leave()
        return False

    def around(self) -> Ball:
        """A ball that holds the object, behind what was felt of it."""
        felt = self.contacts
        middle = felt.points.mean(axis=0) if len(felt) else 0.5 * (self.box[:3] + self.box[3:])
        if felt.has_normal.any():
            share = max(0.15, 0.5 / max(1, sum(t.met for t in self.touches)))
            middle = middle - share * self.largest * np.nanmean(felt.normals, axis=0)
        farthest = float(np.linalg.norm(felt.points - middle, axis=1).max(initial=0.0))
        room = _MARGIN + 0.5 * max(self.guard.sensor.array.size)
        return Ball(middle, max(1.3 * self.largest, farthest) + room)

    def touch(self, approach: Approach) -> LoneTouch | None:
        """Go round the object and approach it; None where the housing or the skin met something first."""
        ball = self.around()
        self._leave()
        try:
            for stop in way_round(self.guard.world_from_sensor, approach.start, ball):
                self.guard.go_to(stop)
            made = touch_once(self.guard, approach)
        except (OverPress, Collision):
            self.guard.cost.touches += 1
            return None
        self._keep(made)
        return made

    def _keep(self, made: LoneTouch) -> None:
        self._last = made
        self.touches.append(made)

    def _leave(self) -> None:
        if self._last is None:
            return
        start, self._last = self._last.approach.start, None
        for attempt in (True, False):
            try:
                if attempt:
                    retreat(self.guard, _BACK)
                self.guard.go_to(start)
                return
            except (OverPress, Collision):
                continue
