"""The walls of round holes that no array could lie on, from the rims at their ends.

Rims that were looked at, gaps in round faces and openings that are only guessed are each an end of a hole, of one
that narrows, or of one into a hollow that is known already; what is left of them stays an opening.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.inferring.adding import add, add_own, change
from exploration.planning.inferring.blind_holes import floor_of
from exploration.planning.inferring.far_ends import far_ends, into_bores, narrowed_ends, shut
from exploration.planning.inferring.grooves import grooves
from exploration.planning.inferring.led_into import hollows_of, led_into, own_rim
from exploration.planning.inferring.slanting import slanting
from exploration.planning.inferring.stepped_holes import stepped_holes
from exploration.planning.known.mosaic import Mosaic
from exploration.planning.open.cornered import cornered, pictured_cornered
from exploration.planning.open.holes import Hole, HolesConfig, ends_of_one, holes_of
from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.local_frontier import LocalFrontier
from exploration.planning.open.round_rims import RoundRim, far_end
from exploration.planning.touching.findings import Bore, Findings
from primitives.arrays import Floats
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shapes import Plane

_BY_ENDS = "the wall of a round hole is inferred from the rims at its ends"
_BY_REACH = (
    "the floor of a round hole is taken for where an array got to: behind it the object was felt closed"
)
_ALIKE = 0.95  # least cosine between two directions that are one
_RIM = 1.5  # [mm] from the face that a rim is of
_AROUND = 16.0  # [mm] round a hole, within which the face was felt that it comes out of
_NARROWER = 0.2  # [mm] than its rims, by which a hole is as an array felt it
_FELT = 0.04  # [mm] sigma of its radius then
_APART = 0.4  # of its depth between two arrays' places in it, from which they tell how it runs
_UNSURE = 0.12  # [mm] sigma of a hole's radius, from which an array tells it better, wider or narrower
_LIP = 2.5  # [mm] round a hole, where what looks like a straight edge is a part of its rim


def add_holes(found: Findings, frontier: Callable[[], LocalFrontier], inside: Floats, mosaic: Mosaic) -> None:
    """Holes between two rims, or from one to where a face is missing; and of all rims those that are edges."""
    found.rims = [rim for rim in found.rims if _is_on(rim.face, rim.center, rim.axis, found.graph.faces)]
    odd = [rim for rim in found.rims if _pictured(rim, found.graph.faces, mosaic)]
    found.odd += odd
    found.rims = [rim for rim in found.rims if not any(rim is other for other in odd)]
    guessed = _guessed(found, frontier(), mosaic)
    found.wall_rims, found.glimpsed = (
        [
            (rim, own)
            for rim, own in rims
            if _is_on(own, rim.point, rim.normal, found.graph.faces)
            and not any(_part_of(rim, hole) for hole in (*found.rims, *guessed))
        ]
        for rims in (found.wall_rims, found.glimpsed)
    )
    grooved = grooves(frontier().known, found.graph.faces, mosaic)
    gaps = [gap for gap in frontier().round_gaps if not any(groove.holds(gap.center) for groove in grooved)]
    rims = [*found.rims, *(gap for gap in gaps if not any(_told_by(gap, rim) for rim in found.rims))]
    # two mouths in round faces are no pair yet: in a tube's wall each leads into a bore, which is made known here
    apart, known = HolesConfig(leaning=np.inf), frontier().known
    single = [
        rim
        for rim in found.rims
        if far_end(rim, found.rims) is None and not any(ends_of_one(rim, other) for other in rims)
    ]
    guessed += narrowed_ends(single, known, inside)
    found.openings = _holes(found, rims, guessed, inside, known, apart)
    through = far_ends(found.openings, known := frontier().known)
    through += into_bores(found.openings, found.graph.faces)
    left = _holes(found, [*found.openings, *through], [], inside, known)
    found.openings = [rim for rim in left if not any(rim is end for end in through)]


def add_left_holes(
    found: Findings, frontier: Callable[[], LocalFrontier], inside: Floats, mosaic: Mosaic
) -> None:
    """Of openings that were left, once walls are known; and of those that are only guessed by then."""
    found.openings = _holes(
        found, [*found.openings, *_guessed(found, frontier(), mosaic)], [], inside, frontier().known
    )


def _holes(
    found: Findings,
    rims: Sequence[RoundRim],
    guessed: Sequence[RoundRim],
    inside: Floats,
    known: Sequence[KnownFace],
    config: HolesConfig | None = None,
) -> list[RoundRim]:
    """Add the walls of the holes that rims are the ends of, the far ends perhaps only guessed; the rims left."""
    hollows = hollows_of(found.graph.faces)
    rims = [rim for rim in rims if not own_rim(rim, hollows)]
    led = {id(rim): hole for rim in rims if (hole := led_into(rim, hollows)) is not None}
    rims = [rim for rim in rims if id(rim) not in led]
    steps = stepped_holes(rims, guessed, found.stopped, found.graph.faces)
    ends = [id(rim) for step in steps for rim in step.rims]
    single = [rim for rim in rims if id(rim) not in ends]
    holes, left = holes_of(single, inside, lambda rim: shut(rim, known), config or HolesConfig())
    faces = found.graph.faces
    blind = [hole for hole in holes if not _at_rim(hole, rims) and _ended(hole, faces) is hole]
    floors = [floor for hole in blind if (floor := floor_of(hole, faces)) is not None]
    holes = [hole if _at_rim(hole, rims) else slanting(_ended(hole, faces), faces) for hole in holes]
    holes = [_as_felt(hole, found.bores) for hole in holes]
    for hole in (*holes, *(hole for step in steps for hole in step.holes), *led.values()):
        change(found, hole.off)
        add(found, hole.wall(), _BY_ENDS, "cylinder")
    for floor in floors:
        add(found, floor, _BY_REACH)
    for step in steps:
        add_own(found, step.contacts, step.why, step.kind)
    return left


def _as_felt(hole: Hole, bores: Sequence[Bore]) -> Hole:
    """A hole as wide as arrays that went aside in it were stopped, and where: at both its ends, along the axis.

    Its rims may be chamfered or rounded, which leaves it narrower; mouths in round faces only tell it roughly.
    """
    felt = [bore for bore in bores if _in(hole, bore)]
    if not felt:
        return hole
    places = np.array([bore.center - bore.deep * bore.axis for bore in felt])
    first, last = places[[0, -1]]
    apart = float(np.linalg.norm(last - first))
    axis = hole.axis if hole.sigma < _UNSURE else felt[0].axis
    axis = (last - first) / apart if apart > _APART * hole.depth else axis
    axis = axis * np.sign(axis @ hole.axis)
    off = places.mean(axis=0) - hole.middle
    radius = float(np.mean([bore.radius for bore in felt]))
    return replace(
        hole, middle=hole.middle + off - (off @ axis) * axis, axis=axis, radius=radius, sigma=_FELT
    )


def _in(hole: Hole, bore: Bore) -> bool:
    """Whether what an array was stopped at is a hole's wall, and tells more of it than its rims do."""
    away = bore.center - hole.middle
    up = float(away @ hole.axis) * float(np.sign(bore.axis @ hole.axis))
    off = float(np.linalg.norm(away - (away @ hole.axis) * hole.axis))
    along = abs(float(bore.axis @ hole.axis)) > _ALIKE
    reached = up - bore.deep < 0.5 * hole.depth and up > -0.5 * hole.depth
    return (
        along and reached and off < _RIM and (hole.radius - bore.radius > _NARROWER or hole.sigma > _UNSURE)
    )


def _guessed(found: Findings, now: LocalFrontier, mosaic: Mosaic) -> list[RoundRim]:
    """Openings that nobody has looked at, and that no edge beside them and no picture tells to have corners."""
    edges, faces = [edge for edge, _ in (*found.wall_rims, *found.glimpsed)], found.graph.faces
    return [
        rim
        for rim in (*now.openings, *now.narrow)
        if not (_looked_at(rim, found) or cornered(rim, edges) or _pictured(rim, faces, mosaic))
    ]


def _pictured(rim: RoundRim, faces: Sequence[Face], mosaic: Mosaic) -> bool:
    """Whether the picture of its flat face shows that a rim is no circle; looks may have told it too high."""
    for face in faces:
        if face.id == rim.face and isinstance(face.fit, Fit) and isinstance(face.fit.shape, Plane):
            up = float((face.fit.shape.anchor - rim.center) @ rim.axis)
            return pictured_cornered(replace(rim, center=rim.center + up * rim.axis), mosaic)
    return False


def _told_by(gap: RoundRim, rim: RoundRim) -> bool:
    """Whether what is missing of a round face is the mouth whose rim was looked at."""
    away = rim.center - gap.center
    up = float(away @ gap.axis)
    aside = float(np.linalg.norm(away - up * gap.axis))
    return float(gap.axis @ rim.axis) > _ALIKE and aside < _RIM and abs(up) < gap.radius


def _at_rim(hole: Hole, rims: Sequence[RoundRim]) -> bool:
    """Whether a hole's far end is where a rim was seen."""
    far = hole.middle - 0.5 * hole.depth * hole.axis
    return any(float(np.linalg.norm(rim.center - far)) < _RIM for rim in rims)


def _ended(hole: Hole, faces: Sequence[Face]) -> Hole:
    """A hole no deeper than to the flat face that it comes out of: who goes through is in the open behind it."""
    mouth = hole.middle + 0.5 * hole.depth * hole.axis
    for face in faces:
        fit = face.fit
        if (
            not isinstance(fit, Fit)
            or fit.kind != "plane"
            or float(fit.shape.direction @ hole.axis) > -_ALIKE
        ):
            continue
        out = mouth - face.contacts.points
        deep = float((mouth - fit.shape.anchor) @ fit.shape.direction) / float(
            hole.axis @ fit.shape.direction
        )
        aside = np.linalg.norm(out - np.outer(out @ hole.axis, hole.axis), axis=1)
        if _RIM < deep < hole.depth and aside.min() < hole.radius + _AROUND:
            hole = replace(hole, middle=mouth - 0.5 * deep * hole.axis, depth=deep)
    return hole


def _part_of(rim: Sighting, hole: RoundRim) -> bool:
    """Whether an edge that looks straight is a part of a round hole's rim, at one end of it or the other."""
    away = rim.point - hole.center
    aside = float(np.linalg.norm(away - (away @ hole.axis) * hole.axis))
    return abs(float(rim.normal @ hole.axis)) > _ALIKE and aside < hole.radius + _LIP


def _is_on(own: int, at: Floats, normal: Floats, faces: Sequence[Face]) -> bool:
    """Whether the face that a rim was seen from is still one at a (3,) place, and did not turn out round."""
    for face in faces:
        if isinstance(face.fit, Fit) and (face.id == own or face.fit.kind == "plane"):
            side, shape = (1.0 if face.fit.convex else -1.0), face.fit.shape
            near = abs(float(shape.signed_distance(at[None])[0])) < _RIM
            if near and side * float(shape.normals(at[None])[0] @ normal) > _ALIKE:
                return True
    return False


def _looked_at(rim: RoundRim, found: Findings) -> bool:
    """Whether a look has measured a rim, or found none there."""
    measured = [o.center for o in found.rims if o.face == rim.face]
    return any(np.linalg.norm(rim.center - center) < rim.radius for center in (*measured, *found.refuted))
