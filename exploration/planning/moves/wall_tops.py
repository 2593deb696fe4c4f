"""Looks at the tops of walls that are too narrow for a pad to lie on.

A flat side ends at a rim, and nothing that an array could lie on is behind it: the wall may be a few millimeters
thick, as of a box or a channel.  The pad comes down across its top, upright on the rim and at the attitude it came
at, and sees how thick the wall is (`sensing.lines.ridge`).  That makes the top a face, and its far edge a rim.

What stopped strokes on a floor, and nobody could lie on, may be a lip or a rib: the pad comes down across it in
the same way, and sees both its edges.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from exploration.control.dwell import dwell
from exploration.control.procedures.land import AS_TOLD
from exploration.control.procedures.settle import AS_IT_CAME
from exploration.control.sighting import Sighting
from exploration.devices.guard import Observation
from exploration.planning.touching.findings import Attempts, Done, SeenRim, outward_normal
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.stops import Stop
from exploration.planning.touching.study import Study
from exploration.sensing.lines.ridge import Ridge, fit_ridge
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shapes import Plane


@dataclass(frozen=True)
class WallTopsConfig:
    """How tops are looked at."""

    frames: int = 16  # averaged
    vain: int = 6  # looks on end that made no top out, from which no more are taken
    beside: float = 12.0  # [mm] between rims that are tried as one
    shifts: tuple[float, ...] = (0.0, 16.0, -16.0)  # [mm] along a wall, in turn: another may join it there
    inside: float = 1.2  # [mm] of the pad's middle behind the outer side
    known: float = 2.5  # [mm] from a rim, within which a face explains it that looks its way,
    felt: float = 16.0  # [mm] and was felt within
    looks_out: float = 0.3  # least cosine between that face and the way out of the rim
    looks_back: float = -0.9  # most cosine between a wall's sides
    step: float = 0.6  # [mm] over a floor, from which something stands on it
    slack: float = 1.5  # [mm] of its side from where a housing was stopped
    thickest: float = 12.0  # [mm] to a side that looks away from the outer one: its rim tells as much


class WallTops:
    """The narrow tops of one exploration."""

    def __init__(self, study: Study, reach: Reach, config: WallTopsConfig = WallTopsConfig()) -> None:
        self.study, self.reach, self.config = study, reach, config
        self._tried, self._vain = Attempts(1, config.beside), 0

    def next(self, rims: Sequence[SeenRim]) -> Callable[[], Done] | None:
        """A look at the top that the nearest rim of a flat side is of, if none was looked at there."""
        here = self.study.pad.guard.world_from_sensor[:3, 3]
        left = [(rim, face) for rim, face in rims if self._worth(rim, face)]
        if not left or self._vain >= self.config.vain:
            return None
        return partial(self._look, *min(left, key=lambda seen: float(np.linalg.norm(seen[0].point - here))))

    def over(self, stops: Sequence[Stop]) -> Callable[[], Done] | None:
        """A look at the top of what stopped the nearest stroke on a floor, if none was looked at there."""
        here = self.study.pad.guard.world_from_sensor[:3, 3]
        left = [stop for stop in stops if not self._tried.given_up(stop.wall.point)]
        if not left or self._vain >= self.config.vain:
            return None
        nearest = min(left, key=lambda stop: float(np.linalg.norm(stop.wall.point - here)))
        return partial(self._look_over, nearest)

    def _look_over(self, stop: Stop) -> Done:
        self._tried.note(stop.wall.point)
        pad, up = self.study.pad, stop.wall.normal
        side = stop.normal - float(stop.normal @ up) * up
        side = side / np.linalg.norm(side)
        foot = stop.wall.pose[:3, 3]
        foot = foot + (stop.offset - float(stop.normal @ foot)) * stop.normal
        over = se3.pose(pad.attitude(up, stop.along), foot - self.config.inside * side)
        high = self.reach.off(over, float(((self.reach.felt.points - foot) @ up).max(initial=0.0)))
        raised = over @ se3.pose(translation=[0.0, 0.0, -high])
        if not self.reach.descend(raised, high, AS_IT_CAME, AS_TOLD, deeper=high):
            found = "nothing narrow was" if self.reach.led else "no way led over"
            return None, f"{found} where a stroke was stopped"
        if float((pad.guard.world_from_sensor[:3, 3] - foot) @ up) < self.config.step:
            return None, "nothing narrow was where a stroke was stopped"
        seen = dwell(pad.guard, self.config.frames)
        ridge = fit_ridge(seen.image, seen.world_from_sensor, foot, side, self.config.slack)
        if ridge is None or not self._take_in(ridge, foot + ridge.shift * side, side, up, both=True):
            self._vain += 1
            return None, "no top of a thin wall was made out"
        return None, "looked at the top of a thin wall"

    def _worth(self, rim: Sighting, face: int) -> bool:
        """Whether the rim is of a flat side, and nothing is known of a face or a side behind it."""
        own = self.study.found.fit_of(face)
        if own is None or own.kind != "plane" or self._tried.given_up(rim.point):
            return False
        return not any(self._told(rim, face, other) for other in self.study.found.graph.faces)

    def _told(self, rim: Sighting, face: int, other: Face) -> bool:
        """Whether another face is the top, or the wall's far side."""
        felt = other.contacts.points[other.contacts.touch != NOT_FELT]
        if other.id == face or not isinstance(other.fit, Fit) or not len(felt):
            return False
        near = float(np.linalg.norm(felt - rim.point, axis=1).min())
        way = outward_normal(other, rim.point)
        off = float(abs(other.fit.shape.signed_distance(rim.point[None])[0]))
        top = off < self.config.known and float(way @ rim.outward) > self.config.looks_out
        far_side = off < self.config.thickest and float(way @ rim.normal) < self.config.looks_back
        return (top or far_side) and near < self.config.felt

    def _look(self, rim: Sighting, face: int) -> Done:
        self._tried.note(rim.point)
        fit = self.study.found.fit_of(face)
        if fit is None or not isinstance(fit.shape, Plane):
            return None, "a face with a rim is none any more"
        side = fit.shape.direction * (1.0 if fit.convex else -1.0)
        up = rim.outward - float(rim.outward @ side) * side
        up = up / np.linalg.norm(up)
        foot = rim.point - float(fit.shape.signed_distance(rim.point[None])[0]) * fit.shape.direction
        along, looked = np.cross(side, up), False
        for shift in self.config.shifts:
            there = foot + shift * along
            if shift and not self._felt_below(face, there):
                continue
            seen = self._pressed(there - self.config.inside * side, up, along, side)
            if seen is None:
                continue
            looked, ridge = True, fit_ridge(seen.image, seen.world_from_sensor, there, side)
            if ridge is not None and self._take_in(ridge, there, side, up):
                return None, "looked at the top of a thin wall"
        self._vain += looked
        return None, "no top of a thin wall was made out" if looked else "no way led to the top of a wall"

    def _pressed(self, at: Floats, up: Floats, along: Floats, side: Floats) -> Observation | None:
        """What a pad sees that lies across a wall at a (3,) place of its top, along the wall or across it."""
        for give in (False, True):
            for way in (along, side):
                over = se3.pose(self.study.pad.attitude(up, way), at)
                if self.reach.touch(over, give, AS_IT_CAME, AS_TOLD):
                    return dwell(self.study.pad.guard, self.config.frames)
        return None

    def _felt_below(self, face: int, place: Floats) -> bool:
        """Whether a side was felt near a (3,) place of its rim: it goes on there."""
        own = next(each for each in self.study.found.graph.faces if each.id == face)
        near = np.linalg.norm(own.contacts.points - place, axis=1).min(initial=np.inf)
        return bool(near < self.config.felt)

    def _take_in(self, ridge: Ridge, foot: Floats, side: Floats, up: Floats, both: bool = False) -> bool:
        """The top as a face, and the rim at its far edge, or at `both`; false where its places are on no plane."""
        number = self.study.narrow_face(ridge.top, up)
        if number is None:
            return False
        self._vain = 0
        along = np.cross(side, up)
        spread = (ridge.top - foot) @ along
        middle = foot + 0.5 * float(spread.min() + spread.max()) * along
        middle = middle + float(np.median((ridge.top - middle) @ up)) * up
        length = float(np.ptp(spread))
        edges = [Sighting(middle - ridge.thick * side, along, -side, up, ridge.far_sigma, length)]
        edges += [Sighting(middle, along, side, up, ridge.side_sigma, length)] if both else []
        self._tried.note(*(edge.point for edge in edges))
        self.study.found.wall_rims += [(edge, number) for edge in edges]
        return True
