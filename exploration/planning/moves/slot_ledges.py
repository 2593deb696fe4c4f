"""Feeling the floor of a pocket that has a narrower hole in its middle: a small array comes down at its sides.

Where an array went through the middle of a mouth and met nothing, a ledge may yet run round inside it.  Half over
one an array feels no face, but where it was stopped it feels well enough (our derivation).  Where the face behind
is missing as well there is none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.control.dwell import dwell
from exploration.control.procedures.approach import ApproachConfig, advance
from exploration.control.procedures.tare import tare
from exploration.devices.guard import Collision, Observation, OverPress
from exploration.planning.open.mouths import Mouth
from exploration.planning.touching.findings import Done
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from primitives import pose as se3
from primitives.arrays import Floats


@dataclass(frozen=True)
class SlotLedgesConfig:
    """Where an array comes down, and what it is stopped by."""

    clear: float = 1.0  # [mm] between its housing and where the face of the mouth begins
    least: float = 2.5  # [mm] beside the middle, where it was
    before: float = 4.0  # [mm] over the mouth, from where it comes
    out: float = 4.0  # [mm] of the housing that stay out of the mouth
    floor: float = 1.5  # [mm] behind the mouth, from where what stops it is a ledge
    places: int = 4  # of it, at least
    share: float = 0.8  # of the strongest taxel, from which one lies on the ledge with all of itself
    behind: float = -0.95  # cosine from which a face looks the other way
    edge: float = 1.5  # [mm] within the end of a way across, where a face may be blurred
    beside: float = 4.0  # [mm] beside such a way, that is still open


class SlotLedges:
    """Those of one exploration's mouths."""

    def __init__(self, study: Study, reach: Reach, config: SlotLedgesConfig = SlotLedgesConfig()) -> None:
        self.study, self.reach, self.config = study, reach, config
        self._waiting: list[Mouth] = []

    def went_through(self, mouth: Mouth) -> None:
        """Remember a mouth in whose middle an array met nothing."""
        self._waiting.append(mouth)

    def next(self, across: Sequence[Mouth]) -> Mouth | None:
        """A mouth in which there may be a ledge, as all ways `across` mouths tell."""
        while self._waiting and not self._poses(self._waiting[0], across):
            self._waiting.pop(0)
        return self._waiting[0] if self._waiting else None

    def feel(self, across: Sequence[Mouth]) -> Done:
        """Come down at both sides of the mouth that is next."""
        mouth = self._waiting.pop(0)
        met = [
            places for pose in self._poses(mouth, across) if (places := self._down(pose, mouth)) is not None
        ]
        homes = [self.study.narrow_face(places, mouth.normal) for places in met]
        home = next((home for home in homes if home is not None), None)
        return home, "felt a ledge in a mouth" if met else "felt no ledge in a mouth"

    def _poses(self, mouth: Mouth, across: Sequence[Mouth]) -> list[Floats]:
        """(4, 4) poses over the sides of a mouth where the array has room, and a ledge may be."""
        shift = 0.5 * mouth.width - float(self.study.pad.tool.high[:2].max()) - self.config.clear
        if shift < self.config.least:
            return []
        turn = se3.frame_along(-mouth.normal, mouth.across)
        sides = [mouth.center + sign * shift * mouth.across for sign in (1.0, -1.0)]
        poses = [
            se3.pose(turn, side + self.config.before * mouth.normal)
            for side in sides
            if not self._open_behind(side, mouth.normal, across)
        ]
        return self.reach.with_room(poses) if poses else []

    def _open_behind(self, place: Floats, normal: Floats, across: Sequence[Mouth]) -> bool:
        """Whether a face that looks the other way is missing behind a (3,) place, too."""
        for other in across:
            if float(other.normal @ normal) < self.config.behind:
                away = other.center - place
                wide = float(away @ other.across)
                off = away - wide * other.across - float(away @ other.normal) * other.normal
                if (
                    abs(wide) < 0.5 * other.width - self.config.edge
                    and np.linalg.norm(off) < self.config.beside
                ):
                    return True
        return False

    def _down(self, over: Floats, mouth: Mouth) -> Floats | None:
        """(n, 3) places of what stopped an array that came down from a (4, 4) pose over a mouth."""
        pad, config = self.study.pad, self.config
        if not self.reach.go(over):
            return None
        pad.count_touch()
        tare(pad.guard)
        long = config.before - float(pad.tool.low[2]) - config.out
        try:
            seen = advance(pad.guard, over[:3, 2], long, ApproachConfig().speed)
            places = None if seen is None else self._under(dwell(pad.guard))
        except (Collision, OverPress) as fault:
            self.study.found.warnings.append(str(fault))
            places = None
        pad.guard.go_to(over)
        if places is None or len(places) < config.places:
            return None
        deep = float((mouth.center - places.mean(axis=0)) @ mouth.normal)
        return places if deep > config.floor else None

    def _under(self, seen: Observation) -> Floats:
        """(n, 3) places of the taxels that lie on what stopped an array with all of themselves."""
        depth = np.where(np.isfinite(seen.image.sigma), seen.image.depth, 0.0)
        rows, columns = np.nonzero(depth > self.config.share * depth.max())
        x, y = seen.image.array.x[columns], seen.image.array.y[rows]
        pressed = np.column_stack([x, y, -depth[rows, columns]])
        return se3.transform_points(seen.world_from_sensor, pressed)
