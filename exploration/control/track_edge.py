"""Edge tracking: servo on one line of the tactile image (`edge_servo`), at constant force and flat on the face.

Tracking ends at a corner (the face ends ahead, or material begins outside), where the edge closes on itself, after
a length, where it is lost and not found again a little way back, or where the pad runs into something beside it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from math import dist
from typing import Literal

import numpy as np

from exploration.control.closing import ClosingConfig, Home, came_round, comes_by
from exploration.control.corners import (
    CornerConfig,
    Meeting,
    agreed,
    ends_at_corner,
    is_sharp,
    meeting,
    too_short,
)
from exploration.control.deaf_taxels import hearing
from exploration.control.dwell import dwell
from exploration.control.edge_profile import EdgeProfile, profile_of
from exploration.control.edge_seen import first_expected
from exploration.control.edge_servo import EdgeServo, EdgeServoConfig
from exploration.control.edge_ticks import EdgeTick
from exploration.control.edge_trace import smoothed
from exploration.control.followed_again import followed_again
from exploration.control.hybrid import PRESS
from exploration.control.run_on import leading_from, leading_to
from exploration.devices.guard import Collision, Fault, Guard, Observation, OverPress
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.flattened import flattened
from exploration.sensing.lines.follow_line import follow_line
from exploration.sensing.lines.followed import Expected, Followed
from exploration.sensing.lines.line_fit import softened
from exploration.sensing.response import Response, rubber
from primitives.arrays import Floats
from primitives.evidence import EdgeTrace

Ended = Literal["corner", "closed", "lost", "length", "blocked"]


@dataclass(frozen=True)
class EdgeConfig(EdgeServoConfig):
    """How an edge is tracked."""

    corner: float = 2.5  # [mm] ahead of the center, at which an end of the face is the corner
    clear: float = 4.0  # [mm] from a corner, at which an edge is not read
    confirm: int = 3  # ticks in a row that must show the corner
    bent: float = 9.0  # [mm] the same, of a blunt one
    blunt: float = 0.03  # [1/mm] bend from which it may be a corner
    look: float = 1.0  # [mm] between looks for one
    quiet: int = 8  # frames averaged, in which it must be sharp
    corners: CornerConfig = field(default_factory=CornerConfig)
    patience: int = 6  # ticks without the line
    back: float = 4.0  # [mm] that a lost edge is gone back for
    retries: int = 2
    closing: ClosingConfig = field(default_factory=ClosingConfig)
    misfit: float = 3.0  # times what is usual, from which a fit is not the edge


@dataclass(frozen=True)
class Tracked:
    """What a tracked edge yielded; false where nothing was."""

    draw: Callable[..., EdgeTrace | None]  # the trace, from what the ticks saw
    average: Callable[[], EdgeProfile | None]  # their profile across the edge
    ended: Ended
    travel: float  # [mm]
    forces: tuple[float, ...] = ()  # [N] at every tick
    set_points: tuple[float, ...] = ()  # [N] that were wanted: the nominal pressure on the area in contact
    last: Followed | None = None  # the edge as last seen
    corner: Meeting | None = None  # that ended it, where it was seen coming
    fault: Fault | None = None  # that blocked it
    ticks: tuple[EdgeTick, ...] = ()  # that the trace is drawn from
    home: int | None = None  # the one that it closed at; None: it did at its own start, if at all

    def __bool__(self) -> bool:
        return self.trace is not None

    @cached_property
    def trace(self) -> EdgeTrace | None:
        """Where the edge ran; drawn when it is asked for, because of two ways along an edge one is enough."""
        return self.draw()

    @cached_property
    def profile(self) -> EdgeProfile | None:
        """The mean depth across the edge."""
        return self.average()


@dataclass
class _Run:
    """What outlives a tick."""

    ticks: list[EdgeTick] = field(default_factory=list)
    travel: float = 0.0
    cornering: int = 0
    met: list[Meeting] = field(default_factory=list)  # corners seen, one after another
    looked: float = 0.0  # [mm] of travel when corners were last looked for
    misfit: float = 20.0  # chi2 per degree of freedom, as is usual
    second: int = 0  # the tick that is a start as well
    start: int = 0  # the tick that a closed edge came back to
    home: int | None = None  # or the place that it came by


def follow_edge(
    guard: Guard,
    along: Floats,
    length: float,
    touch: int,
    stroke: int,
    press: float = PRESS,
    config: EdgeConfig = EdgeConfig(),
    homes: Sequence[Home] = (),
) -> Tracked:
    """Track the edge under the pad, the way of the (3,) world direction `along`, up to `length` [mm].

    The edge is closed where it comes by one of `homes`, or by its own start.
    """
    response = rubber(guard.calibrations[guard.active].spread, guard.sensor.array.pitch)
    run, missed, retries = _Run(), 0, 0
    seen = dwell(guard, 3)
    expected = first_expected(seen, along, config)
    rest = np.pi if expected is not None and np.cos(expected.angle) < 0 else 0.0
    servo = EdgeServo(guard, press, config, rest)
    last: Followed | None = None
    corner: Meeting | None = None
    fault: Fault | None = None
    ended: Ended = "length"
    while run.travel < length:
        image = softened(seen.image)
        if expected is not None:
            image = flattened(image, expected, last.plateau if last else press, config.curvatures)
        worst = config.misfit * max(1.0, run.misfit)
        edge = _followed(image, response, expected, worst, config.clear) if expected else None
        if edge is not None and not run.ticks and too_short(seen, edge, config.clear, config.corners):
            last, ended = edge, "corner"
            break
        if not edge or edge.misfit > worst:
            if last and edge is not None and ends_at_corner(seen, edge, last, config.clear, config.corners):
                ended = "corner"
                break
            missed += 1
            if missed > config.patience:
                if retries == config.retries or not run.ticks:
                    ended = "lost"
                    break
                retries, missed = retries + 1, 0
                expected = _gone_back(guard, run, config)
                servo.rest()
            seen = guard.hold()
            continue
        missed, last = 0, edge
        run.ticks.append(EdgeTick(edge, image, seen.world_from_sensor, seen.force))
        run.misfit += (edge.misfit - run.misfit) / min(len(run.ticks), 100)
        servo.want(seen, edge)
        if (why := _over(run, edge, config, homes)) is not None:
            ended = why
            break
        before = seen.world_from_sensor
        if (corner := _breaks(run, seen, edge, config)) is not None:
            if is_sharp(dwell(guard, config.quiet), edge, corner, config.corners):
                ended = "corner"
                break
            corner, seen = None, guard.hold()
            expected = servo.expected(edge, before, seen.world_from_sensor)
            continue
        try:
            seen = guard.move(servo.twist(seen, edge))
        except (OverPress, Collision) as met:
            ended, fault = "blocked", met
            break
        run.travel += max(0.0, run.ticks[-1].advanced(seen.world_from_sensor))
        expected = servo.expected(edge, before, seen.world_from_sensor)
    again = partial(followed_again, response=response, config=config, period=guard.period)
    clear = hearing(_clear(run.ticks[run.start :], corner, config), response, again)
    told = (touch, stroke, response, config.reach, config.bend_drift)
    draw = partial(smoothed, clear, ended == "closed", *told)
    if ended == "closed" and run.home is None and clear:
        draw = partial(draw, leading_to(clear, clear[0]), leading_from(clear, clear[-1]))
    average = partial(profile_of, clear, response)
    forces, wanted = tuple(t.force for t in run.ticks), tuple(servo.wanted)
    return Tracked(
        draw, average, ended, run.travel, forces, wanted, last, corner, fault, tuple(clear), run.home
    )


def _clear(ticks: list[EdgeTick], corner: Meeting | None, config: EdgeConfig) -> list[EdgeTick]:
    """The ticks in which no corner is near."""
    clear = [tick for tick in ticks if min(tick.edge.ahead, tick.edge.behind) > config.clear]
    if corner is None:
        return clear
    return [t for t in clear if dist(t.point, corner.point) > config.bent]


def _over(run: _Run, edge: Followed, config: EdgeConfig, homes: Sequence[Home]) -> Ended | None:
    """Whether the edge is at a corner, or has come round."""
    run.cornering = run.cornering + 1 if min(edge.ahead, edge.opens) < config.corner else 0
    if run.cornering >= config.confirm:
        return "corner"
    run.home = comes_by(homes, run.ticks[-1], run.travel, config.closing)
    if run.home is not None:
        return "closed"
    if not run.second and run.travel > config.closing.second:
        run.second = len(run.ticks) - 1
    start = came_round(run.ticks, run.second, run.travel, config.closing)
    if start is None:
        return None
    run.start = start
    return "closed"


def _followed(
    image: TactileImage, response: Response, expected: Expected, misfit: float, clear: float
) -> Followed:
    """The edge, of as much of it as one arc explains: less than the reach where it is about to bend.

    Not where its face ends within `clear` [mm]: round a corner no arc runs.
    """
    edge = follow_line(image, response, expected)
    for share in (0.5, 0.3):
        if not edge or edge.misfit <= misfit or min(edge.ahead, edge.opens) < clear:
            break
        edge = follow_line(image, response, replace(expected, reach=share * expected.reach))
    return edge


def _breaks(run: _Run, seen: Observation, edge: Followed, config: EdgeConfig) -> Meeting | None:
    """The blunt corner that looks like a sharp bend, once the pad is there."""
    if abs(edge.bend) < config.blunt or run.travel < run.looked + config.look:
        return None
    run.looked = run.travel
    met = meeting(seen, edge, config.corners)
    if met is None:
        run.met.clear()
        return None
    run.met.append(met)
    return met if agreed(run.met, config.corners) and abs(met.ahead) < config.corner else None


def _gone_back(guard: Guard, run: _Run, config: EdgeConfig) -> Expected | None:
    """Back to where the edge was last seen well, and look for it there."""
    steps = max(1, round(config.back / (config.speed * guard.period)))
    tick = run.ticks[max(0, len(run.ticks) - 1 - steps)]
    guard.go_to(tick.world_from_sensor)
    found = first_expected(dwell(guard, 4), tick.tangent, config)
    return None if found is None else replace(found, bend=tick.edge.bend)
