"""Poses that hold contacts on one round face share the room that the face has for a single contact.

As on a flat face (`one_face`), a finger turns back at a face's edges, wherever these are.  Contacts near an edge
hold a pose along the face, others let it slide, which would favor the longer face.  So what is known of motions
that leave the round shape as it is, its lower pair (Reuleaux 1875), is left out, the room of a single contact is
asked for in its place (`room`), and modes that these motions take into each other divide it as their own volumes
stand to each other (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from models.library import Entry
from primitives.arrays import Floats, frozen
from primitives.shapes import Cylinder, Shape, Sphere
from recognition.matching.belief import Hypothesis
from recognition.matching.one_face import Room
from recognition.matching.room import Lone, log_room
from recognition.matching.span import log_copies, same, spread_of
from recognition.matching.target import Target


def rooms_round(
    shape: Shape,
    made: Sequence[Hypothesis],
    entry: Entry,
    target: Target,
    poses: Floats,
    known: Floats,
    points: Floats,
    middle: Lone,
) -> list[Room | None]:
    """The rooms at (k, 3, 4) poses object_from_world, of contacts at (n, 3) points that lie on a round `shape`.

    `known` (k, 6, 6) is what all contacts tell of (v [mm], w [rad]) about their middle, in the object's frame.
    """
    twists = sliding(shape, points.mean(axis=0))
    rooms, wide = list[Room | None](), list[Hypothesis]()
    for h, at, information in zip(made, poses, known, strict=True):
        left = _without(information, twists, at)
        covariance, log_volume = spread_of(left, at, points, entry, target)
        alike = same(entry, wide, h.pose, target)
        face = int(np.argmax(alike)) if alike.any() else len(wide)
        wide.append(replace(h, covariance=frozen(covariance)))
        log_volume += log_room(at, covariance, middle, target) + log_copies(entry, covariance, target)
        rooms.append(Room((face, True), log_volume))
    return rooms


def sliding(shape: Shape, middle: Floats) -> Floats:
    """(k, 6) twists (v [mm], w [rad]) about a (3,) `middle` that leave a round shape as it is."""
    arm = middle - shape.anchor
    axes = np.eye(3) if isinstance(shape, Sphere) else shape.direction[None]
    turns = np.hstack([np.cross(axes, arm), axes])
    if not isinstance(shape, Cylinder):
        return turns
    return np.vstack([turns, [*shape.direction, 0.0, 0.0, 0.0]])


def _without(information: Floats, twists: Floats, found: Floats) -> Floats:
    """(6, 6) of what is known, nothing along (k, 6) twists of the world, at a (3, 4) pose object_from_world."""
    turn = found[:, :3]
    rows = np.hstack([twists[:, :3] @ turn.T, twists[:, 3:] @ turn.T])
    axes, _ = np.linalg.qr(rows.T)
    rest = np.eye(6) - axes @ axes.T
    return np.asarray(rest @ information @ rest)
