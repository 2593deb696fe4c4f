"""Looks at the rims of walls that no array has room to face.

The pad lies over a rim that was only guessed, and sees where it is; where the surface goes on under all of it, the
pad looks once more farther out; where it rolled off, as off a narrow top, it is pressed there as it came.  Where
that face is flat, every straight edge that a part of the pad shows is remembered, too.  What walls they are of is
inferred in the end.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from exploration.control.feel import feel
from exploration.control.kept_contacts import touched_cells
from exploration.control.procedures.land import AS_TOLD
from exploration.control.procedures.settle import AS_IT_CAME
from exploration.control.sighting import Sighting
from exploration.planning.touching.findings import Attempts, Done, SeenRim
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from primitives import pose as se3
from primitives.arrays import Floats


@dataclass(frozen=True)
class RimLooksConfig:
    """How rims are looked at."""

    beside: float = 6.0  # [mm] between rims that are tried as one
    inside: float = 3.0  # [mm] of the pad's middle on the material
    alike: float = 0.85  # least cosine between the ways out of a rim as guessed and as seen
    aslant: float = 0.5  # least cosine between a guess and the straight lines of a round face that it ends
    steep: float = 0.5  # least sine between a cone's axis and its normals, for it to have straight lines
    behind: tuple[float, float] = (2.0, 12.0)  # [mm] behind an end, where the face was not felt
    across: float = 0.97  # the same, between these and an edge that is such an end
    near: float = 4.0  # [mm] between the two
    shift: float = 3.0  # [mm] aside and farther inside, in steps, where there is no room right over a rim
    seen: float = 3.0  # [mm] of the pad beyond the rim then
    looks: int = 2  # such poses that are tried
    on: float = 0.4  # of the pad's shorter side, that it goes on where the surface does
    border: float = 2.0  # [mm] of the pad, where surface is felt that goes on
    flush: float = 0.999  # least cosine between the pad's normal and that of a face that it lies on


class _Seen(NamedTuple):
    """What a pad over a rim shows."""

    rims: list[Sighting]  # the rim, where the whole pad makes it out, and other ends of a round face
    parts: list[Sighting]  # straight edges that parts of it show
    made_out: bool  # whether either shows the rim


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
        side = self._down_the_side(rim, face)
        if side is not None and abs(along := float(side @ rim.outward)) > self.config.aslant:
            out = side * np.sign(along)  # strokes have left it aslant
            rim = replace(rim, outward=out, tangent=np.cross(rim.normal, out))
        lay, made_out = self._lay_over(rim, face)
        if lay and not made_out and self._goes_on(rim.outward):
            farther = rim.point + self.config.on * min(self.study.pad.size) * rim.outward
            self._tried.note(farther)
            made_out = self._lay_over(replace(rim, point=farther), face)[1]
        if not lay:
            return None, "no way led to a rim"
        if not made_out:
            return None, "no rim was made out"
        return None, "looked at the rim of a wall that nothing has room to face"

    def _lay_over(self, rim: Sighting, face: int) -> tuple[bool, bool]:
        """Whether the pad came to lie over a rim of a face, and whether an edge was seen there."""
        pad, found = self.study.pad, self.study.found
        at = rim.point - self.config.inside * rim.outward
        attitudes = [pad.attitude(rim.normal, along) for along in (rim.tangent, rim.outward)]
        straight = [(se3.pose(attitude, at), give) for give in (False, True) for attitude in attitudes]
        for over, give in itertools.chain(straight, self._aside(rim, attitudes)):
            if not self.reach.touch(over, give, landing=AS_TOLD):
                continue
            seen = self._edges(rim, face)
            try:
                if self._rolled(rim, face) and self.reach.touch(over, give, AS_IT_CAME, AS_TOLD):
                    flush = self._edges(rim, face)
                    seen = flush if flush.made_out else seen
            finally:  # a fault of the second touch leaves what the first one showed
                found.wall_rims += [(edge, face) for edge in seen.rims]
                found.glimpsed += [(edge, face) for edge in seen.parts]
            return True, seen.made_out
        return False, False

    def _edges(self, rim: Sighting, face: int) -> _Seen:
        """What the pad shows of a rim of a face, and beside it."""
        pad, side = self.study.pad, self._down_the_side(rim, face)
        ends = side is not None and abs(float(side @ rim.outward)) > self.config.across
        ends = ends and not self._goes_on(rim.outward)
        heading = _along(pad.guard.world_from_sensor, rim.outward) if ends else None
        whole, parts = pad.sightings(heading), pad.sightings_in_parts() if self._flat(face) else []
        there = self._made_out(rim, whole)
        rims = [] if there is None else [there]
        if side is not None:
            rims += [edge for edge in whole if edge is not there and self._ends(edge, side)]
        return _Seen(rims, parts, there is not None or self._made_out(rim, parts) is not None)

    def _rolled(self, rim: Sighting, face: int) -> bool:
        """Whether the pad settled off the flat face that a rim is of, as it does on the narrow top of a wall."""
        facing = float(-self.study.pad.guard.world_from_sensor[:3, 2] @ rim.normal)
        return self._flat(face) and facing < self.config.flush

    def _aside(self, rim: Sighting, attitudes: Sequence[Floats]) -> Iterator[tuple[Floats, bool]]:
        """(4, 4) poses with room from which part of the pad looks at a rim, those nearest to it first."""
        config, shifts = self.config, []
        for attitude in attitudes:
            across = 0.5 * float(np.abs(attitude[:, :2].T @ rim.outward) @ self.study.pad.size)
            along = np.arange(-0.5 * rim.length, 0.5 * rim.length + config.shift, config.shift)
            inside = np.arange(config.inside, max(across - config.seen, config.inside) + 0.1, config.shift)
            shifts += [
                (abs(aside) + deep, se3.pose(attitude, rim.point - deep * rim.outward + aside * rim.tangent))
                for aside, deep in itertools.product(along, inside)
            ]
        ordered = [pose for _, pose in sorted(shifts, key=lambda item: item[0])]
        free = self.reach.with_room(ordered) if ordered else []
        yield from ((pose, False) for pose in free[: config.looks])

    def _goes_on(self, outward: Floats) -> bool:
        """Whether the surface under the pad reaches the border of the pad that a (3,) direction leads to."""
        seen = self.study.pad.guard.hold()
        if not (felt := feel(seen.image)):
            return False
        here = seen.world_from_sensor
        border = 0.5 * np.abs(here[:3, :2].T @ outward) @ self.study.pad.size
        felt_to = float(((touched_cells(seen, felt) - here[:3, 3]) @ outward).max())
        return felt_to > float(border) - self.config.border

    def _flat(self, face: int) -> bool:
        """Whether a face is known to be flat: a part of the pad on a round one shows it end where it curves."""
        fit = self.study.found.fit_of(face)
        return fit is not None and fit.kind == "plane"

    def _down_the_side(self, rim: Sighting, face: int) -> Floats | None:
        """(3,) straight line of a cylinder's or cone's side at a rim of it; None where a face has none."""
        fit = self.study.found.fit_of(face)
        if fit is None or fit.kind not in ("cylinder", "cone"):
            return None
        normal = fit.shape.normals(rim.point[None])[0]
        line = fit.shape.direction - float(fit.shape.direction @ normal) * normal
        length = float(np.linalg.norm(line))
        return line / length if length > self.config.steep else None

    def _ends(self, edge: Sighting, side: Floats) -> bool:
        """Whether an edge is across a round face's (3,) straight line, and nothing was felt behind it."""
        if abs(float(edge.outward @ side)) < self.config.across:
            return False
        felt = self.reach.felt
        away = felt.points - edge.point
        ahead, aside, off = (away @ way for way in (edge.outward, edge.tangent, edge.normal))
        near, far = self.config.behind
        behind = (ahead > near) & (ahead < far) & (np.abs(aside) < 0.5 * edge.length) & (np.abs(off) < near)
        return not bool((behind & (felt.facing @ edge.normal > self.config.alike)).any())

    def _made_out(self, rim: Sighting, edges: Sequence[Sighting]) -> Sighting | None:
        """The longest of the edges that were seen where a rim was guessed."""
        there = [
            seen
            for seen in edges
            if seen.outward @ rim.outward > self.config.alike
            and abs(float((seen.point - rim.point) @ rim.outward)) < self.config.near
        ]
        return max(there, key=lambda seen: seen.length, default=None)


def _along(world_from_sensor: Floats, way: Floats) -> Floats:
    """(2,) unit direction in the plane of a pad, along a (3,) way in the world."""
    flat = world_from_sensor[:3, :2].T @ way
    return np.asarray(flat / np.linalg.norm(flat))
