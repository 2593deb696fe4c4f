"""From a face to one of its edges: stroke until one comes near, lie over it, roll onto the face behind it.

A tracker follows an edge best from a flat face, whose depth says how the pad is tilted.  From a curved one, as a
cylinder's side, the pad rolls over the edge that it came to, onto the face that this edge bounds.

With n the normal of the first face, o the direction in it out of the material and t = o x n along the edge, a
second face of normal m makes with it the angle

    dihedral = 180 degrees - atan2(m . o, m . n),

in which what m has along t, where a curved face was met a little beside the place asked for, has no part (our
derivation).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product
from typing import Literal

import numpy as np

from exploration.control.dwell import dwell
from exploration.control.feel import feel
from exploration.control.procedures.approach import ApproachConfig, advance, press_on, retreat
from exploration.control.sighting import Sighting
from exploration.control.surface_reading import read_surface
from exploration.control.track_surface import Stroke
from exploration.devices.guard import Collision, OverPress
from exploration.planning.touching.pad import Pad
from exploration.planning.ways.transit import Support
from exploration.sensing.lines.hough import sure_lines
from primitives import pose as se3
from primitives.arrays import Floats


@dataclass(frozen=True)
class EdgeFromFaceConfig:
    """How an edge is come to and gone over."""

    faces: int = 3  # that are tried for an edge, the last whatever its curvature
    flat: float = 0.01  # [1/mm] curvature, up to which a face is flat to the pad
    inside: float = 1.0  # [mm] of the pad's center within the material
    lift: float = 3.0  # [mm] before the pad turns
    rolls: tuple[float, ...] = (60.0, 95.0, 30.0)  # [deg] over an edge, tried in turn
    overlap: float = 2.0  # [mm] of the pad past the edge that it was rolled over
    clear: float = 2.0  # [mm] of the pad from it, where a blunt edge under the pad hides the face
    standoff: float = 10.0  # [mm]
    overtravel: float = 16.0  # [mm]
    facing: float = 0.4  # least cosine between the way of a stroke and what it came to
    other: float = 0.05  # [rad] between two faces, from which they are two
    readings: int = 20  # of a stroke, that tell how its face is curved
    beside: float = 3.0  # [mm] within which what was met is the face behind the edge


@dataclass(frozen=True)
class NoEdge:
    """No edge was come to; false in a condition."""

    reason: str
    round: bool = False  # every stroke came back to its start: there may well be none

    def __bool__(self) -> Literal[False]:
        return False


def reach_edge(pad: Pad, config: EdgeFromFaceConfig = EdgeFromFaceConfig()) -> Sighting | NoEdge:
    """An edge of the object that the pad lies on, seen from a flat face where there is one."""
    edge: Sighting | NoEdge = NoEdge("nothing was tried")
    for left in reversed(range(config.faces)):
        flat = _on_flat(pad, config)
        edge = _stroked_to(pad, config)
        if not edge or flat or not left:
            return edge
        if not roll_over(pad, edge, config):
            return NoEdge("an edge of a curved face was found, and nothing behind it")
    return edge


def lie_over(pad: Pad, edge: Sighting, config: EdgeFromFaceConfig = EdgeFromFaceConfig()) -> None:
    """Lift, and put the pad's center beside the edge, its long side along it, pressed as it was."""
    guard = pad.guard
    pressed = guard.world_from_sensor
    retreat(guard, config.lift)
    outward, normal = edge.outward, edge.normal
    place = edge.point - config.inside * outward
    place = place - normal * (normal @ (place - pressed[:3, 3]))  # as deep as the pad was
    target = se3.pose(pad.attitude(normal, edge.tangent), place)
    guard.go_to(se3.pose(target[:3, :3], place + config.lift * normal))
    advance(guard, -normal, config.lift, ApproachConfig().speed)
    press_on(guard, -normal, float((guard.world_from_sensor[:3, 3] - place) @ normal))
    guard.go_to(target)


def roll_over(pad: Pad, edge: Sighting, config: EdgeFromFaceConfig = EdgeFromFaceConfig()) -> bool:
    """Roll over an edge; whether the pad came to lie behind it."""
    for roll in config.rolls:
        angle = np.radians(roll)
        normal = np.cos(angle) * edge.normal + np.sin(angle) * edge.outward
        down = np.cos(angle) * edge.outward - np.sin(angle) * edge.normal
        reach = max(0.0, 0.5 * min(pad.size) - config.overlap)
        target = se3.pose(pad.attitude(normal, edge.tangent), edge.point + reach * down)
        try:
            pad.travel(target, Support(edge.point, edge.normal), standoff=config.standoff)
            met = pad.touch(target, config.standoff, config.overtravel)
        except (OverPress, Collision):
            met = False
        pad.here = Support(edge.point, -pad.guard.world_from_sensor[:3, 2])
        if met:
            pad.lie(np.empty((0, 3)))
            if _turned(pad, edge) > config.other:
                return True
    return False


def dihedral(pad: Pad, edge: Sighting, config: EdgeFromFaceConfig = EdgeFromFaceConfig()) -> float | None:
    """[rad] through the material, between the face that an edge was seen from and the one behind it.

    None where nothing is met behind it, or something that does not run by the edge.
    """
    for roll, overlap in product(config.rolls, (config.overlap, -config.clear)):
        if roll_over(pad, edge, replace(config, rolls=(roll,), overlap=overlap)):
            normal = _normal_by(pad, edge, config)
            if normal is not None:
                return float(np.pi - np.arctan2(normal @ edge.outward, normal @ edge.normal))
    return None


def pressed(pad: Pad) -> float | None:
    """[mm] to which the face beside the edge under the pad is pressed; None where no edge is seen."""
    lines = sure_lines(dwell(pad.guard, pad.config.averaged).image, 1)
    return float(lines[0].plateau) if lines else None


def _normal_by(pad: Pad, edge: Sighting, config: EdgeFromFaceConfig) -> Floats | None:
    """(3,) outward normal of the face under the pad, across an edge; None where that face does not run by it."""
    felt = pad.feel()
    felt = felt.select(felt.has_normal)
    if not len(felt):
        return None
    normal: Floats = felt.normals.mean(axis=0)
    middle = felt.points.mean(axis=0)
    normal = normal + _bent(pad, config) @ (edge.point - middle)
    normal = normal - edge.tangent * float(normal @ edge.tangent)
    normal = normal / np.linalg.norm(normal)
    off = float((middle - edge.point) @ normal)
    return normal if abs(off) < config.beside else None


def _bent(pad: Pad, config: EdgeFromFaceConfig) -> Floats:
    """(3, 3) [1/mm] by which the normal of the face under the pad turns with the place; 0 where it is flat.

    Only what a smooth surface explains whole is curved: a thin wall's contact is as narrow as a bar's.
    """
    seen = dwell(pad.guard, pad.config.averaged)
    felt = feel(seen.image)
    reading = read_surface(seen, felt, None) if felt else None
    if reading is None or not reading.whole or float(np.abs(reading.hessian).max()) < config.flat:
        return np.zeros((3, 3))
    axes = pad.guard.world_from_sensor[:3, :2]
    bent: Floats = axes @ reading.hessian @ axes.T
    return bent


def _turned(pad: Pad, edge: Sighting) -> float:
    """[rad] by which the pad lies otherwise than on the face that the edge was seen from."""
    normal = -pad.guard.world_from_sensor[:3, 2]
    return float(np.arctan2(normal @ edge.outward, normal @ edge.normal))


def _on_flat(pad: Pad, config: EdgeFromFaceConfig) -> bool:
    felt = feel(dwell(pad.guard, pad.config.averaged).image)
    return float(np.abs(felt.curvature).max()) < config.flat if felt else False


def _stroked_to(pad: Pad, config: EdgeFromFaceConfig) -> Sighting | NoEdge:
    """The edge that ends the first stroke to come to one, of four."""
    axes = pad.axes()
    round_it: set[int] = set()  # axes along which a stroke came back to its start
    for axis, sign in ((0, 1.0), (0, -1.0), (1, 1.0), (1, -1.0)):
        if axis in round_it:
            continue
        heading = sign * axes[:, axis]
        try:
            stroke = pad.stroke(heading)
            way = pad.guard.world_from_sensor[:3, :2] @ heading
            seen = [e for e in pad.sightings(heading) if e.outward @ way > config.facing]
        except (OverPress, Collision):
            return NoEdge("the pad met something in its way")
        if stroke.ended == "wall":
            return NoEdge("the pad met something in its way")
        if stroke.ended == "edge" and seen:
            edge = _beside_contact(pad, seen)
            return replace(edge, curvatures=_curvatures(pad, stroke, edge, config))
        if stroke.ended == "closed":
            round_it.add(axis)
        if stroke.ended == "lost":
            return NoEdge("contact was lost before an edge came near")
    return NoEdge("no stroke over the surface came to an edge", len(round_it) == axes.shape[1])


def _curvatures(pad: Pad, stroke: Stroke, edge: Sighting, config: EdgeFromFaceConfig) -> tuple[float, float]:
    """[1/mm] of the face that a stroke ran over, along an edge and across it; 0 where it is flat to the pad."""
    whole = [reading.hessian for reading in stroke.readings if reading.whole]
    if len(whole) < config.readings:
        return 0.0, 0.0
    hessian = np.median(whole, axis=0)  # in the pad's axes, which it carries along
    across = pad.guard.world_from_sensor[:3, :2]
    along, outward = (float(d @ hessian @ d) for d in (edge.tangent @ across, edge.outward @ across))
    return along * (along > config.flat), outward * (outward > config.flat)


def _beside_contact(pad: Pad, seen: list[Sighting]) -> Sighting:
    """The nearest of some edges, at its place beside the middle of the contact, where it has not ended yet.

    Its tangent leads away from where it ends, if it does so near the pad.
    """
    pose = pad.guard.world_from_sensor
    felt = feel(dwell(pad.guard, pad.config.averaged).image)
    middle = pose[:3, 3] + (pose[:3, :2] @ felt.centroid if felt else 0.0)
    edge = min(seen, key=lambda e: float(np.linalg.norm(e.point - pose[:3, 3])))
    tangent = np.cross(edge.outward, edge.normal)
    place = edge.point + tangent * float(tangent @ (middle - edge.point))
    away = 1.0 if float(tangent @ (middle - pose[:3, 3])) >= 0.0 else -1.0
    return replace(edge, point=place, tangent=away * tangent)
