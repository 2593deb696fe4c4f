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
    off: float = 0.25  # [mm] of a contact from where a face would come again,
    facing: float = 0.985  # and least cosine of its normal with its own
    contacts: int = 4  # of them at least,
    turn: float = 0.35  # [rad] that their normals go round
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
    if not isinstance(made, Fit):
        return None
    number = 1 + max((face.id for face in graph.faces), default=-1)
    return Face(number, replace(made, inliers=frozen(np.ones(len(best)), bool)), best)


def _steps(graph: PatchGraph, config: RepeatedConfig) -> Iterator[tuple[_Round, Floats]]:
    """Cylinders, and the (4, 4) motions that take each a step on from another that is equal."""
    fits = [(face, face.fit) for face in graph.faces if isinstance(face.fit, Fit)]
    centers = [own.shape for _, own in fits if isinstance(own.shape, Cylinder | Cone)]
    rounds = [_Round(f.contacts, own.shape, own.convex) for f, own in fits if isinstance(own.shape, Cylinder)]
    for a, b in permutations(rounds, 2):
        shift, axis = b.shape.anchor - a.shape.anchor, b.shape.axis
        equal = a.convex == b.convex and abs(a.shape.radius - b.shape.radius) < config.equal
        if not equal or abs(float(a.shape.axis @ axis)) < config.parallel:
            continue
        yield b, pose(None, shift - shift @ axis * axis)
        for center in centers:
            angle = _turn(a.shape, b.shape, center, config)
            if angle is not None:
                yield b, turn_about(center.anchor, axis, angle)


def _turn(a: Cylinder, b: Cylinder, center: Cylinder | Cone, config: RepeatedConfig) -> float | None:
    """[rad] from one to the other round the axis of a third; None where that is not parallel, or no center."""
    arms = [shape.anchor - center.anchor for shape in (a, b)]
    first, second = (arm - arm @ b.axis * b.axis for arm in arms)
    far, other = float(np.linalg.norm(first)), float(np.linalg.norm(second))
    level = abs(float(center.axis @ b.axis)) > config.parallel
    if not level or min(far, other) < config.equal or abs(far - other) > config.equal:
        return None
    return float(np.arctan2(np.cross(first, second) @ b.axis, first @ second))


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
