"""What an array ran into on its way, and nobody has touched since: a post, a pin, a limb that sticks out.

The pad turns to face it as the skin came, or comes down on it as it was, from farther off.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from exploration.control.procedures.settle import NARROW
from exploration.planning.touching.bumps import Bump
from exploration.planning.touching.findings import Attempts, Done
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from primitives import pose as se3
from primitives.arrays import Floats

_BESIDE = 6.0  # [mm] between places that are one
_TOUCHED = 4.0  # [mm] from a contact, within which a place is known
_BACK = 2.0  # [mm] before the place, that the array may need to come on at
_OVER = 20.0  # [mm] over it, from where it is come down on
_ACROSS = 0.7  # most cosine between the way to it and that of the pad's x axis


class Bumped:
    """The touches of one array."""

    def __init__(self, study: Study, reach: Reach) -> None:
        self.study, self.reach = study, reach
        self._tried = Attempts(1, _BESIDE)

    def next(self) -> Callable[[], Done] | None:
        """A touch of the nearest that has room; None where none is left."""
        here = self.study.pad.guard.world_from_sensor[:3, 3]
        left = [bump for bump in self.study.pad.bumps if not self._known(bump.point)]
        for bump in sorted(left, key=lambda bump: float(np.linalg.norm(bump.point - here))):
            if room := self.reach.with_room(list(_poses(bump))):
                return partial(self._touch, bump.point, room)
        return None

    def _known(self, at: Floats) -> bool:
        """Whether contacts tell of a (3,) place, or it was tried for."""
        if self._tried.given_up(at):
            return True
        lots = [*(face.contacts.points for face in self.study.found.graph.faces), self.study.loose.points]
        return any(np.linalg.norm(lot - at, axis=1).min(initial=np.inf) < _TOUCHED for lot in lots)

    def _touch(self, at: Floats, poses: list[Floats]) -> Done:
        self._tried.note(at)
        for pose in poses:
            if self.reach.descend(pose, _OVER, NARROW):
                return self.study.face_here(), "touched what an array had run into"
        return None, "nothing was touched where an array had run into something"


def _poses(bump: Bump) -> Iterator[Floats]:
    """(4, 4) targets at a bump, the pad's x axis along each of those it had then that lie across the way."""
    then = bump.pose[:3, :3]
    for inward in (bump.way, then[:, 2]):
        for along in (then[:, 2], then[:, 0], then[:, 1]):
            if abs(float(along @ inward)) < _ACROSS:
                yield se3.pose(se3.frame_along(inward, along), bump.point - _BACK * inward)
