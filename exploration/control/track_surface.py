"""Surface tracking: slide along a surface at constant force until an edge comes near.

Every tick: read the surface, look ahead for its end, and command ``v = heading * speed`` in the pad's plane
with the hybrid law for the rest (`surface_servo`).  The heading is fixed in the sensor frame, so on a curved
surface the pad follows a geodesic.  A stroke ends short of an edge, where the stage's reach ends, where the
surface rises ahead of the pad (a concavity), where it has come round, or after its length.  Where it is asked to,
it also ends at a wall: what meets housing or skin from the side while the pad lies on its surface as it did all
along; a pad that hangs on a rim meets the object's flank instead, and is lost.  The guard has backed off by then.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import numpy as np

from exploration.control.feel import feel
from exploration.control.hybrid import PRESS
from exploration.control.kept_contacts import keep, touched_cells
from exploration.control.procedures.look import look_closely
from exploration.control.sighting import Sighting, contact_front, reach_along, sight
from exploration.control.stroke_ends import edge_near, leaves, rises
from exploration.control.surface_reading import SurfaceReading, read_surface
from exploration.control.surface_servo import SurfaceServo
from exploration.control.surface_trace import NO_TRACE, SurfaceTrace, smoothed_surface
from exploration.devices.guard import Collision, Guard, Observation, OverPress
from exploration.sensing.lines.hough import sure_lines
from primitives.arrays import Floats
from primitives.evidence import Contacts

Ended = Literal["edge", "length", "closed", "lost", "workspace", "concavity", "wall"]


@dataclass(frozen=True)
class StrokeConfig:
    """How a surface is stroked."""

    speed: float = 40.0  # [mm/s]
    roll: float = 1.3  # [rad/s] of turning that a curved surface may ask for
    spacing: float = 4.0  # [mm] between the frames that are kept as contacts
    stop_share: float = 0.4  # an edge this share of the half pad ahead of the center ends the stroke
    confirm: int = 3  # frames in a row that must show the edge
    closing: float = 3.0  # [mm] from its start, a stroke has gone round
    least_round: float = 25.0  # [mm] of travel before that can be
    lost: int = 12  # frames without contact
    looks: float = 2.0  # [mm] between looks for an edge
    tick: float = 0.3  # [taxels] of travel in one, at most
    recede: float = 0.5  # share of its farthest reach ahead, at which a contact is ending
    curving: float = 0.008  # [1/mm] a surface this curved along the heading ends its contact by itself
    sharp: float = 0.16  # [1/mm] a contact this curved is going over an edge
    sharper: float = 1.5  # times as curved as where the stroke began, if that was sharp already
    rising: float = 2.0  # times the nominal press, under the pad's front, at which a concavity begins
    room: float = 2.0  # [mm] kept from the end of the stage's reach, beside what it takes to stop
    lies: float = (
        0.5  # share of a stroke's usual area of contact, from which the pad lies on its surface, and
    )
    covers: float = 0.08  # of the pad's own: what hangs on a corner or rim all along lies on nothing
    ahead: float = 0.4  # share of the half pad ahead of the center, up to which that contact's middle may be
    sunk: float = 2.0  # times the nominal press, up to which it may be deep
    walls: bool = False  # whether what is met from the side ends a stroke; else it is a fault


@dataclass(frozen=True)
class Stroke:
    """What one stroke yielded."""

    contacts: Contacts
    cells: Floats  # (n, 3) [mm] world points under the touched taxels
    facing: Floats  # (n, 3) the pad's outward normal over each
    edges: tuple[Sighting, ...]  # as last seen
    ended: Ended
    travel: float  # [mm]
    forces: tuple[float, ...] = ()  # [N] at every tick
    set_points: tuple[float, ...] = ()  # [N] that were wanted
    readings: tuple[SurfaceReading, ...] = ()  # of every tick
    heading: Floats | None = None  # (2,) in the pad's plane
    met: Floats | None = None  # (4, 4) world_from_sensor where a wall was met

    @cached_property
    def trace(self) -> SurfaceTrace:
        """Where the surface ran; drawn when it is asked for, because exploring needs the contacts only."""
        return NO_TRACE if self.heading is None else smoothed_surface(list(self.readings), self.heading)


def follow_surface(
    guard: Guard,
    heading: Floats,
    length: float,
    touch: int,
    stroke: int,
    press: float = PRESS,
    config: StrokeConfig = StrokeConfig(),
) -> Stroke:
    """Stroke up to `length` [mm] along a (2,) unit `heading` in the pad's plane.

    A fault that ends it carries the contacts kept until then.
    """
    kept: list[Contacts] = []
    try:
        return _follow(guard, heading, length, touch, stroke, press, config, kept)
    except (Collision, OverPress) as fault:
        fault.kept = Contacts.concatenate(kept)
        raise


def _follow(
    guard: Guard,
    heading: Floats,
    length: float,
    touch: int,
    stroke: int,
    press: float,
    config: StrokeConfig,
    kept: list[Contacts],
) -> Stroke:
    """The stroke; its contacts are `kept` as they come."""
    cells: list[Floats] = []
    facing: list[Floats] = []
    met: Floats | None = None
    readings: list[SurfaceReading] = []
    servo = SurfaceServo(guard, press)
    start = guard.world_from_sensor
    at, travel, since, missing, confirmed, ticks = start, 0.0, np.inf, 0, 0, 0
    farthest, ending, over = 0.0, 0, 0
    sharp: float | None = None
    areas: list[float] = []
    fastest = min(config.speed, config.tick * min(guard.sensor.array.pitch) / guard.period)
    every = max(1, round(config.looks / (fastest * guard.period)))
    half = 0.5 * float(np.abs(heading) @ np.asarray(guard.sensor.array.size))
    ended: Ended = "length"
    seen = guard.hold()
    while travel < length:
        felt = feel(seen.image)
        if not felt:
            missing += 1
            if missing > config.lost:
                ended = "lost"
                break
            servo.rest()
            seen = guard.move(np.array([0.0, 0.0, 5.0, 0.0, 0.0, 0.0]))
            continue
        missing = 0
        areas.append(felt.area)
        looks = ticks % every == 0 or confirmed
        if looks and readings and readings[-1].plain:
            looks, confirmed = False, 0
        if looks and contact_front(felt, seen, heading) < half - 1.5 * max(seen.image.array.pitch):
            near = edge_near(sure_lines(seen.image, 3), heading, seen.image, config.stop_share)
            confirmed = confirmed + 1 if near else 0
        ticks += 1
        reach = reach_along(felt, seen, heading)
        farthest = max(farthest, reach)
        curving = float(heading @ felt.hessian @ heading) > config.curving
        receding = not curving and reach < config.recede * farthest and reach < 0.6 * half
        ending = ending + 1 if receding else 0
        sharp = felt.curvature[0] if sharp is None else sharp
        over = over + 1 if felt.curvature[0] > max(config.sharp, config.sharper * sharp) else 0
        if max(ending - config.confirm, over, confirmed) >= config.confirm:
            ended = "edge"
            break
        if rises(seen.image, heading, config.rising * press):
            ended = "concavity"
            break
        if leaves(guard, seen, heading, fastest, config.room):
            ended = "workspace"
            break
        if since >= config.spacing:
            since = 0.0
            closer = look_closely(guard, seen, felt)
            keep(closer, touch, stroke, kept)
            cells.append(touched_cells(closer, felt))
            facing.append(np.broadcast_to(-closer.world_from_sensor[:3, 2], cells[-1].shape))
            if closer is not seen:
                servo.rest()
                seen, felt = closer, feel(closer.image) or felt
        if travel > config.least_round and _returned(at, start, config):
            ended = "closed"
            break
        reading = read_surface(seen, felt, readings[-1] if readings else None)
        if reading is not None:
            readings.append(reading)
        bend = max(float(np.linalg.norm(servo.bend @ heading)), 1e-6)
        speed = min(fastest * (0.5 if confirmed else 1.0), config.roll / bend)
        try:
            seen = guard.move(servo.twist(seen, felt, reading, heading, speed))
        except (Collision, OverPress) as fault:
            if not config.walls or fault.seen is None:
                raise
            lay = _lies_flush(fault.seen, heading, float(np.median(areas)), half, press, config)
            ended, met = ("wall", fault.seen.world_from_sensor) if lay else ("lost", None)
            break
        step = float((seen.world_from_sensor[:3, 3] - at[:3, 3]) @ (at[:3, :2] @ heading))
        at, travel, since = seen.world_from_sensor, travel + step, since + step
    if guard.pending.latency > 0.0:
        seen = guard.hold(3 + round(guard.pending.latency / guard.period))
        travel += float((seen.world_from_sensor[:3, 3] - at[:3, 3]) @ (at[:3, :2] @ heading))
    return Stroke(
        Contacts.concatenate(kept),
        np.concatenate(cells) if cells else np.empty((0, 3)),
        np.concatenate(facing) if facing else np.empty((0, 3)),
        tuple(sight(line, seen) for line in sure_lines(seen.image, 3)) if ended != "lost" else (),
        ended,
        travel,
        tuple(servo.forces),
        tuple(servo.wanted),
        tuple(readings),
        heading,
        met,
    )


def _lies_flush(
    seen: Observation, heading: Floats, area: float, half: float, press: float, config: StrokeConfig
) -> bool:
    """Whether the pad lies on its surface as it did; `area` [mm^2] is usual for the stroke.

    A pad that tips over the end of its face lies on its own leading rim instead, and sinks in.
    """
    felt = feel(seen.image)
    if not felt:
        return False
    level = float(felt.centroid @ heading) < config.ahead * half and felt.depth < config.sunk * press
    return level and felt.area > max(
        config.lies * area, config.covers * float(np.prod(seen.image.array.size))
    )


def _returned(at: Floats, start: Floats, config: StrokeConfig) -> bool:
    near = float(np.linalg.norm(at[:3, 3] - start[:3, 3])) < config.closing
    return near and float(at[:3, 2] @ start[:3, 2]) > 0.9
