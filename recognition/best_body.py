"""Fitted faces -> the best body that they allow: whole, cut off where nothing closes it, or of fewer faces.

First all faces as they are.  A body that nothing closes is cut off at the last contacts.  Where the faces still
leave none, as when a narrow edge was read as a cone, the round face with the fewest contacts is left out, and the
rest is tried again; flat faces are not.  Walls that were only inferred are left out where most contacts lie off
the body, or faces that were felt bound no side of it.  Where most lie off it still, their hull takes its place;
where a smooth surface lies much nearer, that does.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit, fit
from primitives.plate import Plate
from recognition.assembly import Assembly, NotClosed, assemble
from recognition.assembly.cut_off import CutOffConfig, cut_off
from recognition.freeform import bends, freeform, unfelt
from recognition.hulled import BETTER, MOST, all_on_hull, hulled, mean_distance, off_body
from recognition.open_sides import ALONG, open_ended, open_ways

_FEW = 6  # contacts outside the body, that are no strays
_SHORT = 4.0  # [mm] that they are outside it, from which it lacks a limb
_LEFT_OUT = 8  # faces at most
_POOR = 8  # contacts of a flat face, of which fewer may be those of a thin bar
_ON = 0.01  # [mm] from a surface, of a triangle that is on it
_IDLE = 20  # contacts of felt faces that bound nothing, from which walls that nobody felt are doubted
_LESS_IDLE = 0.5  # times those, as which fewer must be idle without the walls
_TAKEN_BACK = 6  # walls that nobody felt, of those that are doubted, at most
_AS_NEAR = 1.01  # times the mean distance of what was felt from the body, as which it stays with one of them
_BESIDE = 15.0  # [mm] from all contacts, from which a smooth surface was not felt
_APART = 0.15  # of the longest side, the same of small objects
_UNFELT = 0.01  # share of it, from which it does not close the body
_OPEN = 4.0  # [mm] past all contacts, from which a body with a side that no face ends is cut off
_FAR = 1.0  # times as far as what was felt is across, past which a body cannot be told to reach


@dataclass(frozen=True)
class FeltFace:
    """A face that has a shape."""

    fit: Fit
    contacts: Contacts


@dataclass(frozen=True)
class Body:
    """What was assembled of which faces; the fits of an assembly are those of `felt` and then of `ends`."""

    assembly: Assembly | NotClosed
    felt: tuple[FeltFace, ...]
    ends: tuple[FeltFace, ...] = ()  # that nobody felt, where the body is cut off
    left_out: tuple[FeltFace, ...] = ()
    faceless: bool = False  # whether it is made of all contacts, and much of it lies on none

    def told(self) -> list[str]:
        """What was left out and where it is cut off, in words."""
        if isinstance(self.assembly, NotClosed):
            return []
        left = [
            f"a face ({face.fit.kind}, {len(face.contacts)} contacts) contradicts the others; left out"
            for face in self.left_out
        ]
        ends = [end.contacts.normals[0] for end in self.cut]
        ends += [way for way in open_ways(self.assembly) if not any(way @ end > ALONG for end in ends)]
        ways = [", ".join(f"{v:.2f}" for v in end) for end in ends]
        ended = "nothing that was felt ends the body along ({}): it is cut off where contact ended"
        return [*left, *map(ended.format, ways)]

    @property
    def whole(self) -> bool:
        """Whether its faces close it."""
        if isinstance(self.assembly, NotClosed):
            return not self.faceless
        return not self.cut and not self.faceless and not open_ways(self.assembly)

    @property
    def cut(self) -> tuple[FeltFace, ...]:
        """The ends that the body has."""
        if isinstance(self.assembly, NotClosed):
            return ()
        first = len(self.felt)
        return tuple(end for k, end in enumerate(self.ends) if _bounds(self.assembly, first + k))


Make = Callable[[tuple[FeltFace, ...]], Assembly | NotClosed]


def best_body(
    felt: Sequence[FeltFace],
    box: Floats,
    free: Floats | None,
    past: float,
    loose: Contacts | None = None,
    plates: Sequence[Plate] = (),
) -> Body:
    """Of faces in a (2, 3) workspace `box` [mm]; one that reaches `past` mm past all contacts is cut off.

    So is one sooner that has a side which no face ends, not even at a corner that no array comes to.
    Where most contacts lie off it, the `loose` ones of no face among them, flat walls that nobody felt may have
    cut it: it is tried without them.  Where that is no better, the contacts' hull is taken instead.  There is none
    where all that was felt is a small part of it.
    """
    rest = Contacts.of([]) if loose is None else loose
    make = partial(_assembled, box=box, free=free, stray=rest.points, plates=plates)
    contacts = Contacts.concatenate([*(face.contacts for face in felt), rest])
    places = contacts.points[contacts.touch != NOT_FELT]
    body = _of_faces(felt, make, past, contacts)
    surer = [face for face in felt if not _is_guessed(face)]
    if len(surer) < len(felt) and (off := off_body(body.assembly, places)) > MOST:
        other = _of_faces(surer, make, past, contacts)
        body = other if off_body(other.assembly, places) < BETTER * off else body
    if len(surer) < len(felt) and _idle(body) > _IDLE:
        body = _less_guessed(body, make, past, contacts)
    if open_ended(body.assembly) and reach_past(body.assembly, contacts) > (most := min(_OPEN, past)):
        bare = make(body.felt) if body.ends else body.assembly
        sooner = replace(_ended(bare, body.felt, make, most), left_out=body.left_out)
        nearer = reach_past(sooner.assembly, contacts) < reach_past(body.assembly, contacts)
        body = sooner if nearer else body
    reach = reach_past(body.assembly, contacts)
    if np.isfinite(reach) and reach > _FAR * _across(places):
        far = NotClosed("the faces that were measured reach far past all that was felt")
        body = replace(body, assembly=far)
    if (hull := hulled(body.felt, contacts, body.assembly, free)) is not None:
        body = Body(hull, body.felt, (), body.left_out, True)
    smooth = freeform(body.felt, contacts, body.assembly, free, hull is not None)
    if smooth is not None:
        beside = min(_BESIDE, _APART * float(np.ptp(places, axis=0).max()))
        if (share := unfelt(smooth.solid, places, beside)) > _UNFELT:
            told = f"{share:.0%} of it is farther than {beside:.0f} mm from all contacts, and counts as open"
            smooth = replace(smooth, warnings=(*smooth.warnings, told))
        body = Body(smooth, body.felt, (), body.left_out, share > _UNFELT)
    return body


def _across(places: Floats) -> float:
    """[mm] from one end of (n, 3) places to the other, about."""
    return float(np.linalg.norm(np.ptp(places, axis=0))) if len(places) else 0.0


def _is_guessed(face: FeltFace) -> bool:
    """Whether it is a flat wall that nobody felt."""
    return face.fit.kind == "plane" and not (face.contacts.touch != NOT_FELT).any()


def _idle(body: Body) -> int:
    """Contacts of faces that were felt and bound no side of the body, or were left out of it."""
    if isinstance(body.assembly, NotClosed):
        return 0
    idle = [face for k, face in enumerate(body.felt) if not _bounds(body.assembly, k)]
    return sum(int((face.contacts.touch != NOT_FELT).sum()) for face in (*idle, *body.left_out))


def _less_guessed(body: Body, make: Make, past: float, contacts: Contacts) -> Body:
    """The body without the flat walls that nobody felt and that keep faces out of it which were; else itself.

    All are left out first.  One is taken back, those of most contacts first, if with it no more of what was felt
    is idle, and what was felt lies as near.
    """
    guessed = sorted(filter(_is_guessed, body.felt), key=lambda face: -len(face.contacts))
    kept = [face for face in body.felt if not _is_guessed(face)]
    best = _of_faces(kept, make, past, contacts)
    if isinstance(best.assembly, NotClosed):
        return body
    best = replace(best, left_out=(*body.left_out, *best.left_out))
    if _idle(best) > _LESS_IDLE * _idle(body):
        return body
    places = contacts.points[contacts.touch != NOT_FELT]
    near = mean_distance(best.assembly, places)
    for face in guessed[:_TAKEN_BACK]:
        found = _of_faces([*best.felt, face], make, past, contacts)
        found = replace(found, left_out=(*best.left_out, *found.left_out))
        if _idle(found) <= _idle(best) and mean_distance(found.assembly, places) <= _AS_NEAR * near:
            best = found
    return best


def _bounds(assembly: Assembly, number: int) -> bool:
    """Whether the surface of a fit is a side of the body; of one inside another limb nothing is left."""
    if assembly.surface_of_fit[number] is None:
        return False
    solid = assembly.solid
    on = np.abs(assembly.shape(number).signed_distance(solid.vertices)) < _ON
    return bool(on[solid.triangles].all(axis=1).any())


def _of_faces(felt: Sequence[FeltFace], make: Make, past: float, contacts: Contacts) -> Body:
    """The body of all faces, or without some; of many round ones only where no hull or smooth body may be."""
    whole = first = _closed(tuple(felt), make, past)
    crumbs = sum(face.fit.kind != "plane" for face in felt) > _LEFT_OUT
    places = contacts.points[contacts.touch != NOT_FELT]
    if crumbs and isinstance(first.assembly, NotClosed) and (all_on_hull(places) or bends(felt, contacts)):
        return first
    if isinstance(first.assembly, NotClosed):
        whole = _less_poor(first, make, past)
    while isinstance(whole.assembly, NotClosed) and len(whole.left_out) < _LEFT_OUT:
        rounds = [face for face in whole.felt if face.fit.kind != "plane"]
        if not rounds or len(whole.felt) < 2:
            return first
        poorest = min(rounds, key=lambda face: len(face.contacts))
        rest = tuple(face for face in whole.felt if face is not poorest)
        found = _closed(rest, make, past)
        whole = Body(found.assembly, rest, found.ends, (*whole.left_out, poorest))
    return first if isinstance(whole.assembly, NotClosed) else whole


def _less_poor(body: Body, make: Make, most: float) -> Body:
    """The body of round faces without flat ones of few contacts, as which a thin bar is read too; else itself."""
    flat = [face.fit.kind == "plane" for face in body.felt]
    poor = [is_flat and len(face.contacts) < _POOR for face, is_flat in zip(body.felt, flat, strict=True)]
    if not any(poor) or all(flat):
        return body
    found = _closed(tuple(face for face, left in zip(body.felt, poor, strict=True) if not left), make, most)
    left_out = tuple(face for face, left in zip(body.felt, poor, strict=True) if left)
    return body if isinstance(found.assembly, NotClosed) else replace(found, left_out=left_out)


def reach_past(assembly: Assembly | NotClosed, contacts: Contacts) -> float:
    """[mm] that the body reaches past all contacts; without end where none is closed."""
    if isinstance(assembly, NotClosed):
        return np.inf
    felt, bounds = contacts.points[contacts.touch != NOT_FELT], assembly.solid.bounds
    if not len(felt):
        return 0.0
    return float(max((felt.min(axis=0) - bounds[0]).max(), (bounds[1] - felt.max(axis=0)).max()))


def fall_short(assembly: Assembly | NotClosed, contacts: Contacts) -> float:
    """[mm] that a few contacts lie outside the body, as on a post of which nobody felt the end.

    Without end where there is no body.
    """
    if isinstance(assembly, NotClosed):
        return np.inf
    outside = assembly.solid.signed_distance(contacts.points[contacts.touch != NOT_FELT])
    return float(np.sort(outside)[-_FEW]) if len(outside) >= _FEW else 0.0


def _closed(felt: tuple[FeltFace, ...], make: Make, most: float) -> Body:
    return _ended(make(felt), felt, make, most)


def _ended(
    assembly: Assembly | NotClosed,
    felt: tuple[FeltFace, ...],
    make: Make,
    most: float,
) -> Body:
    """What faces made, and where they leave the body open, or it reaches too far or not far enough, its ends."""
    contacts = Contacts.concatenate([face.contacts for face in felt])
    past, short = reach_past(assembly, contacts), fall_short(assembly, contacts)
    if past > most or short > _SHORT:
        corners = None if isinstance(assembly, NotClosed) else assembly.solid.vertices
        fitted = ((fit("plane", lot), lot) for lot in cut_off(felt, corners, CutOffConfig(past=most)))
        ends = tuple(FeltFace(found, lot) for found, lot in fitted if isinstance(found, Fit))
        whole = make((*felt, *ends)) if ends else assembly
        if reach_past(whole, contacts) < past or (
            fall_short(whole, contacts) < short and reach_past(whole, contacts) <= max(past, most)
        ):
            return Body(whole, felt, ends)
    return Body(assembly, felt)


def _assembled(
    felt: tuple[FeltFace, ...], box: Floats, free: Floats | None, stray: Floats, plates: Sequence[Plate]
) -> Assembly | NotClosed:
    """The assembly; surfaces that contradict each other leave no body, and that is an answer too."""
    if not felt:
        return NotClosed("no face was measured")
    try:
        made = assemble(felt, box, free=free, stray=stray, plates=plates)
    except (PalpateError, ArithmeticError, ValueError, RuntimeError) as error:  # LinAlgError, QhullError
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        return NotClosed(f"the measured faces contradict each other ({reason})")
    empty = not isinstance(made, NotClosed) and not len(made.solid.triangles)
    return NotClosed("the measured faces hold no space between them") if empty else made
