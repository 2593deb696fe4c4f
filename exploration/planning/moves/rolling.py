"""Rolling over a rim that no known face explains, onto the face behind it.

A rim that was come over three times in vain is left alone, and so are all rims of a face once several of them led
to nothing: round a flange or a rounded corner a rim shows everywhere, and nowhere leads farther.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import product

import numpy as np

from exploration.control.procedures.settle import NARROW
from exploration.control.sighting import Sighting
from exploration.planning.touching.findings import Attempts, Done, SeenRim, outward_normal
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from primitives import pose as se3
from primitives.fit import Fit


@dataclass(frozen=True)
class RollingConfig:
    """How a rim is come over, and how often."""

    rolls: tuple[float, ...] = (90.0, 60.0, 120.0)  # [deg] over a rim, in turn
    asides: tuple[float, ...] = (0.0, 7.0, -7.0)  # [mm] along it, in turn
    overlap: float = 0.22  # of the pad's shorter side, that stays over the rim
    tries: int = 3  # at one rim
    beside: float = 9.0  # [mm] between tries that count as one
    vain: int = 8  # over rims of one face, that led to no other, since one led to a new one; then no more
    opposed: float = 0.9  # least cosine between a face and the reverse of another, that bound a plate
    least_thick: float = 0.5  # [mm] of a plate


class Rolling:
    """The rims of one array's exploration."""

    def __init__(self, study: Study, reach: Reach, config: RollingConfig = RollingConfig()) -> None:
        self.study, self.reach, self.config = study, reach, config
        self._tried = Attempts(config.tries, config.beside)
        self._vain: dict[int, int] = {}  # by the face that ends there

    def ways(self, rims: Sequence[SeenRim]) -> list[tuple[float, Callable[[], Done]]]:
        """Seconds to each rim that is worth a try, and the move."""
        return [
            (float(self.reach.seconds_to(rim.point, rim.outward)), partial(self._cross, rim, face))
            for rim, face in rims
            if self._vain.get(face, 0) < self.config.vain
            and not self._tried.given_up(rim.point)
            and not self.reach.at_lid(rim.point)
        ]

    def _cross(self, rim: Sighting, face: int) -> Done:
        before = self.study.found.named
        home, note = self._roll_over(rim)
        if self.study.found.named - before:
            self._vain[face] = 0
        elif self.reach.led and home in (None, face):
            self._vain[face] = self._vain.get(face, 0) + 1
        return home, note

    def _roll_over(self, rim: Sighting) -> Done:
        pad, config = self.study.pad, self.config
        tried = self._tried.count(rim.point) % len(config.rolls)
        self._tried.note(rim.point)
        beyond, settling = (0.5 - config.overlap) * min(pad.size), None
        if (thick := self._thickness(rim)) is not None:
            beyond, settling = 0.5 * thick, NARROW
        rolls = config.rolls[tried:] + config.rolls[:tried]
        for give, roll, aside in product((False, True), rolls, config.asides):
            angle = np.radians(roll)
            normal = np.cos(angle) * rim.normal + np.sin(angle) * rim.outward
            down = np.cos(angle) * rim.outward - np.sin(angle) * rim.normal
            at = rim.point + beyond * down + aside * rim.tangent
            if self.reach.touch(se3.pose(pad.attitude(normal, rim.tangent), at), give, settling):
                return self.study.face_here(), "crossed a rim"
            if self.reach.led:
                return None, "crossed a rim and met nothing"
        return None, "no way led over a rim"

    def _thickness(self, rim: Sighting) -> float | None:
        """[mm] from a rim to the face behind its own, where the pad is wider than that: it would roll off."""
        behind = [
            abs(float(face.fit.shape.signed_distance(rim.point[None])[0]))
            for face in self.study.found.graph.faces
            if isinstance(face.fit, Fit)
            and outward_normal(face, rim.point) @ rim.normal < -self.config.opposed
        ]
        thick = min(behind, default=np.inf)
        return thick if self.config.least_thick < thick < min(self.study.pad.size) else None
