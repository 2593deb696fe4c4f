"""What exploration concludes at its end of surfaces that no array could lie on.

Walls from the strokes that they stopped and from their rims, round holes from the rims at their ends: each a face
whose contacts nobody felt, and a warning that says so.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from exploration.planning.faces.consistency import drop_astride, drop_poor, flattened
from exploration.planning.faces.faceted import rounded
from exploration.planning.faces.simpler import simpler
from exploration.planning.faces.tips import tipped
from exploration.planning.faces.uprighted import uprighted
from exploration.planning.inferring.adding import add, add_own, change, home_of, once
from exploration.planning.inferring.broken_edges import broken_edges
from exploration.planning.inferring.dead_ends import dead_end
from exploration.planning.inferring.dividers import dividers
from exploration.planning.inferring.explained_rims import unexplained
from exploration.planning.inferring.fillets import FILLET, fillets
from exploration.planning.inferring.grooves import Groove, grooves
from exploration.planning.inferring.hole_walls import add_holes, add_left_holes
from exploration.planning.inferring.inferred_walls import inferred_walls, standing, stops_of
from exploration.planning.inferring.keyways import keyways
from exploration.planning.inferring.lips import no_walls
from exploration.planning.inferring.outlines import outline_walls
from exploration.planning.inferring.parted_ends import parted_ends
from exploration.planning.inferring.plate_walls import along_it, denies, freeform, plate_walls
from exploration.planning.inferring.plates import plates
from exploration.planning.inferring.rim_walls import rim_walls
from exploration.planning.inferring.risers import risers
from exploration.planning.inferring.round_walls import round_walls
from exploration.planning.inferring.rounded_corners import rounded_corners
from exploration.planning.inferring.rounded_edges import rounded_edges
from exploration.planning.inferring.slot_ends import as_seen, bounded, flat_ends
from exploration.planning.inferring.slots import Slot, slots
from exploration.planning.inferring.sockets import sockets
from exploration.planning.inferring.strip_rims import strip_rims
from exploration.planning.inferring.thin_walls import thin_walls
from exploration.planning.inferring.turned_ends import felt_ends, turned_ends
from exploration.planning.inferring.upright_walls import upright_walls
from exploration.planning.known.mosaic import Mosaic
from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.local_frontier import LocalFrontier
from exploration.planning.open.round_rims import RoundRim
from exploration.planning.touching.findings import Findings, SeenRim
from exploration.planning.touching.study import Wall
from primitives.arrays import Floats
from primitives.between_flats import between_flats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.plate import Plate
from primitives.rounded_ends import rounded_ends
from primitives.shapes import Plane

_BY_STOPS = "a face that no pad could lie on is inferred from strokes it stopped"
_BY_RIMS = "a face that no pad could lie on is inferred from its rims on two others"
_BY_RIM = "a face that no pad could lie on is inferred from its rim on another, upright on it"
_BY_TURN = "a face that no pad could lie on is inferred from its rim on a turned one, upright on its axis"
_BY_LAST = "the flat end of a turned face that no pad could lie on is inferred from where that was felt last"
_BY_GAP = (
    "an end of a turned face is inferred between where that was felt last and where an array went past it"
)
_BY_STEP = "a wall between a floor and the face above it is inferred from where the two end"
_BY_GAPS = "a wall of a slot that no pad could lie on is inferred from where the faces at its ends are not"
_BY_OUTSIDE = (
    "the inner side of a thin wall is inferred from the floor before it and the outer side behind it"
)
_BY_FLOOR = "a side of what stands on a floor is inferred from a stroke it stopped and the floor behind it"
_BY_OUTLINE = "an edge of a plate that no pad could lie on is inferred from where its sides end"
_BY_SIDES = "a side of a socket that no pad could lie on is inferred from edges seen round its mouth"
_BY_CORNER = "a rounded corner of a plate is inferred from where both its sides end between two walls"
_BY_ROUNDING = "a rounded edge is inferred from where contact with the walls on both sides ends"
_BY_CIRCLE = "a round wall that no pad could lie on is inferred from the circle that the face over it ends at"
_BY_BAND = (
    "a groove round a cylinder is inferred from where its wall is not; it is taken for half as deep as wide"
)
_BY_BOTTOM = (
    "a groove round a cylinder is inferred from where its wall is not and what was felt of its bottom"
)
_ALONG = 0.5  # most cosine between a rim and the way that the face behind it looks
_WALLS = 4.0  # [mm] round an opening, within which its walls are
_DEEP = 40.0  # [mm] behind its rim, likewise


def conclude(
    found: Findings,
    walls: Callable[[], Sequence[Wall]],
    frontier: Callable[[], LocalFrontier],
    mosaic: Mosaic,
    table: float | None = None,
) -> None:
    """Add what is inferred; `walls` are what stopped strokes where no face is known at that moment.

    The `mosaic` is what the pad's images showed; the object may lie on a `table` of that height [mm].
    """
    sound = uprighted(drop_poor(flattened(simpler(rounded_ends(between_flats(found.graph))))))
    found.graph, taken = rounded(drop_astride(tipped(sound)))
    found.rename(taken)
    inside = np.concatenate([np.empty((0, 3)), *found.inside])
    found.wall_rims = [*found.wall_rims, *strip_rims(found.strip_ends, frontier().known)]
    edges = _broken_for_now(found, mosaic)  # before walls: where a face ends at a rounding, none stands
    add_holes(found, frontier, inside, mosaic)  # before walls: a round hole stops strokes, too
    _add_walls(found, walls, frontier, inside)
    for groove in grooves(frontier().known, found.graph.faces, mosaic):  # before ends: its rims are none
        _add_groove(found, groove)
    _add_ends(found, frontier, inside)
    found.graph = uprighted(found.graph)  # again: a flat end may be inferred by now
    for keyway in keyways(frontier().known, found.graph.faces, mosaic):
        for lot, kind in keyway.walls():
            add_own(found, lot, keyway.told, kind)
    through = slots(known := frontier().known)
    looked, beside = _open_rims(found, known, through)
    for lot in sockets([*looked, *beside], found.graph.faces):
        add(found, lot, _BY_SIDES)
    looked, beside = _open_rims(found, known, through)
    for lot in rounded_edges([*looked, *beside], found.graph.faces):
        add(found, lot, _BY_ROUNDING, "cylinder")
    looked, beside = _open_rims(found, known, through)
    for lot in upright_walls(looked, found.graph.faces, beside):
        add(found, lot, _BY_RIM)
    add_left_holes(found, frontier, inside, mosaic)
    seen = [as_seen(slot, mosaic) for slot in slots(frontier().known)]
    for slot in seen:
        gone = flat_ends(slot, found.graph.faces, mosaic)
        found.graph = replace(found.graph, faces=tuple(f for f in found.graph.faces if f.id not in gone))
        _add_slot(found, slot)
    for riser in risers(frontier().known, stops_of(walls(), found.graph.faces)):
        add(found, riser.contacts, _BY_STEP, riser.kind)
    stopped = stops_of(walls(), found.graph.faces)
    for lot in once(thin_walls(frontier().known, stopped)):
        add(found, lot, _BY_OUTSIDE)
    for lot in once(dividers(frontier().known, stopped)):
        add(found, lot, _BY_FLOOR)
    now = frontier()
    found.plates = plates(now.known, mosaic, table)
    _add_outlines(found, outline_walls(now.known, now.ends(), found.graph.faces))
    for lot, flat in rounded_corners(now.known, found.graph.faces):
        if isinstance(add(found, lot, _BY_CORNER, "cylinder"), Fit):
            found.graph = replace(found.graph, faces=tuple(f for f in found.graph.faces if f.id not in flat))
    found.graph = replace(found.graph, faces=tuple(f for f in found.graph.faces if f.id not in edges))
    add_broken_edges(found, mosaic)  # again: there are walls by now that edges are between
    for lot, kind in fillets(found.graph.faces, mosaic):
        add_own(found, lot, FILLET, kind)
    for slot in seen:  # last: whatever told of a wall, none goes on past round ends
        found.graph = replace(found.graph, faces=bounded(found.graph.faces, slot))


def tell_openings(found: Findings) -> None:
    """Warn of openings whose depth nobody knows; on a bulge the skin sees such, and feels what is there."""
    contacts = Contacts.concatenate([face.contacts for face in found.graph.faces])
    felt = contacts.points[contacts.touch != NOT_FELT]
    found.warnings.extend(rim.told() for rim in found.openings if not rim.felt_over(felt))
    found.warnings.extend(rim.told_odd() for rim in _odd(found) if not rim.felt_over(felt))


def _add_groove(found: Findings, groove: Groove) -> None:
    """Add it, and leave to the other faces what is theirs."""
    others = found.graph.faces
    if add_own(found, groove.contacts, _BY_BOTTOM if groove.felt else _BY_BAND, "torus"):
        own = found.graph.faces[-1]
        found.graph = replace(found.graph, faces=(*groove.stands_beside(others), own))


def _add_outlines(found: Findings, last_felt: Sequence[Contacts]) -> None:
    """Walls of plates, as both sides were seen to end or where they were felt last.

    None of a plate whose outline they would leave unexplained for the most part.
    """
    before, told, left = found.graph, len(found.warnings), list[Plate]()
    for _ in range(2):
        found.graph, found.warnings = before, found.warnings[:told]
        for plate in found.plates:
            for lot, kind in plate_walls(plate, found.graph.faces) if plate not in left else ():
                add(found, lot, _BY_OUTLINE, kind)
        for lot in last_felt:
            denied = any(denies(plate, lot.points) for plate in found.plates)
            if not denied and not any(along_it(plate, lot.points) for plate in left):
                add(found, lot, _BY_OUTLINE)
        left = [plate for plate in found.plates if freeform(plate, found.graph.faces)]
        if not left:
            break


def _odd(found: Findings) -> list[RoundRim]:
    """Openings that are not round, each once, and none that is told of or whose walls are known by now."""
    kept: list[RoundRim] = []
    for rim in found.odd:
        others = (*found.rims, *found.openings, *kept)
        told = any(float(np.linalg.norm(rim.center - other.center)) < rim.radius for other in others)
        if not told and not _walled(rim, found.graph.faces):
            kept.append(rim)
    return kept


def _walled(rim: RoundRim, faces: Sequence[Face]) -> bool:
    """Whether walls of an opening are known by now: beside it, behind its rim, and looking to its axis."""
    for face in faces:
        out = face.contacts.points - rim.center
        deep, normals = -(out @ rim.axis), face.contacts.normals
        flat = out + np.outer(deep, rim.axis)
        near = (np.linalg.norm(flat, axis=1) < rim.radius + _WALLS) & (deep > 0.0) & (deep < _DEEP)
        upright = np.abs(normals @ rim.axis) < _ALONG
        if (near & upright & ((normals * flat).sum(axis=1) < 0.0)).any():
            return True
    return False


def add_broken_edges(found: Findings, mosaic: Mosaic) -> None:
    """Chamfers and roundings of the edges between known faces."""
    for edge in broken_edges(found.graph.faces, mosaic):
        add_own(found, edge.contacts, edge.told, edge.shape)


def _broken_for_now(found: Findings, mosaic: Mosaic) -> set[int]:
    """Add the chamfers and roundings between faces that were felt, and tell nobody; their ids."""
    before, told = {face.id for face in found.graph.faces}, len(found.warnings)
    add_broken_edges(found, mosaic)
    del found.warnings[told:]
    return {face.id for face in found.graph.faces} - before


def _open_rims(
    found: Findings, known: Sequence[KnownFace], through: Sequence[Slot]
) -> tuple[list[SeenRim], list[SeenRim]]:
    """The rims that were looked at, and those only seen beside others, that nothing explains by now."""
    looked, beside = (
        [
            (rim, own)
            for rim, own in unexplained(rims, found.graph.faces)
            if not dead_end(rim, own, known)
            and not any(slot.rounds(rim.point, rim.outward) for slot in through)
        ]
        for rims in (found.wall_rims, found.glimpsed)
    )
    return looked, beside


def _add_walls(
    found: Findings,
    walls: Callable[[], Sequence[Wall]],
    frontier: Callable[[], LocalFrontier],
    inside: Floats,
) -> None:
    """Walls that several things agree on: edges of one circle, strokes that were stopped, rims on two faces."""
    seen = unexplained([*found.wall_rims, *found.glimpsed], found.graph.faces)
    for lot in round_walls(seen, (now := frontier()).known, now.ends(), inside):
        add(found, lot, _BY_CIRCLE, "cylinder")
    rims = [rim for rim, _ in unexplained(found.wall_rims, found.graph.faces)]
    for lot in inferred_walls(walls(), found.graph.faces, rims):
        if (left := standing(lot, inside)) is not None:
            add(found, left, _BY_STOPS)
    seen = unexplained([*found.wall_rims, *found.glimpsed], found.graph.faces)
    if lots := rim_walls(seen, found.graph.faces):
        placed = {face.id: face for face in frontier().placed()}
        change(found, lambda face: placed.get(face.id, face))
    for lot in lots:
        add(found, lot, _BY_RIMS)
        gone = no_walls(lot, found.graph.faces)
        found.graph = replace(found.graph, faces=tuple(f for f in found.graph.faces if f.id not in gone))


def _add_ends(found: Findings, frontier: Callable[[], LocalFrontier], inside: Floats) -> None:
    """Flat ends of turned faces."""
    for lot in turned_ends(unexplained(found.wall_rims, found.graph.faces), found.graph.faces):
        add(found, lot, _BY_TURN)
    for lot in felt_ends((now := frontier()).known, now.ends()):
        if home_of(found.graph.faces, lot, "plane") is None:
            add(found, lot, _BY_LAST)
    for lot in parted_ends(found.graph.faces, inside):
        if home_of(found.graph.faces, lot, "plane") is None:
            add(found, lot, _BY_GAP)


def _add_slot(found: Findings, slot: Slot) -> None:
    """Its sides first: where a rim has told where one of them is, its ends are as wide as that leaves."""
    change(found, slot.off)
    walls = [add(found, lot, _BY_GAPS) for lot in slot.sides()]
    planes = [wall.shape for wall in walls if wall is not None and isinstance(wall.shape, Plane)]
    for lot in slot.between(planes).ends() if len(planes) == 2 else ():
        add(found, lot, _BY_GAPS, "cylinder")
