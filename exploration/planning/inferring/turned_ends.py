"""Flat ends of turned faces, inferred from rims that run round their axis.

A cylinder or cone that ends at a rim round its axis was most likely turned, and what ends it stands upright on the
axis there: a narrow ring, on which no array can lie, does so on a funnel's mouth or a pipe's end.  That is likely
and not measured, so the end is marked as inferred (our derivation).

Where no rim was made out, as round a flange so low that a pad lies over both its edges, the cylinder ends half way
between the places where it was felt last and those where it was missing, if that is equally high all round.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.open.known_face import KnownFace
from primitives import pose as se3
from primitives.arcs import around
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shapes import Cone, Cylinder


@dataclass(frozen=True)
class TurnedEndsConfig:
    """When a rim is of an end, and where its contacts are."""

    round: float = 0.1  # most cosine between a rim and the axis that it runs round
    away: float = 0.3  # least cosine between the way out of the face and the axis
    same: float = 0.6  # [mm] between the heights of rims of one end
    arc: float = 0.3  # [rad] to either side of a rim, where its end is
    deep: tuple[float, ...] = (0.3, 0.8, 1.3)  # [mm] from a rim, likewise
    sigma: float = 0.1  # [mm]
    normal_sigma: float = 0.02  # [rad]
    along: float = 0.7  # least cosine between the way out of a cylinder and its axis, at its end
    cells: int = 12  # places where it was felt last, that tell where it ends
    around: float = 3.3  # [rad] round it, over which they are
    level: float = 0.8  # [mm] from their median, within which half of them are
    past: float = 2.0  # [mm] past an end, where the cylinder was felt nowhere
    ring: int = 24  # places round such an end
    unsure: float = 1.0  # [mm] of it: what looks its way so near is that end


def turned_ends(
    rims: Sequence[tuple[Sighting, int]], faces: Sequence[Face], config: TurnedEndsConfig = TurnedEndsConfig()
) -> list[Contacts]:
    """Contacts of each end that rims tell of; each rim comes with the id of its face."""
    ends: list[tuple[Floats, Floats]] = []
    shapes = {face.id: face.fit.shape for face in faces if isinstance(face.fit, Fit)}
    for rim, own in rims:
        shape = shapes.get(own)
        if not isinstance(shape, Cylinder | Cone):
            continue
        axis, out = shape.direction, float(shape.direction @ rim.outward)
        if abs(float(axis @ rim.tangent)) > config.round or abs(out) < config.away:
            continue
        way, places = axis * np.sign(out), _places(rim, shape, config)
        for k, (others, known) in enumerate(ends):
            if (
                way @ known > 0.99
                and abs(float((others.mean(axis=0) - places.mean(axis=0)) @ way)) < config.same
            ):
                ends[k] = np.concatenate([others, places]), known
                break
        else:
            ends.append((places, way))
    return [
        Contacts.of(p, np.broadcast_to(way, p.shape), config.sigma, config.normal_sigma, touch=NOT_FELT)
        for p, way in ends
    ]


def felt_ends(
    known: Sequence[KnownFace],
    open_: Sequence[tuple[Floats, Floats]],
    config: TurnedEndsConfig = TurnedEndsConfig(),
) -> list[Contacts]:
    """Contacts of the ends of cylinders, from (n, 3) places where each was felt last, and the ways out there."""
    lots = []
    for own, (at, out) in zip(known, open_, strict=True):
        shape = own.fit.shape
        if isinstance(shape, Cylinder) and own.side > 0.0 and shape.radius > max(config.deep):
            for way in (shape.direction, -shape.direction):
                last = at[out @ way > config.along]
                high = None if len(last) < config.cells else _height(own, shape, last, way, config)
                lots += [] if high is None else [_end(shape, way, high, config)]
    return lots


def _height(
    own: KnownFace, shape: Cylinder, last: Floats, way: Floats, config: TurnedEndsConfig
) -> float | None:
    """[mm] along a (3,) way, of the end of a cylinder felt last at (n, 3) places; None where it is not level."""
    local = (last - shape.anchor) @ shape.frame
    round_ = around(np.arctan2(local[:, 1], local[:, 0])) > config.around
    heights = last @ way + 0.5 * own.near_free.query(last)[0]
    high = float(np.median(heights))
    level = float(np.median(np.abs(heights - high))) < config.level
    felt = float(np.quantile(own.cells @ way, 0.98)) < high + config.past
    return high if level and felt and round_ else None


def _end(shape: Cylinder, way: Floats, high: float, config: TurnedEndsConfig) -> Contacts:
    """Contacts of a flat end at a height [mm] along a (3,) way, just inside the cylinder; nobody felt it."""
    turn = 2.0 * np.pi * np.arange(config.ring) / config.ring
    ways = np.column_stack([np.cos(turn), np.sin(turn)]) @ shape.frame[:, :2].T
    center = shape.anchor + (high - float(shape.anchor @ way)) * way
    points = np.concatenate([center + (shape.radius - deep) * ways for deep in config.deep])
    normals = np.broadcast_to(way, points.shape)
    return Contacts.of(points, normals, config.unsure, config.normal_sigma, touch=NOT_FELT)


def _places(rim: Sighting, shape: Cylinder | Cone, config: TurnedEndsConfig) -> Floats:
    """(n, 3) places of the end beside a rim, on the material's side of it."""
    axis = shape.direction
    inward = (rim.normal @ axis) * axis - rim.normal
    beside = rim.point + np.outer(config.deep, inward / np.linalg.norm(inward))
    turns = [se3.turn_about(shape.anchor, axis, angle) for angle in (-config.arc, 0.0, config.arc)]
    return np.concatenate([se3.transform_points(turn, beside) for turn in turns])
