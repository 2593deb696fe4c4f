"""Looking where nobody has been: approaches from afar, once nothing that is known leads on.

A rim that nothing leads over, a way that is barred, a side that no known face leads to: each may end exploration
far from the object's end.  The pad goes out, round all that is known, and comes in where it sees most (`views`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from exploration.control.procedures.approach import ApproachConfig, retreat, touched
from exploration.planning.open.views import View, best_view
from exploration.planning.touching.findings import Attempts, Done
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.planning.ways.round_ball import Ball, way_round
from primitives import pose as se3
from primitives.arrays import Bools, Floats
from primitives.fit import Fit
from primitives.patch_graph import Face


@dataclass(frozen=True)
class LookingConfig:
    """How far out the pad goes."""

    most: int = 60  # approaches of one array
    vain: int = 60  # of them on end that met nothing, from which no more are made
    unnamed: int = 10  # the same that met what names no face, as all round a crumpled side
    out: float = 30.0  # [mm] that a ball about all that was felt is larger than that
    start: float = 20.0  # [mm] outside that ball, where an approach begins
    there: float = 1.0  # [mm] from where an approach begins, that is there
    same: float = 15.0  # [mm] between the beginnings of approaches that are one
    beside: float = 12.0  # [mm] from what was met on the way round, where it is looked for
    back: float = 6.0  # [mm] from what was met on the way round
    off_told: float = 2.0  # [mm] from what was told, from where a felt place is the object's
    step: float = 5.0  # [mm] between the places on a way that are looked at


LOOK_AGAIN = LookingConfig(vain=4)  # where another array has looked before


class Looking:
    """The approaches of one array."""

    def __init__(self, study: Study, reach: Reach, config: LookingConfig = LookingConfig()) -> None:
        self.study, self.reach, self.config = study, reach, config
        self._left, self._vain, self._unnamed = config.most, 0, 0
        self._failed, self._looked = Attempts(1, config.same), Attempts(1, config.same)

    def next(self) -> Callable[[], Done] | None:
        """The approach that sees most; None where none is worth it."""
        if self._left <= 0 or self._vain >= self.config.vain or self._unnamed >= self.config.unnamed:
            return None
        felt, own, pad = self.reach.felt, self._own(), self.study.pad
        axes = own_axes(self.study.found.graph.faces)
        beside = None if pad.told is None else pad.told.points
        view = best_view(felt.points[own], felt.facing[own], pad.swept, pad.tool.high[:2], axes, beside)
        return None if view is None else partial(self._look, view)

    def come_down_on(self, target: Floats) -> bool | None:
        """From outside straight down on a (4, 4) target; whether it was touched, None where no way is free."""
        ball = self._ball()
        start = self._start(target, ball)
        back = float(np.linalg.norm(target[:3, 3] - start[:3, 3]))
        steps = np.arange(self.reach.config.standoff, back, self.config.step)
        way = list(target @ se3.pose(translation=np.outer(steps, [0.0, 0.0, -1.0])))
        if len(self.reach.with_room(way)) < len(way) or not self._round(start, ball):
            return None
        deep = back + self.reach.config.overtravel
        met = self.study.pad.come_down(target[:3, 2], deep, ApproachConfig().search_speed)
        if not met:
            self.study.pad.guard.go_to(start)
        return met

    def _own(self) -> Bools:
        """(n,) which felt places are the object's: all that are well off what was told."""
        points, told = self.reach.felt.points, self.study.pad.told
        if told is None:
            return np.ones(len(points), dtype=bool)
        return np.asarray(told.surface.signed_distance(points) > self.config.off_told)

    def _ball(self) -> Ball:
        """About all that was felt, and well off it."""
        felt = self.reach.felt.points[self._own()]
        middle = 0.5 * (felt.min(axis=0) + felt.max(axis=0))
        return Ball(middle, float(np.linalg.norm(felt - middle, axis=1).max()) + self.config.out)

    def _start(self, target: Floats, ball: Ball) -> Floats:
        """(4, 4) outside a ball, from where a straight way leads to a (4, 4) target."""
        way, at = target[:3, 2], target[:3, 3]
        far = float((at - ball.center) @ way) + ball.radius + self.config.start
        return se3.pose(target[:3, :3], at - far * way)

    def _look(self, view: View) -> Done:
        self._left -= 1
        pad, guard = self.study.pad, self.study.pad.guard
        ball = self._ball()
        way, far = view.target[:3, 2], ball.radius + self.config.start
        start = self._start(view.target, ball)
        if not self._led_to(start, ball, view):
            if pad.come_down(guard.world_from_sensor[:3, 2], self.config.beside):
                return self.study.face_here(), "met something on the way round"
            return None, "met something on the way round, and lost it"
        met = pad.come_down(way, 2.0 * far, ApproachConfig().search_speed)
        home = self.study.face_here() if met else None
        beside = pad.told is not None and home is None  # what is known ends no view of the object
        if not met or beside or self._looked.given_up(start[:3, 3]):
            pad.swept.set_aside(view.unseen)  # seen, or behind what is not felt well enough to end the view
        self._looked.note(start[:3, 3])
        self._vain = 0 if met and not beside else self._vain + 1
        if met and not pad.on_told():
            self._unnamed = self._unnamed + 1 if home is None else 0
        if not met:
            guard.go_to(start)
            return None, "looked from afar and met nothing"
        return home, "looked from afar and met something"

    def _led_to(self, start: Floats, ball: Ball, view: View) -> bool:
        """Whether a way led to the (4, 4) start of a view, which is not worth a third try."""
        led = False
        try:
            led = self._round(start, ball)
        finally:
            if not led:
                if self._failed.count(start[:3, 3]):
                    self.study.pad.swept.set_aside(view.unseen)
                self._failed.note(start[:3, 3])
        return led

    def _round(self, start: Floats, ball: Ball) -> bool:
        """To a (4, 4) start, straight or out of a ball and round it; false where something was in the way."""
        guard = self.study.pad.guard
        self.reach.come_out()
        if self.reach.go(start) or self.reach.led:
            return bool(se3.apart(guard.world_from_sensor, start) < self.config.there)
        here = guard.world_from_sensor
        along, off = float((here[:3, 3] - ball.center) @ here[:3, 2]), here[:3, 3] - ball.center
        inside = ball.radius**2 - float(off @ off)
        if inside > 0.0:
            retreat(guard, along + float(np.sqrt(along**2 + inside)))
        stops = way_round(guard.world_from_sensor, start, ball)
        if self.study.pad.told is not None and len(self.reach.with_room(stops)) < len(stops):
            return False
        for pose in stops:
            if guard.go_to(pose, until=lambda seen: touched(seen.image)) is not None:
                retreat(guard, self.config.back)
                return False
        return True


def own_axes(faces: Sequence[Face]) -> Floats:
    """(3, 3) an object's own directions, in columns: of its largest flat face, and of others across it.

    Where none is flat, the axis of a round one is such a direction, too.
    """
    largest = sorted(faces, key=lambda face: -len(face.contacts))
    fits = [face.fit for face in largest if isinstance(face.fit, Fit) and face.fit.shape.tilts]
    ways = [fit.shape.direction for fit in sorted(fits, key=lambda fit: fit.kind != "plane")]
    first = ways[0] if ways else np.array([0.0, 0.0, 1.0])
    across = next((way for way in ways if abs(float(way @ first)) < 0.2), None)
    return se3.frame_along(first, across)
