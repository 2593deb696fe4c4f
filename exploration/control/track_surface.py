"""Surface tracking: slide along a surface at constant force until an edge comes near.

Every tick: read the surface, look ahead for its end, and command ``v = heading * speed`` in the pad's plane
with the hybrid law for the rest (`surface_servo`).  The heading is fixed in the sensor frame, so on a curved
surface the pad follows a geodesic.  A stroke ends short of an edge, where the stage's reach ends, where the
surface rises ahead of the pad (a concavity), where it has come round, or after its length.  Where it is asked to,
it also ends at a wall: what meets housing or skin from the side while the pad lies on its surface as it did all
along.  A pad that hangs on a rim meets the object's own flank instead, and is lost.  The guard has backed off by then.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from exploration.control.feel import FeelConfig, Felt, feel
from exploration.control.hybrid import PRESS
from exploration.control.procedures.look import look_closely
from exploration.control.sighting import Sighting, contact_front, reach_along, sight
from exploration.control.stroke_ends import edge_near, leaves, rises
from exploration.control.surface_reading import SurfaceReading, read_surface
from exploration.control.surface_servo import SurfaceServo
from exploration.control.surface_trace import NO_TRACE, SurfaceTrace, smoothed_surface
from exploration.devices.guard import Collision, Guard, Observation, OverPress
from exploration.sensing.contacts import contacts_of
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.hough import find_lines
from exploration.sensing.surfaces.domed_patch import domed_patch
from exploration.sensing.surfaces.flat_patch import flat_patch
from exploration.sensing.surfaces.local_surface import LocalSurface
from exploration.sensing.touch import perceive
from primitives import pose as se3
from primitives.arrays import Floats, frozen
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
    lies: float = 0.5  # share of a stroke's usual area of contact, from which the pad lies on its surface
    walls: bool = False  # whether what is met from the side ends a stroke; else it is a fault


@dataclass(frozen=True)
class TrustConfig:
    """Which frames are good enough to become contacts; the rest only steer."""

    misfit: float = 1.8  # chi2 per degree of freedom of a flat patch
    curved_misfit: float = 4.0  # of a curved one
    area: float = 15.0  # [response widths^2] in contact
    flat_area: float = 38.0  # [response widths^2] in contact, where the surface is taken for flat
    curvature: float = 0.4  # [1/mm] beyond which the rubber blurs too much
    sure: float = 0.08  # of a curvature beyond `narrow`, its greatest relative deviation
    doubtful: float = 1.5  # misfit of a curved patch from which an unseen edge probably cuts it
    floor: tuple[float, float, float] = (
        0.01,
        0.02,
        0.05,
    )  # [mm] error of a frame that its noise does not show:
    # nothing but surface is seen; an edge cuts it; an unseen edge does
    normal_floor: tuple[float, float, float] = (0.002, 0.04, 0.04)  # [rad] the same for normals
    curved_normal_floor: float = 0.005  # [rad] of a curved patch that no edge cuts
    cut: float = 0.3  # of the slope at its rim, by which a small contact may be turned if unseen edges cut it
    narrow: float = 0.1  # [1/mm] a contact this curved may be a flat strip of two or three taxels
    narrow_floor: float = 0.06  # [mm]
    narrow_normal_floor: float = 0.1  # [rad]
    rims: tuple[float, ...] = (
        3.0,
        2.0,
    )  # [spreads] along a contact's end, that a patch of any outline leaves out
    border: float = 0.6  # [pitches] from the outermost taxels, where the skin's end bends a curved patch


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
    """Stroke up to `length` [mm] along a (2,) unit `heading` in the pad's plane."""
    kept: list[Contacts] = []
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
        if looks and contact_front(felt, seen, heading) < half - 1.5 * max(seen.image.array.pitch):
            near = edge_near(find_lines(seen.image, 3), heading, seen.image, config.stop_share)
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
            last = feel(fault.seen.image)
            lay = last.area > config.lies * float(np.median(areas)) if last else False
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
        tuple(sight(line, seen) for line in find_lines(seen.image, 3)) if ended != "lost" else (),
        ended,
        travel,
        tuple(servo.forces),
        tuple(servo.wanted),
        tuple(readings),
        heading,
        met,
    )


def keep(
    seen: Observation,
    touch: int,
    stroke: int,
    kept: list[Contacts],
    trust: TrustConfig = TrustConfig(),
) -> None:
    """Turn a frame into contacts, where it shows a smooth surface."""
    what = perceive(seen.image)
    surface = what.surface
    where = (seen.world_from_sensor, touch, stroke, seen.sensor)
    floor, normal_floor = trust.floor[0], trust.normal_floor[0]
    if isinstance(surface, LocalSurface) and _trusted(surface, seen.image, trust):
        found = contacts_of(what, *where)
        if surface.curved:
            cut = 2 if _misfit(surface) > trust.doubtful else 1 if what.lines else 0
            floor, normal_floor = trust.floor[cut], max(trust.normal_floor[cut], trust.curved_normal_floor)
            rim = float(np.sqrt(0.5 * max(-surface.point[2] * surface.principal[0][1], 0.0)))
            normal_floor = max(normal_floor, trust.cut * rim)
            if float(surface.principal[0][0]) > trust.narrow:
                floor, normal_floor = trust.narrow_floor, trust.narrow_normal_floor
    else:
        found = _patch(seen, where, trust)
    if len(found):
        sigma, turn = np.hypot(found.sigma, floor), np.hypot(found.normal_sigma, normal_floor)
        kept.append(replace(found, sigma=frozen(sigma), normal_sigma=frozen(turn)))


def _patch(seen: Observation, where: tuple[Floats, int, int, int], trust: TrustConfig) -> Contacts:
    """Contacts of a face of any outline, as far inside its rim as it is wide enough for."""
    found = Contacts.of([])
    for rim in trust.rims:
        felt = feel(seen.image, FeelConfig(rim=rim))
        found = flat_patch(seen.image, felt.inner, *where) if felt else found
        if felt and not len(found):
            found = domed_patch(seen.image, felt.inner, *where)
        if len(found):
            break
    return found


def touched_cells(seen: Observation, felt: Felt) -> Floats:
    """(n, 3) world points under the touched taxels."""
    rows, columns = np.nonzero(felt.mask)
    depth = np.maximum(seen.image.depth[rows, columns], 0.0)
    local = np.column_stack([seen.image.array.x[columns], seen.image.array.y[rows], -depth])
    return se3.transform_points(seen.world_from_sensor, local)


def _trusted(surface: LocalSurface, image: TactileImage, trust: TrustConfig) -> bool:
    area = float(surface.mask.sum()) / _taxels_of_a_width(image)
    if surface.curved:
        most = float(np.abs(surface.principal[0]).max())
        doubt = float(np.sqrt(surface.curvature_covariance[[0, 2], [0, 2]].max()))
        sharp = most > trust.curvature or (most > trust.narrow and doubt > trust.sure * most)
        px, py = image.array.pitch
        room = np.array([image.array.x[-1] - trust.border * px, image.array.y[-1] - trust.border * py])
        inside = bool((np.abs(surface.point[:2]) < room).all())
        return inside and not sharp and _misfit(surface) < trust.curved_misfit and area >= trust.area
    return _misfit(surface) < trust.misfit and area >= trust.flat_area


def _taxels_of_a_width(image: TactileImage) -> float:
    """How many taxels lie in the square of the width over which the skin blurs a step."""
    px, py = image.array.pitch
    return (image.spread**2 + (px**2 + py**2) / 24.0) / (px * py)


def _misfit(surface: LocalSurface) -> float:
    return surface.chi2 / max(surface.dof, 1)


def _returned(at: Floats, start: Floats, config: StrokeConfig) -> bool:
    near = float(np.linalg.norm(at[:3, 3] - start[:3, 3])) < config.closing
    return near and float(at[:3, 2] @ start[:3, 2]) > 0.9
