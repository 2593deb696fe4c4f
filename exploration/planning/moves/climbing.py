"""Climbing what stopped a stroke: coming down beyond it along the face's normal, from over all that was felt.

A step may be too low for an array to face its side, or the side may be round or slanted; its top is felt all the
same.  Where there is none the array goes down past the place, and what it passes through is free.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from exploration.planning.touching.findings import Attempts, Done
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study, Wall
from exploration.planning.ways.box_kernels import in_box
from primitives import pose as se3
from primitives.arrays import Floats


@dataclass(frozen=True)
class ClimbingConfig:
    """Where an array comes down."""

    beyond: tuple[float, ...] = (0.55, 0.35, 0.15)  # past what stopped it, of its shorter side, in turn
    beside: float = 9.0  # [mm] between stops that are one
    step: float = 0.6  # [mm] over the face, from which a felt place is the top of a step
    low: float = 3.0  # [mm] over the face, where something must have room to stand, and
    free: float = 0.6  # share of the array's place, at most, that nothing stands in there
    alike: float = 0.7  # least cosine between the ways that the two look
    vain: int = 8  # times on end that no step was there, from which no more are looked for


class Climbing:
    """The climbs of one array."""

    def __init__(self, study: Study, reach: Reach, config: ClimbingConfig = ClimbingConfig()) -> None:
        self.study, self.reach, self.config = study, reach, config
        self._tried, self._vain = Attempts(1, config.beside), 0

    def next(self, walls: Sequence[Wall]) -> Callable[[], Done] | None:
        """Onto what stopped a stroke nearest to here, where its top was not felt yet; None where nothing did."""
        if self._vain >= self.config.vain:
            return None
        here = self.study.pad.guard.world_from_sensor[:3, 3]
        left = [wall for wall in walls if not self._tried.given_up(wall.point)]
        for wall in sorted(left, key=lambda wall: float(np.linalg.norm(wall.point - here))):
            if (poses := self._poses(wall)) and (poses := self.reach.with_room(poses)):
                return partial(self._climb, wall, poses)
        return None

    def _poses(self, wall: Wall) -> list[Floats]:
        """(4, 4) targets beyond a stop, as low as there is room; no top is known there, nor free space."""
        short, felt = float(min(self.study.pad.size)), self.reach.felt.points
        high = float(((felt - wall.point) @ wall.normal).max(initial=0.0))
        poses = []
        for reading, share in product((wall, *wall.readings()), self.config.beyond):
            turn = self.study.pad.attitude(wall.normal, se3.cross(wall.normal, reading.heading))
            low = se3.pose(turn, reading.point + share * short * reading.heading)
            pose = low @ se3.pose(translation=[0.0, 0.0, -self.reach.off(low, high)])
            if self._unknown(pose):
                poses.append(pose)
        return poses

    def _unknown(self, pose: Floats) -> bool:
        """Whether something that nobody has felt yet may stand under a pad at a (4, 4) pose."""
        half = 0.5 * np.asarray(self.study.pad.size)
        felt, normal = self.reach.felt, -pose[:3, 2]
        over = in_box(felt.points, pose, (-half[0], -half[1], -np.inf), (half[0], half[1], -self.config.step))
        if (felt.facing[over] @ normal > self.config.alike).any():
            return False
        x, y = (np.linspace(-side, side, 5) for side in half)
        under = np.stack(np.meshgrid(x, y, [-self.config.low]), axis=-1).reshape(-1, 3)
        free = self.study.pad.swept.holds(se3.transform_points(pose, under))
        return float(free.mean()) < self.config.free

    def _climb(self, wall: Wall, poses: Sequence[Floats]) -> Done:
        self._tried.note(wall.point)
        self._vain += 1
        felt = self.reach.felt.points
        for pose in poses:
            high = float(((felt - pose[:3, 3]) @ wall.normal).max(initial=0.0))
            if self.reach.descend(pose, high):
                if self.study.pad.on_told():
                    return None, "nothing but what is known was where a stroke was stopped"
                rose = float((self.study.pad.guard.world_from_sensor[:3, 3] - wall.point) @ wall.normal)
                if rose < self.config.step:
                    return self.study.face_here(), "nothing stands on the face where a stroke was stopped"
                self._vain = 0
                return self.study.face_here(), "came down on what had stopped a stroke"
            if self.reach.led:
                return None, "nothing was beyond where a stroke was stopped"
        return None, "no way led over what had stopped a stroke"
