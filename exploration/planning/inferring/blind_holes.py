"""Floors of round holes that are shut behind, and that no array came to.

Who was in a hole knows how deep it is at least.  Where what lies behind it, and looks the other way, was felt
inside its circle all round, the hole ends before that: its floor is taken for where an array got to, and marked as
inferred (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exploration.planning.open.holes import Hole
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.pose import frame_along


@dataclass(frozen=True)
class BlindHolesConfig:
    """What shuts a hole, and what its floor is."""

    upright: float = 0.98  # least cosine between the axis and the normal of what shuts it,
    inward: float = 0.3  # and of what was felt of its inside
    within: float = 0.8  # of the radius, inside which that was felt
    least: int = 4  # contacts
    lopsided: float = 0.7  # most length of the mean of the ways there: a pad's overhang is on one side
    behind: float = 1.0  # [mm] behind where an array got to
    before: float = 4.0  # [mm] before that, from where on what was felt of its inside is its floor
    rings: tuple[float, ...] = (0.3, 0.7)  # of the radius, where contacts of the floor are,
    around: int = 12  # so many on each
    sigma: float = 0.5  # [mm]
    normal_sigma: float = 0.05  # [rad]


def floor_of(
    hole: Hole, faces: Sequence[Face], config: BlindHolesConfig = BlindHolesConfig()
) -> Contacts | None:
    """Contacts of the floor of a hole, which nobody felt; None where it may go through, or is known.

    What was felt inside it and looks out of it, before what shuts it, is its floor, or stands in a room behind it.
    """
    end = hole.middle - 0.5 * hole.depth * hole.axis
    felt = Contacts.concatenate([face.contacts for face in faces if isinstance(face.fit, Fit)])
    felt = felt.select((felt.touch != NOT_FELT) & felt.has_normal)
    away, looks = felt.points - end, felt.normals @ hole.axis
    up = away @ hole.axis
    ways = away - np.outer(up, hole.axis)
    inside = np.linalg.norm(ways, axis=1) < config.within * hole.radius
    behind = inside & (looks < -config.upright) & (up < -config.behind)
    nearest = behind & (up > up[behind].max(initial=-np.inf) - config.behind)
    if int(nearest.sum()) < config.least or not _all_round(ways[nearest], config):
        return None
    known = inside & (looks > config.inward) & (up < config.before) & (up > up[nearest].min())
    return None if known.any() else _contacts(hole, end, config)


def _all_round(ways: Floats, config: BlindHolesConfig) -> bool:
    units = ways / np.maximum(np.linalg.norm(ways, axis=1, keepdims=True), 1e-9)
    return float(np.linalg.norm(units.mean(axis=0))) < config.lopsided


def _contacts(hole: Hole, end: Floats, config: BlindHolesConfig) -> Contacts:
    turn = 2.0 * np.pi * np.arange(config.around) / config.around
    ways = np.column_stack([np.cos(turn), np.sin(turn)]) @ frame_along(hole.axis)[:, :2].T
    points = np.concatenate([end + share * hole.radius * ways for share in config.rings])
    normals = np.broadcast_to(hole.axis, points.shape)
    return Contacts.of(points, normals, config.sigma, config.normal_sigma, touch=NOT_FELT)
