"""Finding an object of unknown place, and again where a touch named no face of it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exploration.control.procedures.approach import ApproachConfig, retreat
from exploration.control.procedures.settle import NARROW
from exploration.devices.guard import Collision, OverPress
from exploration.planning.known.told import Told
from exploration.planning.touching.findings import Done, ExplorerConfig
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.planning.ways.search import beside_first, coarse_first, from_above, not_below
from primitives import pose as se3
from primitives.arrays import Floats

_SHORT = 5.0  # [mm] of the end of a sweep, from where something stopped it
_GOLDEN = 0.6180339887498949  # of what was touched, from one look to the next: spreads them evenly
_AT_ONE_PLACE = 8  # looks, after which the search goes on where nothing was ever lain on
_SLENDER = 0.3  # times as wide as long, at most, is contact along a ridge,
_LONG = 8.0  # [mm] its length at least,
_ALONG = 0.9  # of a unit normal along a ridge, and it tells no side of it
_ROUND = 0.7  # [rad] the turn about it from one look to the next


class Finding:
    """The approaches of one exploration that look for its object in a (6,) box [mm]."""

    def __init__(self, study: Study, box: Floats, config: ExplorerConfig, told: Told | None) -> None:
        self.study, self.pad, self.guard = study, study.pad, study.pad.guard
        self.box, self.config, self.told = box, config, told
        self.touches = 0  # until it was found
        self.looked = 0  # times that the object was looked for again
        self._met: Floats | None = None  # (4, 4) where it was found
        self._reach = Reach(self.pad)
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
        felt = [touch for touch in self.pad.felt if len(touch[0])]
        tried = self.looked
        self.looked += 1
        retreat(self.guard, 15.0)
        if not felt and self.looked % _AT_ONE_PLACE == 0:
            met, self.touches = self.find(), self.guard.cost.touches
            if met:
                return self.study.face_here(), "met something elsewhere"
        here = self.guard.world_from_sensor if self._met is None else self._met
        point, normal, ridge = _chosen(felt, tried) if felt else (here[:3, 3], -here[:3, 2], None)
        if ridge is not None:
            level = se3.pose(self.pad.attitude(normal, ridge), point)
            turned = se3.turn_about(point, ridge, _ROUND * (-1.0) ** tried) @ level
            if not self._reach.touch(turned, give=True, settling=NARROW):
                return None, "looked for the object again in vain"
            return self.study.face_here(), "came down where something was touched"
        level = se3.pose(self.pad.attitude(normal, here[:3, 0]), point)
        turn = se3.turn_about(point, level[:3, tried % 2], 0.35 * (-1.0) ** (tried // 2))
        back = turn @ level @ se3.pose(translation=[0.0, 0.0, -15.0])
        self.guard.go_to(back)
        if not self.pad.touch(turn @ level, 15.0, 25.0, NARROW if tried % 3 else None):
            self.guard.go_to(back)
            return None, "looked for the object again in vain"
        return self.study.face_here(), "came down where something was touched"


def _chosen(felt: Sequence[tuple[Floats, Floats]], tried: int) -> tuple[Floats, Floats, Floats | None]:
    """One of the cells that touches felt, evenly spread over the looks; how it faces, and its touch's ridge.

    A pad half over a ridge's end takes it to face along it; the side that it faces besides is kept.
    """
    of = np.repeat(np.arange(len(felt)), [len(cells) for cells, _ in felt])
    one = int(len(of) * (tried * _GOLDEN % 1.0))
    point, normal = (np.concatenate([touch[k] for touch in felt])[one] for k in (0, 1))
    ridge = _ridge(felt[of[one]][0])
    if ridge is None or abs(normal @ ridge) > _ALONG:
        return point, normal, None
    across = normal - (normal @ ridge) * ridge
    return point, across / np.linalg.norm(across), ridge


def _ridge(cells: Floats) -> Floats | None:
    """(3,) unit direction of (n, 3) touched cells that lie along a line; None where they do not."""
    if len(cells) < 3:
        return None
    _, spread, ways = np.linalg.svd(cells - cells.mean(axis=0), full_matrices=False)
    long = float(np.ptp(cells @ ways[0]))
    return np.asarray(ways[0]) if spread[1] < _SLENDER * spread[0] and long > _LONG else None
