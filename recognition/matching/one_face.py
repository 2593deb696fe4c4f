"""Poses that hold contacts on one flat face share the room that the face has for a single contact.

A finger that keeps to a face turns back at its edges, wherever these are, so that contacts all over a small face
are no less likely than as many on a part of a large one.  A mode of the pose is narrow where contacts lie near an
edge, though, and wide where they do not, which would favor the large face.  So the modes of a face divide the
volume that one contact has there, as their own volumes V stand to each other::

    V_k' = V_k / (sum of V over the face) * 2 pi A_F n_F (2 pi)^(3/2) |H_across|^(-1/2)

with A_F the face's area, n_F how many faces the object's symmetry makes of it, and H_across what is known of the
height and tilt over it.  Summed over all faces A_F n_F is the whole surface, whose density is 1 / A, so that of an
object that has such a face only the share of that in its surface is told (our derivation).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.special import logsumexp

from models.library import Entry
from primitives.arrays import Floats
from recognition.matching.flats import Flat, flats_of
from recognition.matching.lone_face import LoneFace
from recognition.matching.span import bounds
from recognition.matching.target import Target, gap

_LYING = 0.1  # [rad] of the contacts' mean normal to a face that they lie on,
_OFF = 1.0  # [mm] of their middle from its plane,
_GAPS = 3.0  # and between samples, of a contact from the nearest of its samples
_SAME = 0.01  # of the object's size, and of a unit vector, within which faces are one


def face_under(one: LoneFace, found: Floats, flats: tuple[Flat, ...], near: float) -> tuple[int, bool] | None:
    """Which flat face lies there at a (3, 4) pose object_from_world, and whether it looks the same way; or None.

    `near` [mm] is how far samples are apart.
    """
    point, facing = found[:, :3] @ one.point + found[:, 3], found[:, :3] @ one.facing
    best: tuple[int, bool] | None = None
    least = _GAPS * near
    for k, flat in enumerate(flats):
        along = float(flat.axes[:, 2] @ facing)
        height = float(flat.axes[:, 2] @ (point - flat.middle))
        if abs(height) > _OFF or (along if one.signed else abs(along)) < np.cos(_LYING):
            continue
        away = float(np.linalg.norm(flat.points - point, axis=1).min())
        if away < least:
            best, least = (k, along > 0.0), away
    return best


class Room(NamedTuple):
    """What a face has for one contact."""

    face: tuple[int, bool]  # the first of those that are alike, and whether contacts look out of it
    log_volume: float


def log_room(flat: Flat, copies: int, information: Floats) -> float:
    """Logarithm of the volume that one contact has on so many `copies` of a face.

    `information` (6, 6) is what all contacts tell of (v [mm], w [rad]), in the object's frame.
    """
    u, v, n = flat.axes.T
    rows = np.zeros((3, 6))
    rows[0, :3], rows[1, 3:], rows[2, 3:] = n, u, v
    across = float(np.linalg.slogdet(rows @ information @ rows.T)[1])
    return float(2.5 * np.log(2.0 * np.pi) + np.log(flat.area * copies) - 0.5 * across)


def orbits(entry: Entry, flats: tuple[Flat, ...], size: float) -> list[tuple[int, int]]:
    """Of each face the first that a symmetry of the object makes of it, and how many there are."""
    turns = entry.symmetry.rotations
    found = []
    for flat in flats:
        middles = turns[:, :3, :3] @ flat.middle + turns[:, :3, 3]
        normals = turns[:, :3, :3] @ flat.axes[:, 2]
        same = [
            k
            for k, other in enumerate(flats)
            if bool(
                (
                    (np.linalg.norm(middles - other.middle, axis=1) < _SAME * size + 1.0)
                    & (np.linalg.norm(normals - other.axes[:, 2], axis=1) < _SAME)
                ).any()
            )
        ]
        found.append((min(same), len(same)))
    return found


def rooms_of(one: LoneFace, entry: Entry, target: Target, poses: Floats, known: Floats) -> list[Room | None]:
    """The rooms of the faces that lie there at (k, 3, 4) poses object_from_world; None where that is no flat one.

    `known` (k, 6, 6) is what all contacts tell of (v [mm], w [rad]) there, in the object's frame.
    """
    flats = flats_of(entry)
    alike, rooms = orbits(entry, flats, target.size), list[Room | None]()
    for at, information in zip(poses, known, strict=True):
        under = face_under(one, at, flats, gap(target))
        if under is None:
            rooms.append(None)
            continue
        face, out = under
        first, copies = alike[face]
        rooms.append(Room((first, out), log_room(flats[face], copies, information + bounds(target))))
    return rooms


def divided(
    volumes: list[float], rooms: list[Room | None], log_share: float = 0.0
) -> tuple[list[float], list[float]]:
    """Logarithms of volumes, those of modes on one face divided anew, and of their shares in its room.

    Where other modes, that are not here, have the rest, the room to divide is `log_share` of the whole.
    """
    out, shares = list(volumes), [0.0] * len(volumes)
    for face in {room.face for room in rooms if room is not None}:
        here = [(k, room) for k, room in enumerate(rooms) if room is not None and room.face == face]
        together = float(logsumexp([volumes[k] for k, _ in here]))
        for k, _ in here:
            shares[k] = log_share + volumes[k] - together
            out[k] = here[0][1].log_volume + shares[k]
    return out, shares
