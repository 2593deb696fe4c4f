"""A line in the pad's image as an edge of the object in the world."""

from dataclasses import dataclass

import numpy as np

from exploration.control.feel import Felt
from exploration.devices.guard import Observation
from exploration.sensing.lines.line import Line
from exploration.sensing.lines.strip_end import fit_strip_end
from primitives.arrays import Floats


@dataclass(frozen=True)
class Sighting:
    """An edge, seen once from one face."""

    point: Floats  # (3,) [mm] on the edge, nearest to the pad's center
    tangent: Floats  # (3,) unit direction along the edge
    outward: Floats  # (3,) unit direction in the face's plane, away from the material
    normal: Floats  # (3,) outward normal of the face that it was seen from
    sigma: float  # [mm] across the edge
    length: float  # [mm] seen
    curvatures: tuple[float, float] = (0.0, 0.0)  # [1/mm] of that face, along the edge and across it; 0: flat


def sight(line: Line, seen: Observation) -> Sighting:
    """The world's edge of a line in an observation's image."""
    foot = line.offset * line.normal
    lift = seen.world_from_sensor
    turn = lift[:3, :3]
    return Sighting(
        point=turn @ np.array([foot[0], foot[1], -line.plateau]) + lift[:3, 3],
        tangent=turn[:, :2] @ line.direction,
        outward=-turn[:, :2] @ line.inward,
        normal=-turn[:, 2],
        sigma=float(np.sqrt(line.covariance[1, 1])),
        length=line.length,
    )


def brink(seen: Observation, felt: Felt, heading: Floats) -> Sighting:
    """The edge that ends a contact ahead, where no line is told apart: across the heading, at the contact's end.

    A narrow contact, as of a cylinder, is cut by its edge over a few taxels only; that it ends is plain.
    """
    end = fit_strip_end(seen.image, heading)
    if end is not None:
        return _across(seen, felt, heading, end.offset, end.sigma)
    return _across(
        seen, felt, heading, reach_along(felt, seen, heading), 0.7 * float(min(seen.image.array.pitch))
    )


def strip_ends(seen: Observation, felt: Felt) -> list[Sighting]:
    """The edges that end a narrow contact under the pad, to either side along it."""
    ridge = np.linalg.eigh(felt.hessian)[1][:, 0]
    found = []
    for way in (ridge, -ridge):
        rough = fit_strip_end(seen.image, way)
        end = None if rough is None else fit_strip_end(seen.image, rough.axis)
        if rough is not None and end is not None:
            found.append(_across(seen, felt, rough.axis, end.offset, end.sigma))
    return found


def _across(seen: Observation, felt: Felt, heading: Floats, ahead: float, sigma: float) -> Sighting:
    """The edge across a (2,) heading, so far ahead [mm] of the pad's middle."""
    aside = np.array([-heading[1], heading[0]])
    foot = ahead * heading + float(felt.centroid @ aside) * aside
    turn = seen.world_from_sensor[:3, :3]
    return Sighting(
        point=turn @ np.array([foot[0], foot[1], -felt.depth]) + seen.world_from_sensor[:3, 3],
        tangent=turn[:, :2] @ aside,
        outward=turn[:, :2] @ heading,
        normal=-turn[:, 2],
        sigma=sigma,
        length=float(np.sqrt(felt.area)),
    )


def reach_along(felt: Felt, seen: Observation, heading: Floats) -> float:
    """How far [mm] contact reaches from the pad's center along a (2,) heading, its outermost tenth left out."""
    along = np.sort(_along(felt, seen, heading))
    return float(np.interp(0.9 * (len(along) - 1), np.arange(len(along)), along))


def contact_front(felt: Felt, seen: Observation, heading: Floats) -> float:
    """How far [mm] the foremost touched taxel lies from the pad's center along a (2,) heading."""
    return float(_along(felt, seen, heading).max())


def _along(felt: Felt, seen: Observation, heading: Floats) -> Floats:
    rows, columns = np.nonzero(felt.mask)
    return np.asarray(seen.image.array.x[columns] * heading[0] + seen.image.array.y[rows] * heading[1])


def ends_by_curving(line: Line, felt: Felt, share: float = 0.6, least: float = 0.008) -> bool:
    """Whether contact would end at a line anyway, because the surface curves away from the pad there.

    A surface of curvature k [1/mm] pressed d deep touches within sqrt(2 d / k) of its deepest place.
    """
    curvature = float(line.inward @ felt.hessian @ line.inward)
    if curvature < least:
        return False
    away = float(line.distance(felt.centroid[None])[0])
    return away > share * float(np.sqrt(2.0 * max(felt.depth, 0.05) / curvature))
