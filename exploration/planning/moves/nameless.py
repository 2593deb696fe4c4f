"""Surface that was met and belongs to no face yet, followed from touch to touch until it tells what it is.

A ring, a narrow ledge or a freeform area may be touched many times before its contacts make a face, and until then
no face predicts where it goes on.  Beside a contact, along its own tangents, is where it most likely does; what is
narrow goes on the way that it was felt, and has sides.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from exploration.planning.touching.findings import Attempts, Done
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from primitives import pose as se3
from primitives.arrays import Bools, Floats
from primitives.evidence import Contacts
from primitives.fit import Fit


@dataclass(frozen=True)
class NamelessConfig:
    """How far one goes, and how long."""

    aside: float = 0.6  # of the pad's shorter side, from a contact to where it is followed to
    same: float = 0.4  # of it, within which places are one
    facing: float = 0.5  # least cosine of what was felt there, so that the place is known
    narrow: float = 0.5  # of the contacts about one, how wide they spread at most for how long, to tell a way
    along: float = 0.7  # least cosine of a way that goes on along it
    cell: float = 3.0  # [mm] between contacts that count
    off: float = 1.0  # [mm] from a face that looks alike, within which a contact is of it
    alike: float = 0.8  # least cosine between the two
    unsure: float = 0.2  # [rad] of a contact's normal, from which nothing is followed along it
    under: float = 1.0  # [mm] under the place, that nothing may have gone through
    deep: float = 4.0  # [mm] under a contact of what is narrow, where it is come at from its sides
    back: float = 2.0  # [mm] before the place, that the array may need to come on at
    vain: int = 6  # touches on end that met nothing, from which no more are made
    most: int = 40  # touches of one array


class _Goals(NamedTuple):
    points: Floats  # (n, 3) [mm]
    normals: Floats  # (n, 3) outward there, as far as one can guess
    ways: Floats  # (n, 3) for the pad's x axis
    rank: Floats  # (n,) along what is narrow, as it was felt; from its sides; anywhere beside

    @staticmethod
    def none() -> _Goals:
        return _Goals(np.empty((0, 3)), np.empty((0, 3)), np.empty((0, 3)), np.empty(0))


class Nameless:
    """The touches of one array."""

    def __init__(self, study: Study, reach: Reach, config: NamelessConfig = NamelessConfig()) -> None:
        self.study, self.reach, self.config = study, reach, config
        self._aside = config.aside * min(study.pad.size)
        self._tried = Attempts(1, config.same * min(study.pad.size))
        self._left, self._vain = config.most, 0

    def next(self) -> Callable[[], Done] | None:
        """A touch where a nameless contact's surface may go on, the nearest that has room; None where none is."""
        if self._left <= 0 or self._vain >= self.config.vain:
            return None
        goals = self._goals()
        here = self.study.pad.guard.world_from_sensor[:3, 3]
        for k in np.lexsort((np.linalg.norm(goals.points - here, axis=1), goals.rank)):
            at, normal, way = goals.points[k], goals.normals[k], goals.ways[k]
            poses = [
                se3.pose(se3.frame_along(-normal, along), at + self.config.back * normal)
                for along in (way, np.cross(normal, way))
            ]
            if room := self.reach.with_room(poses):
                return partial(self._touch, at, room)
        return None

    def _goals(self) -> _Goals:
        """Places beside nameless contacts, those first to which the contacts about them lead."""
        loose = self._nameless()
        cells = np.round(loose.points / self.config.cell).astype(int).reshape(-1, 3)
        _, first = np.unique(cells, axis=0, return_index=True)
        found = [_Goals.none()]
        for point, normal in zip(loose.points[first], loose.normals[first], strict=True):
            longest = self._longest(loose.points, point)
            turns = np.arange(8) * (np.pi / 4.0)
            ways = np.column_stack([np.cos(turns), np.sin(turns)]) @ se3.frame_along(normal)[:, :2].T
            rank = np.where(np.abs(ways @ longest) > self.config.along, 0, 2)
            found.append(_Goals(point + self._aside * ways, np.tile(normal, (8, 1)), ways, rank))
            if longest.any():
                sides = np.cross(normal, longest) * np.array([[1.0], [-1.0]])
                under = np.tile(point - self.config.deep * normal, (2, 1))
                found.append(_Goals(under, sides, np.tile(longest, (2, 1)), np.ones(2)))
        goals = _Goals(*(np.concatenate(column) for column in zip(*found, strict=True)))
        keep = ~self._known(goals.points, goals.normals) & (self._tried.counts(goals.points) == 0)
        keep &= ~self.study.pad.swept.holds(goals.points - self.config.under * goals.normals)
        return _Goals(*(column[keep] for column in goals))

    def _nameless(self) -> Contacts:
        """The contacts that no face explains; one that lies nearly on a face and faces as it does is of it."""
        loose = self.study.loose.select(self.study.loose.normal_sigma < self.config.unsure)
        keep = np.ones(len(loose), dtype=bool)
        for face in self.study.found.graph.faces:
            if isinstance(face.fit, Fit) and len(loose):
                side = 1.0 if face.fit.convex else -1.0
                facing = side * (face.fit.shape.normals(loose.points) * loose.normals).sum(axis=1)
                off = np.abs(face.fit.shape.signed_distance(loose.points))
                keep &= (off > self.config.off) | (facing < self.config.alike)
        return loose.select(keep)

    def _longest(self, points: Floats, about: Floats) -> Floats:
        """(3,) the direction in which the contacts about a (3,) place spread most; nothing where none does."""
        near = points[np.linalg.norm(points - about, axis=1) < 2.0 * self._aside]
        _, spread, axes = np.linalg.svd(near - near.mean(axis=0), full_matrices=False)
        narrow = len(near) > 1 and spread[1:2].sum() < self.config.narrow * spread[0]
        return np.asarray(axes[0]) if narrow else np.zeros(3)

    def _known(self, goals: Floats, normals: Floats) -> Bools:
        """(n,) whether (n, 3) places were felt, looking as they do."""
        felt = self.reach.felt
        if not len(felt.points) or not len(goals):
            return np.zeros(len(goals), dtype=bool)
        reach = self.config.same * min(self.study.pad.size)
        away, near = KDTree(felt.points).query(goals)
        return np.asarray((away < reach) & ((felt.facing[near] * normals).sum(axis=1) > self.config.facing))

    def _touch(self, goal: Floats, poses: list[Floats]) -> Done:
        self._left -= 1
        self._vain += 1
        self._tried.note(goal)
        for pose in poses:
            if self.reach.touch(pose):
                self._vain = 0
                home = self.study.face_here()
                self.study.name_loose()
                return home, "followed what belongs to no face yet"
            if self.reach.led:
                return None, "what belongs to no face yet goes on elsewhere"
        return None, "no way led to where what belongs to no face yet may go on"
