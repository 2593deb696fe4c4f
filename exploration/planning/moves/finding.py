"""Finding an object of unknown place, and again where a touch named no face of it."""

from __future__ import annotations

import numpy as np

from exploration.control.procedures.approach import ApproachConfig, retreat
from exploration.control.procedures.settle import SettleConfig
from exploration.devices.guard import Collision, OverPress
from exploration.planning.known.told import Told
from exploration.planning.touching.findings import Done, ExplorerConfig
from exploration.planning.touching.study import Study
from exploration.planning.ways.search import beside_first, coarse_first, from_above, not_below
from primitives import pose as se3
from primitives.arrays import Floats

_SHORT = 5.0  # [mm] of the end of a sweep, from where something stopped it
_GOLDEN = 0.6180339887498949  # of what was touched, from one look to the next: spreads them evenly
_AT_ONE_PLACE = 8  # looks, after which the search goes on where nothing was ever lain on


class Finding:
    """The approaches of one exploration that look for its object in a (6,) box [mm]."""

    def __init__(self, study: Study, box: Floats, config: ExplorerConfig, told: Told | None) -> None:
        self.study, self.pad, self.guard = study, study.pad, study.pad.guard
        self.box, self.config, self.told = box, config, told
        self.touches = 0  # until it was found
        self.looked = 0  # times that the object was looked for again
        self._met: Floats | None = None  # (4, 4) where it was found
        self._left: list[tuple[Floats, Floats]] | None = None  # ways down that were not gone yet

    def find(self) -> bool:
        """Sweep the workspace, or on over it, until something is met; false where nothing is.

        An object that nothing holds up is near the middle; what lies on a table is at the bottom, and noise there
        may let a pad settle onto the table.
        """
        floor = self.box[2] if self.told is None else max(self.box[2], self.told.floor)
        box = np.array([*self.box[:2], floor, *self.box[3:]])
        if self._left is None:
            standing = self.told is not None
            self._left = list(coarse_first(box, self.pad.size, self.config.feature, standing))
        while self._left and not self.config.spent(self.guard.cost):
            start, end = self._left.pop(0)
            begun = self.pad.way_back.length
            try:
                for stop in from_above(self.guard.world_from_sensor, start, box[5]):
                    self.guard.go_to(stop)
                begun = self.pad.way_back.length
                distance = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))
                settled = self.pad.come_down(start[:3, 2], distance, ApproachConfig().search_speed)
                if (settled or self.pad.touches()) and not self.pad.on_told():
                    self._left[:0] = self._met_on(start, end)
                    return True
                place = self.guard.world_from_sensor[:3, 3]
            except (OverPress, Collision) as error:
                self.study.found.warnings.append(str(error))
                place = (error.seen.world_from_sensor if error.seen else self.guard.world_from_sensor)[:3, 3]
            if place[2] > end[2, 3] + _SHORT:
                self._go_back(begun)
                self._left = beside_first(not_below(self._left, place), place)
        return False

    def _met_on(self, start: Floats, end: Floats) -> list[tuple[Floats, Floats]]:
        """Note where something was met on a way down; the rest of that way, but where it was met there before."""
        self.touches = self.guard.cost.touches
        here, before = self.guard.world_from_sensor, self._met
        self._met = here
        again = before is not None and float(np.linalg.norm((here - before)[:3, 3])) < 2.0 * _SHORT
        if again or here[2, 3] <= end[2, 3]:
            return []
        return [(se3.pose(start[:3, :3], here[:3, 3] + [0.0, 0.0, _SHORT]), end)]

    def _go_back(self, begun: int) -> None:
        """The way it came since the trail had a length: straight up may be shut, as in a bowl that lies aslant."""
        for stop in self.pad.way_back.since(begun):
            try:
                self.guard.go_to(stop)
            except (OverPress, Collision) as error:
                self.study.found.warnings.append(str(error))
                return

    def look_again(self) -> Done:
        """Come down again where something was touched, each time elsewhere and from another side.

        Where a pad never lay on anything, what passed for a touch may have been a disturbed signal: after some
        looks the search goes on.
        """
        cells = np.concatenate([np.empty((0, 3)), *(points for points, _ in self.pad.felt)])
        facing = np.concatenate([np.empty((0, 3)), *(normals for _, normals in self.pad.felt)])
        tried = self.looked
        self.looked += 1
        retreat(self.guard, 15.0)
        if not len(cells) and self.looked % _AT_ONE_PLACE == 0:
            met, self.touches = self.find(), self.guard.cost.touches
            if met:
                return self.study.face_here(), "met something elsewhere"
        here = self.guard.world_from_sensor if self._met is None else self._met
        point, normal = here[:3, 3], -here[:3, 2]
        if len(cells):
            one = int(len(cells) * (tried * _GOLDEN % 1.0))
            point, normal = cells[one], facing[one]
        level = se3.pose(self.pad.attitude(normal, here[:3, 0]), point)
        turn = se3.turn_about(point, level[:3, tried % 2], 0.35 * (-1.0) ** (tried // 2))
        back = turn @ level @ se3.pose(translation=[0.0, 0.0, -15.0])
        self.guard.go_to(back)
        settling = SettleConfig(shifts=0) if tried % 3 else None  # what is narrow is not rolled off
        if not self.pad.touch(turn @ level, 15.0, 25.0, settling):
            self.guard.go_to(back)
            return None, "looked for the object again in vain"
        return self.study.face_here(), "came down where something was touched"
