"""Policies to measure exploration against: even grid, random touches, raster; same approach and perception.

Touches come from six sides, ring after ring round the middle of what was felt, until a whole ring has missed; or
from anywhere at random.  A raster goes on from each touch with a stroke along the line.  None of them looks at
what the touches mean.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from exploration.control.procedures.approach import ApproachConfig, retreat
from exploration.devices.guard import Collision, OverPress
from exploration.planning.touching.findings import ExplorerConfig
from exploration.planning.touching.study import Study
from exploration.planning.ways.round_ball import Ball, way_round
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.evidence import Contacts

Policy = Literal["closure", "grid", "random", "raster"]
POLICIES: tuple[Policy, ...] = ("closure", "grid", "random", "raster")


@dataclass(frozen=True)
class SurveyConfig:
    """Where touches begin and how dense they are."""

    far: float = 150.0  # [mm] from the middle, where an approach begins
    rings: int = 12  # at most, round the middle of a side
    strokes: float = 400.0  # [mm] of a raster's line


class Survey:
    """One policy without thought."""

    def __init__(
        self,
        study: Study,
        policy: Policy,
        config: ExplorerConfig,
        rng: np.random.Generator,
        own: SurveyConfig | None = None,
    ) -> None:
        self.study, self.policy, self.config, self.rng = study, policy, config, rng
        self.own = own or SurveyConfig()
        self.pad = study.pad
        self.middle = self.pad.here.point
        self.spacing = min(self.pad.size) + self.config.feature
        study.config = replace(study.config, convex=False)

    def run(self) -> Iterator[str]:
        """Touch after touch, until the budget or the grid ends; yields what each one did."""
        retreat(self.pad.guard, self.own.far)
        tries = self._random() if self.policy == "random" else self._rings()
        for start in tries:
            if self.config.spent(self.pad.guard.cost):
                return
            yield self._touch(start)

    def _rings(self) -> Iterator[Floats]:
        for side in (*np.eye(3), *-np.eye(3)):
            turn = se3.frame_along(-side)
            for ring in range(self.own.rings):
                self._hit = False
                steps = range(-ring, ring + 1)
                for i, j in ((i, j) for i in steps for j in steps if max(abs(i), abs(j)) == ring):
                    aside = turn @ np.array([i * self.spacing, j * self.spacing, 0.0])
                    yield se3.pose(turn, self.middle + self.own.far * side + aside)
                if not self._hit and ring:
                    break

    def _random(self) -> Iterator[Floats]:
        while True:
            side = self.rng.normal(size=3)
            side /= np.linalg.norm(side)
            turn = se3.frame_along(-side)
            felt = Contacts.concatenate([f.contacts for f in self.study.found.graph.faces]).points
            reach = float(np.ptp(felt, axis=0).max()) / 2.0 + self.spacing if len(felt) else self.spacing
            aside = turn @ np.array([*self.rng.uniform(-reach, reach, 2), 0.0])
            yield se3.pose(turn, self.middle + self.own.far * side + aside)

    _hit = False

    def _touch(self, start: Floats) -> str:
        guard, pad = self.pad.guard, self.pad
        for pose in way_round(guard.world_from_sensor, start, Ball(self.middle, self.own.far - 10.0)):
            guard.go_to(pose)
        try:
            met = pad.come_down(start[:3, 2], 2.0 * self.own.far, ApproachConfig().search_speed)
            if met:
                self._hit = True
                self.study.take_in(pad.feel())
                if self.policy == "raster":
                    self._line()
        except (Collision, OverPress) as error:
            self.study.found.warnings.append(str(error))
            met = False
        here = guard.world_from_sensor
        back = max(0.0, self.own.far - float((here[:3, 3] - self.middle) @ -here[:3, 2]))
        retreat(guard, back)
        self._center()
        return "touched by plan" if met else "touched by plan and met nothing"

    def _line(self) -> None:
        for sign in (1.0, -1.0):
            stroke = self.pad.stroke(np.array([sign, 0.0]), self.own.strokes)
            if len(stroke.contacts):
                self.study.take_in(stroke.contacts)
            if stroke.ended in ("wall", "lost"):
                return

    def _center(self) -> None:
        felt = Contacts.concatenate([f.contacts for f in self.study.found.graph.faces]).points
        if len(felt):
            self.middle = 0.5 * (felt.min(axis=0) + felt.max(axis=0))
