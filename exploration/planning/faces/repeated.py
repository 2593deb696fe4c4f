"""Contacts of no face that lie where a known one would come again: one more scallop of a ring or groove of a row.

Two equal round faces are a step apart: a shift, or a turn about an axis that the object has.  Few contacts that
lie and face as the one or the other would, a step on, are hardly there by chance (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import permutations

import numpy as np

from exploration.planning.faces.uprighted import drawn_out
from primitives.arrays import Floats, frozen
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit, fit
from primitives.patch_graph import Face, PatchGraph
from primitives.pose import pose, rotate, transform_points, turn_about
from primitives.shapes import Cone, Cylinder


@dataclass(frozen=True)
class RepeatedConfig:
    """What is equal, and when contacts are of one more."""

    parallel: float = 0.999  # least cosine between axes
    equal: float = 0.3  # [mm] between radii, and between distances from the axis that faces go round
    elsewhere: float = 1.0  # [mm] from the axis of any face that is there already
    off: float = 0.25  # [mm] of a contact from where a face would come again,
    facing: float = 0.985  # and least cosine of its normal with its own
    contacts: int = 3  # of them at least,
    turn: float = 0.3  # [rad] that their normals go round
    carried: float = 0.15  # [mm] sigma of where a face would come again


@dataclass(frozen=True)
class _Round:
    """A cylinder that the object has."""

    contacts: Contacts
    shape: Cylinder
    convex: bool


def repeated_face(
    graph: PatchGraph, loose: Contacts, config: RepeatedConfig = RepeatedConfig()
) -> Face | None:
    """The one more of equal cylinders that most loose contacts are of; None where too few are."""
    best, like = loose.select(np.zeros(len(loose), dtype=bool)), loose
    for known, motion in _steps(graph, config) if len(loose) >= config.contacts else ():
        there, side = known.shape.transformed(motion), 1.0 if known.convex else -1.0
        near = np.abs(there.signed_distance(loose.points)) < config.off
        alike = (side * there.normals(loose.points) * loose.normals).sum(axis=1) > config.facing
        found = loose.select(near & alike)
        if len(found) > len(best) and _enough(found, config):
            best, like = found, _carried(known.contacts, motion, there.direction, config)
    if not len(best):
        return None
    made = fit("cylinder", Contacts.concatenate([best, like]))
    if not isinstance(made, Fit) or made.rms > config.off:
        return None
    number = graph.next_id
    return Face(number, replace(made, inliers=frozen(np.ones(len(best)), bool)), best)


def _steps(graph: PatchGraph, config: RepeatedConfig) -> Iterator[tuple[_Round, Floats]]:
    """Cylinders, and the (4, 4) motions that take each a step on from another that is equal, to where none is."""
    fits = [(face, face.fit) for face in graph.faces if isinstance(face.fit, Fit)]
    centers = [own.shape for _, own in fits if isinstance(own.shape, Cylinder | Cone)]
    rounds = [
        _Round(face.contacts.select(own.inliers), own.shape, own.convex)
        for face, own in fits
        if isinstance(own.shape, Cylinder)
    ]
    for a, b in permutations(rounds, 2):
        axis = b.shape.axis
        equal = a.convex == b.convex and abs(a.shape.radius - b.shape.radius) < config.equal
        if not equal or abs(float(a.shape.axis @ axis)) < config.parallel:
            continue
        at = b.contacts.points.mean(axis=0)
        start, end = _level(a.shape, at, axis), _level(b.shape, at, axis)
        motions = [pose(None, end - start)]
        for center in centers:
            angle = _turn(start, end, center, axis, at, config)
            motions += [] if angle is None else [turn_about(_level(center, at, axis), axis, angle)]
        for motion in motions:
            there = transform_points(motion, end[None])[0]
            if all(np.linalg.norm(_level(c.shape, there, axis) - there) > config.elsewhere for c in rounds):
                yield b, motion


def _level(shape: Cylinder | Cone, at: Floats, axis: Floats) -> Floats:
    """(3,) where the axis of a shape passes the height of a (3,) place along another (3,) axis."""
    way = shape.axis
    slope = float(way @ axis)
    return np.asarray(
        shape.anchor + float((at - shape.anchor) @ axis) / slope * way if slope else shape.anchor
    )


def _turn(
    start: Floats, end: Floats, center: Cylinder | Cone, axis: Floats, at: Floats, config: RepeatedConfig
) -> float | None:
    """[rad] from one place to another round a third axis; None where that is not parallel, or no center."""
    if abs(float(center.axis @ axis)) < config.parallel:
        return None
    middle = _level(center, at, axis)
    first, second = start - middle, end - middle
    far, other = float(np.linalg.norm(first)), float(np.linalg.norm(second))
    if min(far, other) < config.equal or abs(far - other) > config.equal:
        return None
    return float(np.arctan2(np.cross(first, second) @ axis, first @ second))


def _enough(found: Contacts, config: RepeatedConfig) -> bool:
    around = float((found.normals @ found.normals.T).min()) if len(found) else 1.0
    return len(found) >= config.contacts and around < np.cos(config.turn)


def _carried(contacts: Contacts, motion: Floats, axis: Floats, config: RepeatedConfig) -> Contacts:
    """What was felt of a face, a step on: few contacts tell neither a radius nor an axis."""
    moved = replace(
        contacts,
        points=frozen(transform_points(motion, contacts.points)),
        normals=frozen(rotate(motion, contacts.normals)),
        sigma=frozen(np.full(len(contacts), config.carried)),
        touch=frozen(np.full(len(contacts), NOT_FELT), np.int64),
    )
    return drawn_out(moved, axis)
