"""Touching the object where a draft of it says that there is surface, and nothing was felt.

Once nothing that is known leads on, all of it makes a body, with walls and ends that were only inferred.  Where
that is wrong, it is wrong where nobody was.  The array lies down on what it has not felt there, if it has room:
what it meets elsewhere, or does not meet, is known when the next draft is drawn.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.spatial import KDTree

from exploration.planning.moves.looking import Looking
from exploration.planning.open.frontier import Predicted
from exploration.planning.open.lying import lying_places
from exploration.planning.touching.findings import Attempts, Done
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.planning.ways.box_kernels import in_box
from primitives.arrays import Bools, Floats

SPACING = 3.0  # [mm] between the places that stand for a draft's surface, about
Draft = Callable[[], Predicted]  # such places of what all that is known makes


@dataclass(frozen=True)
class DraftedConfig:
    """What of a draft is touched, and how often one is drawn."""

    drafts: int = 3
    each: int = 10  # touches for one of them
    known: float = 6.0  # [mm] from a felt place that faces alike, within which surface is known
    facing: float = 0.5  # least cosine of that
    behind: float = 2.0  # [mm] a surface, where no array can have been
    beside: int = 8  # felt places that are looked at for one
    share: float = 0.3  # of the array, at least, that untouched surface must be under
    flush: float = 0.9  # least cosine between the array's normal and that of what it covers
    off: float = 2.0  # [mm] of that from the array's plane
    same: float = 4.0  # [mm] between touches that are one
    tries: int = 50  # ways to lie on a place, the best first


class Drafted:
    """The touches of one array."""

    def __init__(
        self,
        study: Study,
        reach: Reach,
        draft: Draft,
        alongs: Callable[[Floats], list[Floats]],
        looking: Looking,
        config: DraftedConfig = DraftedConfig(),
    ) -> None:
        self.study, self.reach, self.draft, self.alongs, self.config = study, reach, draft, alongs, config
        self._looking = looking
        self._goals: list[Floats] = []
        self._left, self._felt = config.drafts, -1
        self._tried = Attempts(1, config.same)

    def next(self) -> Callable[[], Done] | None:
        """A touch of what the last draft has untouched; None where another would have no more to say."""
        felt = len(self.reach.felt.points)
        if not self._goals and self._left > 0 and felt != self._felt:
            self._left, self._felt = self._left - 1, felt
            self._goals = self._untouched(self.draft())
        waiting = np.array(self._goals).reshape(-1, 4, 4)
        gone = self._gone_through(waiting[:, :3, 3], -waiting[:, :3, 2])
        self._goals = [goal for goal, free in zip(self._goals, gone, strict=True) if not free]
        if not self._goals:
            return None
        here = self.study.pad.guard.world_from_sensor[:3, 3]
        nearest = int(np.argmin([np.linalg.norm(goal[:3, 3] - here) for goal in self._goals]))
        return partial(self._touch, self._goals.pop(nearest))

    def _untouched(self, surface: Predicted) -> list[Floats]:
        """(4, 4) poses at which the array lies on much that was not felt, and has room."""
        known = self._known(surface) | self._gone_through(surface.points, surface.normals)
        left, size = _of(surface, ~known), self.study.pad.size
        least = self.config.share * size[0] * size[1] / SPACING**2
        goals: list[Floats] = []
        waiting = self._tried.counts(left.points) == 0
        while waiting.any() and len(goals) < self.config.each:
            one = int(np.argmax(waiting))
            waiting[one] = False
            places = lying_places(left, one, self.alongs(left.normals[one]), size)[: self.config.tries]
            told = [pose for pose in places if self._under(left, pose).sum() > least]
            if told and (room := self.reach.with_room(told)):
                goals.append(room[0])
                waiting &= ~self._under(left, room[0])
        return goals

    def _known(self, surface: Predicted) -> Bools:
        """(n,) what of a surface was felt."""
        felt = self.reach.felt
        if not len(felt.points):
            return np.zeros(len(surface.points), dtype=bool)
        near = min(self.config.beside, len(felt.points))
        away, which = KDTree(felt.points).query(surface.points, k=[*range(1, near + 1)])
        facing = np.einsum("ijk,ik->ij", felt.facing[which], surface.normals)
        return np.asarray(((away < self.config.known) & (facing > self.config.facing)).any(axis=1))

    def _gone_through(self, points: Floats, normals: Floats) -> Bools:
        """(n,) whether an array was where the material behind (n, 3) points would be."""
        return self.study.pad.swept.holds(points - self.config.behind * normals)

    def _under(self, surface: Predicted, pose: Floats) -> Bools:
        """(n,) what of a surface the array covers at a (4, 4) pose."""
        (x, y), off = self.study.pad.size, self.config.off
        under = in_box(surface.points, pose, (-0.5 * x, -0.5 * y, -off), (0.5 * x, 0.5 * y, off))
        under[under] = surface.normals[under] @ -pose[:3, 2] > self.config.flush
        return under

    def _touch(self, goal: Floats) -> Done:
        self._tried.note(goal[:3, 3])
        met = self.reach.touch(goal)
        led = self.reach.led
        if not met and not led:
            found = self._looking.come_down_on(goal)
            met, led = bool(found), found is not None
        if met:
            return self.study.face_here(), "touched what a draft of the object has"
        return None, "a draft of the object is wrong there" if led else "no way led to what a draft has"


def _of(surface: Predicted, rows: Bools) -> Predicted:
    return Predicted(surface.points[rows], surface.normals[rows], surface.face[rows])
