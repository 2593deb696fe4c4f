"""Slots as the pictures of the faces round them show them: where their sides and ends are, and which are round.

What is seen at the apex of a round end looks like a straight edge.  A square end has two corners beyond it, where
no face is; at a round one the faces go on there.  In a picture that is soft by s a hole of radius r seems to end
s^2 / 2 r too early, for the face lies round its end on three sides (our derivation).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.special import ndtr

from exploration.planning.inferring.slots import Slot
from exploration.planning.known.mosaic import Mosaic
from exploration.planning.known.picture_lines import begins, share_at
from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT
from primitives.fit import Fit
from primitives.patch_graph import Face


@dataclass(frozen=True)
class SlotEndsConfig:
    """Where the pictures are asked."""

    about: float = 5.0  # [mm] from where a slot was taken to end
    soft: float = 1.4  # [mm] standard deviation of what a picture makes of an edge
    narrow: float = 0.8  # of its length, that it is wide at most
    stations: int = 7  # along its straight part, where a side was seen
    corner: float = 0.85  # of half its width, along and across, where only a square end has no face
    widest_unsure: float = 8.0  # [mm] of a slot, up to which a picture is too soft to tell its corners
    beside: float = 2.5  # [mm] from an end, up to which a wall may be its own
    square: float = 0.95  # least cosine between the slot's way and that of a wall across it, or beside it
    off: float = 0.8  # [mm] from a side, of what was inferred of it,
    begun: float = 0.5  # [mm] and past where a round end begins


def as_seen(slot: Slot, mosaic: Mosaic, config: SlotEndsConfig = SlotEndsConfig()) -> Slot:
    """A slot with sides and ends where they were seen; these are round, unless it was seen that they are not."""
    sides = [_side(slot, side, mosaic, config) for side in (1.0, -1.0)]
    left, right = (0.5 * slot.width if side is None else side for side in sides)
    if left + right < config.narrow * slot.length:
        middle = slot.center + 0.5 * (left - right) * np.cross(slot.axis, slot.along)
        slot = replace(slot, center=middle, width=left + right)
    ends = [_apex(slot, side, mosaic, config) for side in (1.0, -1.0)]
    ahead, behind = (0.5 * slot.length if end is None else end for end in ends)
    if ahead + behind < slot.width:
        return slot
    seen = _reaching(slot, ahead, behind)
    short = [
        0.0 if end is None or _is_round(seen, side, mosaic, config) is False else _short(slot, config)
        for end, side in zip(ends, (1.0, -1.0), strict=True)
    ]
    return _reaching(slot, ahead + short[0], behind + short[1])


def flat_ends(
    slot: Slot, faces: Sequence[Face], mosaic: Mosaic, config: SlotEndsConfig = SlotEndsConfig()
) -> set[int]:
    """The ids of inferred faces across those ends of a slot that were seen to be round."""
    found = set[int]()
    for side in (1.0, -1.0):
        if _is_round(slot, side, mosaic, config):
            found |= {face.id for face in faces if _crosses(face, slot, side, config)}
    return found


def bounded(faces: Sequence[Face], slot: Slot, config: SlotEndsConfig = SlotEndsConfig()) -> tuple[Face, ...]:
    """The faces, of which nothing is inferred along a side of a slot past where its round ends begin.

    A rim looks straight a few millimeters farther than it is.  An end that a face runs across is flat.
    """
    ends = [
        side for side in (1.0, -1.0) if not any(_across(face, slot, side, config).any() for face in faces)
    ]
    kept = [~_past_its_sides(face, slot, ends, config) for face in faces]
    return tuple(
        face.only(some) for face, some in zip(faces, kept, strict=True) if some.any() or not len(some)
    )


def _past_its_sides(face: Face, slot: Slot, ends: Sequence[float], config: SlotEndsConfig) -> Bools:
    """(n,) which contacts of a flat face are inferred along a side of a slot, past where such ends begin."""
    past = np.zeros(len(face.contacts), dtype=bool)
    if not isinstance(face.fit, Fit) or face.fit.kind != "plane":
        return past
    away, across = face.contacts.points - slot.center, np.cross(slot.axis, slot.along)
    beside = np.abs(np.abs(away @ across) - 0.5 * slot.width) < config.off
    beside &= np.abs(face.contacts.normals @ across) > config.square
    beside &= np.abs(away @ slot.axis) < 0.5 * slot.depth
    for side in ends:
        beyond = side * (away @ slot.along) - 0.5 * (slot.length - slot.width)
        past |= (beyond > config.begun) & (beyond < 0.5 * slot.width + config.beside)
    return np.asarray(past & beside & (face.contacts.touch == NOT_FELT))


def _reaching(slot: Slot, ahead: float, behind: float) -> Slot:
    """A slot with its ends so many mm from where its center is now."""
    return replace(slot, center=slot.center + 0.5 * (ahead - behind) * slot.along, length=ahead + behind)


def _is_round(slot: Slot, side: float, mosaic: Mosaic, config: SlotEndsConfig) -> bool | None:
    """Whether an end was seen to be round; None where that was not seen, or the slot is too narrow to tell."""
    if slot.width <= config.widest_unsure:
        return None
    shares = [_cornered(slot, side, up, mosaic, config) for up in (1.0, -1.0)]
    told = [share for share in shares if np.isfinite(share)]
    return float(np.mean(told)) > _between(slot, config) if told else None


def _short(slot: Slot, config: SlotEndsConfig) -> float:
    """[mm] that a round end seems to begin too early; no more where it is too narrow for that to hold."""
    return config.soft**2 / max(slot.width, 4.0 * config.soft)


def _between(slot: Slot, config: SlotEndsConfig) -> float:
    """The share half way between those that a soft picture has in the corners of a square end and a round one."""
    half = 0.5 * slot.width / config.soft
    square = 1.0 - ndtr((1.0 - config.corner) * half) ** 2
    return 0.5 * float(square + ndtr((np.sqrt(2.0) * config.corner - 1.0) * half + 0.5 / half))


def _apex(slot: Slot, side: float, mosaic: Mosaic, config: SlotEndsConfig) -> float | None:
    """[mm] from a slot's center to one end along its middle; None where that was not seen."""
    out = np.arange(-config.about, config.about, mosaic.config.step) + 0.5 * slot.length
    shares = [_share(slot, side * out[:, None] * slot.along, up, mosaic) for up in (1.0, -1.0)]
    found = [edge for share in shares if (edge := begins(out, share)) is not None]
    return float(np.mean(found)) if found else None


def _side(slot: Slot, side: float, mosaic: Mosaic, config: SlotEndsConfig) -> float | None:
    """[mm] from a slot's middle to one side of it; None where that was not seen."""
    across, reach = np.cross(slot.axis, slot.along), 0.4 * (slot.length - slot.width)
    out = np.arange(0.0, 0.5 * slot.width + config.about, mosaic.config.step)
    found = []
    for along in np.linspace(-reach, reach, config.stations):
        away = along * slot.along + side * out[:, None] * across
        shares = (_share(slot, away, up, mosaic) for up in (1.0, -1.0))
        found += [edge for share in shares if (edge := begins(out, share)) is not None]
    return float(np.median(found)) if len(found) >= config.stations else None


def _cornered(slot: Slot, side: float, up: float, mosaic: Mosaic, config: SlotEndsConfig) -> float:
    """How much of a face round it is in both corners that a square end would have; NaN where nobody saw."""
    half, across = 0.5 * slot.width, np.cross(slot.axis, slot.along)
    ahead = side * (0.5 * slot.length - (1.0 - config.corner) * half) * slot.along
    return float(
        _share(slot, ahead + config.corner * half * np.outer([1.0, -1.0], across), up, mosaic).mean()
    )


def _share(slot: Slot, away: Floats, up: float, mosaic: Mosaic) -> Floats:
    """(n,) of the face at one mouth of a slot, (n, 3) from the middle of that; NaN where nobody saw."""
    mouth = slot.center + 0.5 * up * slot.depth * slot.axis
    turn = np.column_stack([slot.along, np.cross(slot.axis, slot.along)])
    return share_at(mosaic, up * slot.axis, mouth + away, turn)


def _crosses(face: Face, slot: Slot, side: float, config: SlotEndsConfig) -> bool:
    """Whether a face is inferred, and nothing but flat across one end of a slot."""
    at_end = _across(face, slot, side, config)
    return bool(at_end.any() and at_end.all() and (face.contacts.touch == NOT_FELT).all())


def _across(face: Face, slot: Slot, side: float, config: SlotEndsConfig) -> Bools:
    """(n,) which contacts of a flat face lie at one end of a slot that it runs straight across."""
    nowhere = np.zeros(len(face.contacts), dtype=bool)
    if not isinstance(face.fit, Fit) or face.fit.kind != "plane":
        return nowhere
    if abs(float(face.fit.shape.direction @ slot.along)) < config.square:
        return nowhere
    away = face.contacts.points - slot.center
    past = side * (away @ slot.along) - 0.5 * (slot.length - slot.width)
    across = np.abs(away @ np.cross(slot.axis, slot.along))
    within = 0.5 * slot.width + config.beside
    return np.asarray((past > 0.0) & (past < within) & (across < within))
