"""Going on along flat faces that their pictures show to go on, where the pad has no room to lie by itself.

Its attitude is that of the face, which is known: a pad that settles rolls off a land narrower than itself.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from exploration.control.procedures.land import AS_TOLD
from exploration.control.procedures.settle import AS_IT_CAME
from exploration.planning.open.land_ends import LandEnd, land_ends
from exploration.planning.touching.findings import Done
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.patch_graph import PatchGraph

_AHEAD = 0.25  # of the pad's length past an end, where its middle lies: a land may bend
_BESIDE = 0.25  # of its shorter side, between ends that are one
_STRAY = 4.0  # [mm] that a pad is raised at most for places felt beside a land's edges


class AlongLand:
    """The ends of one exploration that were gone on from."""

    def __init__(self, study: Study, reach: Reach) -> None:
        self.study, self.reach = study, reach
        self._tried: list[LandEnd] = []
        self._last: tuple[tuple[PatchGraph, int], list[LandEnd]] | None = None

    def next(self) -> Callable[[], Done] | None:
        """A touch past the nearest end that has room."""
        left = [end for end in self._ends() if not self._given_up(end)]
        if not left:
            return None
        seconds = self.reach.seconds_to(np.array([e.point for e in left]), np.array([e.normal for e in left]))
        for k in np.argsort(seconds):
            if room := [pose for pose in self._places(left[k]) if self._has_room(pose)]:
                return partial(self._go_on, left[k], room)
            self._tried.append(left[k])
        return None

    def _given_up(self, end: LandEnd) -> bool:
        """Whether one there, that looks the same way, was tried."""
        beside = _BESIDE * min(self.study.pad.size)
        return any(
            float(np.linalg.norm(end.point - other.point)) < beside and float(end.normal @ other.normal) > 0.0
            for other in self._tried
        )

    def _has_room(self, pose: Floats) -> bool:
        """Whether a pad has room at a (4, 4) pose, or a little over it."""
        up = self.reach.off(pose, _STRAY)
        return self.reach.clear(pose @ se3.pose(translation=[0.0, 0.0, -up]))

    def _ends(self) -> list[LandEnd]:
        """Of this moment: the last ones, where nothing was felt or pictured since."""
        graph, mosaic = self.study.found.graph, self.study.pad.skin.mosaic
        if self._last is None or self._last[0][0] is not graph or self._last[0][1] != len(mosaic):
            self._last = (graph, len(mosaic)), land_ends(graph.faces, mosaic)
        return self._last[1]

    def _places(self, end: LandEnd) -> list[Floats]:
        """(4, 4) poses of the pad past an end: its x along the land, or across."""
        turns = (end.way, np.cross(end.normal, end.way))
        return [
            se3.pose(se3.frame_along(-end.normal, turn), end.point + _AHEAD * size * end.way)
            for turn, size in zip(turns, self.study.pad.size, strict=True)
        ]

    def _go_on(self, end: LandEnd, poses: list[Floats]) -> Done:
        self._tried.append(end)
        for pose in poses:
            if self.reach.touch(pose, True, AS_IT_CAME, AS_TOLD):
                return self.study.take_in(self.study.pad.feel()), "went on along a land"
            if self.reach.led:
                return None, "a land did not go on"
        return None, "no way led on along a land"
