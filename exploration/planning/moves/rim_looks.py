"""Looks at the rims of walls that no array has room to face.

The pad lies over a rim that was only guessed, and sees where it is; where that face is flat, every straight edge
that a part of the pad shows is remembered, too.  What walls they are of is inferred in the end.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from exploration.control.procedures.land import AS_TOLD
from exploration.control.sighting import Sighting
from exploration.planning.touching.findings import Attempts, Done, SeenRim
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from primitives import pose as se3


@dataclass(frozen=True)
class RimLooksConfig:
    """How rims are looked at."""

    beside: float = 6.0  # [mm] between rims that are tried as one
    inside: float = 3.0  # [mm] of the pad's middle on the material
    alike: float = 0.85  # least cosine between the ways out of a rim as guessed and as seen
    near: float = 4.0  # [mm] between the two


class RimLooks:
    """Looks at rims behind which no face is known."""

    def __init__(self, study: Study, reach: Reach, config: RimLooksConfig = RimLooksConfig()) -> None:
        self.study, self.reach, self.config = study, reach, config
        self._tried = Attempts(1, config.beside)

    def next(self, rims: Sequence[SeenRim]) -> Callable[[], Done] | None:
        """A look at the nearest rim that was not looked at yet."""
        here = self.study.pad.guard.world_from_sensor[:3, 3]
        left = [rim for rim in rims if not self._tried.given_up(rim[0].point)]
        if not left:
            return None
        return partial(self._look, *min(left, key=lambda rim: float(np.linalg.norm(rim[0].point - here))))

    def _look(self, rim: Sighting, face: int) -> Done:
        self._tried.note(rim.point)
        pad = self.study.pad
        at = rim.point - self.config.inside * rim.outward
        for give in (False, True):
            for along in (rim.tangent, rim.outward):
                over = se3.pose(pad.attitude(rim.normal, along), at)
                if not self.reach.touch(over, give, landing=AS_TOLD):
                    continue
                whole, parts = pad.sightings(), pad.sightings_in_parts() if self._flat(face) else []
                seen, found = self._made_out(rim, whole), self.study.found
                found.wall_rims += [] if seen is None else [(seen, face)]
                found.glimpsed += [(edge, face) for edge in parts]
                if seen is None and self._made_out(rim, parts) is None:
                    return None, "no rim was made out"
                return None, "looked at the rim of a wall that nothing has room to face"
        return None, "no way led to a rim"

    def _flat(self, face: int) -> bool:
        """Whether a face is known to be flat: a part of the pad on a round one shows it end where it curves."""
        fit = self.study.found.fit_of(face)
        return fit is not None and fit.kind == "plane"

    def _made_out(self, rim: Sighting, edges: Sequence[Sighting]) -> Sighting | None:
        """The longest of the edges that were seen where a rim was guessed."""
        there = [
            seen
            for seen in edges
            if seen.outward @ rim.outward > self.config.alike
            and abs(float((seen.point - rim.point) @ rim.outward)) < self.config.near
        ]
        return max(there, key=lambda seen: seen.length, default=None)
