"""Feeling the walls of round holes that an array has room in: it goes in along the axis, and then aside.

No taxel looks sideways, but a corner of the array stops at the wall.  Four stops tell a circle.  The rim that was
looked at tells it better where it is sharp; where it is chamfered or rounded, the hole is narrower than that, and
in a round face, which the skin leaves before the rim, no look tells how wide it is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from exploration.control.procedures.approach import ApproachConfig, advance, retreat
from exploration.control.procedures.tare import tare
from exploration.devices.guard import Collision, OverPress
from exploration.planning.open.round_rims import RoundRim
from exploration.planning.touching.findings import Attempts, Bore, Done
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from primitives import pose as se3
from primitives.arcs import circle_through
from primitives.arrays import Floats
from primitives.fit import Fit
from primitives.pose import frame_along
from primitives.shapes import Shape

_STEPS = 6  # down to where a rim is
_STEEP = 0.2  # least cosine between a face's normal and the axis, on the way there


@dataclass(frozen=True)
class BoresConfig:
    """How deep an array goes in, and how it goes aside."""

    spare: float = 1.2  # [mm] between its corners and the rim, at least
    before: float = 4.0  # [mm] over the mouth, from where it comes
    deep: float = 4.5  # [mm] behind the mouth, where it goes aside: past a chamfer, but not past a step,
    least: float = 3.0  # or less, where a floor is met before; but not less than that
    lift: float = 1.0  # [mm] off that floor
    speed: float = 8.0  # [mm/s] aside
    past: float = 1.5  # [mm] past where the rim is, after which there is no wall,
    sigmas: float = 4.0  # of its radius, on top of that
    ways: int = 4  # round the axis, that are tried to come in
    beside: float = 4.0  # [mm] between rims, or a rim and the axis of another, that are of one hole
    opposed: float = 0.98  # least cosine between the axes of its two ends
    few: int = 3  # stops that tell a circle


class Bores:
    """The holes of one exploration that an array went into."""

    def __init__(self, study: Study, reach: Reach, config: BoresConfig = BoresConfig()) -> None:
        self.study, self.reach, self.config = study, reach, config
        self._tried = Attempts(1, config.beside)

    def next(self, gaps: Sequence[RoundRim] = ()) -> Callable[[], Done] | None:
        """Into the nearest hole whose wall nobody has felt; `gaps` are mouths in round faces."""
        here = self.study.pad.guard.world_from_sensor[:3, 3]
        left = [rim for rim in (*self.study.found.rims, *gaps) if self._worth(rim)]
        if not left:
            return None
        nearest = min(left, key=lambda rim: float(np.linalg.norm(rim.center - here)))
        return partial(self._feel, nearest)

    def _worth(self, rim: RoundRim) -> bool:
        """Whether the array fits into a hole that was not tried, from here or from its other end."""
        corner = float(np.hypot(*self.study.pad.tool.high[:2]))
        if not rim.measured or rim.radius < corner + self.config.spare or self._tried.given_up(rim.center):
            return False
        return not any(self._of(bore, rim) for bore in self.study.found.bores)

    def _of(self, bore: Bore, rim: RoundRim) -> bool:
        """Whether what was felt is the wall of a rim's hole.

        The two ends of a hole across a round body tell how it runs, so that each is worth its own.
        """
        away = rim.center - bore.center
        up = float(away @ bore.axis)
        off = float(np.linalg.norm(away - up * bore.axis))
        along = abs(float(bore.axis @ rim.axis)) > self.config.opposed
        return along and off < self.config.beside and (abs(up) < rim.radius or not rim.bent)

    def _lowest(self, rim: RoundRim) -> RoundRim:
        """The rim where all of it is material: in a round face it runs down from the face's crest."""
        if not rim.bent:
            return rim
        shape, around, down = self._shape(rim), rim.places()[0], np.zeros(24)
        for _ in range(_STEPS):
            places = around - down[:, None] * rim.axis
            slope = np.maximum(shape.normals(places) @ rim.axis, _STEEP)
            down += shape.signed_distance(places) / slope
        return replace(rim, center=rim.center - down.max() * rim.axis)

    def _shape(self, rim: RoundRim) -> Shape:
        """Of the face that a rim is in."""
        fit = self.study.found.graph.face(rim.face).fit
        assert isinstance(fit, Fit)
        return fit.shape

    def _feel(self, rim: RoundRim) -> Done:
        self._tried.note(rim.center)
        rim = self._lowest(rim)
        pad, config, down = self.study.pad, self.config, -rim.axis
        for way in rim.places(config.ways)[1]:
            over = se3.pose(frame_along(down, way), rim.center + config.before * rim.axis)
            if self.reach.with_room([over]) and self.reach.go(over):
                break
        else:
            return None, "no way led into a hole"
        pad.count_touch()
        tare(pad.guard)
        try:
            if advance(pad.guard, down, config.before + config.deep, ApproachConfig().speed) is not None:
                retreat(pad.guard, config.lift)
            home = pad.guard.world_from_sensor
            deep = float((rim.center - home[:3, 3]) @ rim.axis)
            stops = self._stops(home, rim) if deep > config.least else np.empty((0, 3))
        except (Collision, OverPress) as fault:
            self.study.found.warnings.append(str(fault))
            stops = np.empty((0, 3))
        here = pad.guard.world_from_sensor
        out = float((over[:3, 3] - here[:3, 3]) @ rim.axis) * rim.axis
        pad.guard.go_to(se3.pose(here[:3, :3], here[:3, 3] + out))
        flat = frame_along(rim.axis)[:, :2]
        circle = circle_through((stops - rim.center) @ flat) if len(stops) >= config.few else None
        if circle is None:
            return None, "felt no wall in a hole"
        at = float((rim.center - stops.mean(axis=0)) @ rim.axis)
        center = rim.center + flat @ circle[0]
        axis = self._shape(rim).normals(center[None])[0] if rim.bent else rim.axis
        self.study.found.bores.append(Bore(center, axis, circle[1], at))
        return None, "felt the wall of a hole"

    def _stops(self, home: Floats, rim: RoundRim) -> Floats:
        """(n, 3) where corners of the array were stopped, that went from a (4, 4) pose on the axis aside."""
        pad, config, stops = self.study.pad, self.config, list[Floats]()
        half = pad.tool.high[:2]
        corner = float(np.hypot(*half))
        past = config.past + config.sigmas * rim.sigma
        for signs in ((1.0, 1.0), (-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)):
            lead = home[:3, :2] @ (half * signs)
            try:
                advance(pad.guard, lead / corner, rim.radius - corner + past, config.speed)
            except (Collision, OverPress) as met:  # housing or skin, whichever is first
                if met.seen is not None:
                    stops.append(met.seen.world_from_sensor[:3, 3] + lead)
            pad.guard.go_to(home)
        return np.array(stops).reshape(-1, 3)
