"""Feeling how a round hole narrows: a small array comes down in it beside its axis, where its wide end has room.

What stops it is a ledge, as deep wherever it is met, or a slope, the deeper the nearer to the axis; so it comes
down at two distances.  An array half over a ledge feels no face, but where it was stopped it feels well enough
(our derivation).  A hole that has no other end to match may narrow off its axis, or slanting: there a wide ledge
is felt as a floor.  One that is hardly wider than the array is gone down about its axis.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from exploration.control.procedures.approach import ApproachConfig, advance
from exploration.control.procedures.land import strongest
from exploration.control.procedures.settle import AS_IT_CAME
from exploration.control.procedures.tare import tare
from exploration.planning.open.holes import ends_of_one
from exploration.planning.open.round_rims import RoundRim, far_end
from exploration.planning.touching.findings import Attempts, Done, Stopped
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from primitives import pose as se3
from primitives.arrays import Floats
from primitives.evidence import Contacts


@dataclass(frozen=True)
class LedgesConfig:
    """Where an array comes down."""

    clear: float = 0.8  # [mm] between its housing and the rim
    spare: float = (
        0.4  # [mm] between its corners and the wall, where it goes down the middle of a measured one
    )
    covers: float = 1.0  # [mm] of the ledge, at least, that its skin must reach over
    nearer: float = 2.5  # [mm] to the axis, of the second time
    before: float = 4.0  # [mm] over the mouth, from where it comes
    ways: int = 8  # round the axis, that are looked at for room
    beside: float = 4.0  # [mm] between rims that are tried as one
    past: float = 2.0  # [mm] behind the far end
    aside: float = 6.0  # [mm] from the axis, at least, where a floor is felt that has a hole in its middle
    floor_ways: int = 4  # round the axis, that are tried for it
    floor: float = 2.0  # [mm] behind the rim, from where what was felt is one


class Ledges:
    """The holes of one exploration that are wider at one end."""

    def __init__(self, study: Study, reach: Reach, config: LedgesConfig = LedgesConfig()) -> None:
        self.study, self.reach, self.config = study, reach, config
        self._tried = Attempts(1, config.beside)

    def next(self, guessed: Sequence[RoundRim]) -> Callable[[], Done] | None:
        """A hole that was not felt yet; the far end of one may be only `guessed`."""
        rims = self.study.found.rims
        for rim in rims:
            other = far_end(rim, [*rims, *guessed])
            if other is not None and not self._tried.given_up(rim.center):
                return partial(self._feel, rim, other)
        for rim in rims:
            aside, left = self._most(rim), [other for other in rims if other is not rim]
            if (
                rim.measured
                and (aside > self.config.aside or self._fits(rim))
                and not self._tried.given_up(rim.center)
                and not any(ends_of_one(rim, other) for other in left)
                and not self._floored(rim)
            ):
                return (
                    partial(self._feel_floor, rim, aside)
                    if aside > self.config.aside
                    else partial(self._go_down, rim)
                )
        return None

    def _fits(self, rim: RoundRim) -> bool:
        """Whether the array just has room about a hole's axis, where what was felt at its rim seems to bar it."""
        corner = float(np.hypot(*self.study.pad.tool.high[:2]))
        return bool(corner + self.config.spare < rim.radius)

    def _go_down(self, rim: RoundRim) -> Done:
        """Come down about a hole's axis, and press whatever it ends at, until a frame tells a face."""
        self._tried.note(rim.center)
        place = rim.center + self.config.before * rim.axis
        led = met = False
        for way in rim.places(self.config.floor_ways)[1]:
            sounded = self.reach.sound(se3.pose(se3.frame_along(-rim.axis, way), place), AS_IT_CAME)
            led, met = led or self.reach.led, met or sounded
            felt = self.study.pad.feel() if sounded else Contacts.of([])
            home = self.study.take_in(felt) if len(felt) else None
            self.reach.come_out()
            if home is not None:
                return home, "felt where a hole ends"
            if not sounded and self.reach.led:
                break
        told = "met what told no face" if met else "met nothing"
        return None, f"went down a hole and {told}" if led else "no way led into a hole"

    def _feel_floor(self, rim: RoundRim, aside: float) -> Done:
        """Come down beside the axis, onto what an array in the middle went past."""
        self._tried.note(rim.center)
        for way in rim.places(self.config.floor_ways)[1]:
            place = rim.center + aside * way + self.config.before * rim.axis
            if self.reach.sound(se3.pose(se3.frame_along(-rim.axis, way), place)):
                home = self.study.face_here()
                self.reach.come_out()
                return home, "felt a floor beside the middle of a hole"
            self.reach.come_out()
        return None, "felt no floor beside the middle of a hole"

    def _floored(self, rim: RoundRim) -> bool:
        """Whether anything was felt behind a rim, that looks out of it."""
        felt = self.reach.felt
        away = felt.points - rim.center
        deep = -(away @ rim.axis)
        off = np.linalg.norm(away + np.outer(deep, rim.axis), axis=1)
        return bool(((deep > self.config.floor) & (off < rim.radius) & (felt.facing @ rim.axis > 0.5)).any())

    def _feel(self, rim: RoundRim, other: RoundRim) -> Done:
        self._tried.note(rim.center)
        far = float((rim.center - other.center) @ rim.axis)
        met = 0
        for aside in self._asides(rim, other):
            met += any(self._down(rim, far, aside, way) for way in rim.places(self.config.ways)[1])
        return None, "felt where a hole narrows" if met else "felt nothing in a hole that narrows"

    def _asides(self, rim: RoundRim, other: RoundRim) -> list[float]:
        """[mm] from the axis, where the array has room and reaches over what narrows the hole."""
        most = self._most(rim)
        least = other.radius + self.config.covers - 0.5 * self.study.pad.size[0]
        return [aside for aside in (most, most - self.config.nearer) if aside > max(least, 0.0)]

    def _most(self, rim: RoundRim) -> float:
        """[mm] from the axis, up to which the array has room."""
        long, wide = self.study.pad.tool.high[:2]
        return float(np.sqrt(max((rim.radius - self.config.clear) ** 2 - wide**2, 0.0)) - long)

    def _down(self, rim: RoundRim, far: float, aside: float, way: Floats) -> bool:
        """Come down beside the axis along a (3,) way from it; whether anything stopped the array."""
        pad, down = self.study.pad, -rim.axis
        over = se3.pose(se3.frame_along(down, way), rim.center + aside * way + self.config.before * rim.axis)
        if not self.reach.with_room([over]) or not self.reach.go(over):
            return False
        pad.count_touch()
        tare(pad.guard)
        seen = advance(pad.guard, down, self.config.before + far + self.config.past, ApproachConfig().speed)
        if seen is not None:
            image = seen.image
            pressed = -float(np.max(image.depth, where=np.isfinite(image.sigma), initial=0.0))
            at = se3.transform_points(seen.world_from_sensor, np.array([[*strongest(image), pressed]]))[0]
            deep = float((rim.center - at) @ rim.axis)
            off = float(np.linalg.norm(at - rim.center + deep * rim.axis))
            self.study.found.stopped.append(Stopped(rim.center, off, deep))
        pad.guard.go_to(over)
        return seen is not None
