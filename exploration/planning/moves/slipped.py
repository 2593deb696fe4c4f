"""What an array met and could not lie on, come at by a smaller one.

A wide pad meets the inside of a bowl, or of a countersink, with its corners, and rolls off.  A small one comes the
same way to the same place, where the hollow is nearly flat under it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from exploration.planning.touching.findings import Attempts, Done
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from primitives import pose as se3
from primitives.arrays import Floats

_BESIDE = 6.0  # [mm] between places that are one
_FELT = 3.0  # [mm] from a place that was felt since, within which it is known
_BACK = 2.0  # [mm] before the place, that the array may need to come on at


class Slipped:
    """The places of one exploration."""

    def __init__(self, study: Study, reach: Reach) -> None:
        self.study, self.reach = study, reach
        self._tried = Attempts(1, _BESIDE)

    def next(self, alongs: Callable[[Floats], list[Floats]]) -> Callable[[], Done] | None:
        """A touch at the nearest of them that has room; `alongs` gives directions to turn to on a (3,) normal."""
        here = self.study.pad.guard.world_from_sensor[:3, 3]
        left = [(at, way) for at, way in self.study.pad.slipped if not self._known(at)]
        for at, way in sorted(left, key=lambda place: float(np.linalg.norm(place[0] - here))):
            poses = [se3.pose(se3.frame_along(way, along), at - _BACK * way) for along in alongs(-way)]
            if room := self.reach.with_room(poses):
                return partial(self._touch, at, room)
        return None

    def _known(self, at: Floats) -> bool:
        felt = self.reach.felt.points
        near = np.linalg.norm(felt - at, axis=1).min(initial=np.inf) < _FELT
        return bool(near) or self._tried.given_up(at)

    def _touch(self, at: Floats, poses: list[Floats]) -> Done:
        self._tried.note(at)
        for pose in poses:
            if self.reach.touch(pose):
                return self.study.face_here(), "touched what another array had slipped off"
            if self.reach.led:
                return None, "nothing was where another array had slipped off"
        return None, "no way led to where another array had slipped off"
