"""Turning to face what stopped a stroke, just above the face that the pad lay on: it may be a wall, or nothing.

A housing that grazes a curved flank stops a stroke too, and says nothing of a hollow.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from exploration.planning.touching.findings import Attempts, Done
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study, Wall
from exploration.planning.ways.transit import Support
from primitives import pose as se3

_NOTHING = "nothing was where a stroke met a wall"
_ABOVE = (1.2, 5.0, 12.0)  # [mm] of the housing over the face whose wall it comes to, in turn
_ASIDE = (0.0, 8.0, -8.0, 16.0, -16.0)  # [mm] along the wall, in turn


def face_wall(study: Study, reach: Reach, wall: Wall) -> Done:
    """Touch what a stroke met; `reach.led` says whether there was a way to it."""
    half = study.pad.tool.high[:2].min()
    along = np.cross(wall.normal, wall.heading)
    for give, above, shift in product((False, True), _ABOVE, _ASIDE):
        at = wall.point + (half + above) * wall.normal + shift * along
        target = se3.pose(study.pad.attitude(-wall.heading, along), at)
        if reach.touch(target, give):
            return study.face_here(), "touched a wall"
        if reach.led:
            return None, _NOTHING
    return None, "no way led to a wall"


class Walls:
    """What stopped strokes on an object that is taken for convex, each looked at before it proves the contrary."""

    def __init__(self, study: Study) -> None:
        self.study, self._reach = study, Reach(study.pad)
        self._looked_at = Attempts(1, 9.0)
        self._in_vain: list[Wall] = []

    def next(self) -> Wall | None:
        """A wall that stopped the pad, and was not looked at yet."""
        return next((wall for wall in self.study.walls if wall.stopped), None)

    def look(self, wall: Wall) -> Done:
        """Face it: one that is not there is forgotten, unless a stroke is stopped at that place again."""
        found = self.study.found
        if self._looked_at.given_up(wall.point):
            found.hollow = True
            return None, "a wall stopped the pad again"
        self._looked_at.note(wall.point)
        done, note = face_wall(self.study, self._reach, wall)
        if done is None and self._reach.led:
            self.study.pad.here = Support(
                wall.point, wall.normal
            )  # in front of which it is, having met nothing
            self.study.walls[:] = [other for other in self.study.walls if other is not wall]
            self._in_vain.append(wall)
        else:
            found.hollow = True
        return done, note

    def recall(self) -> None:
        """Count those again that were looked at in vain: on a hollow object, what is round may stand there."""
        self.study.walls.extend(self._in_vain)
        self._in_vain.clear()
