"""Plates: two flat faces that look away from each other, and where both are, or neither is.

What is missing of both goes right through, whatever its outline: notches, the gaps between teeth, sockets, holes
of any shape.  What both have is solid.  Where the one is and the other is not nothing is said.

Two that look one way make a step: beside the lower one, and over it, nothing is where the upper one is missing,
as in a pocket or round a boss of any outline (our derivation; all this is likely and not measured, so walls that
come of it are marked as inferred).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, permutations

import numpy as np
from scipy.ndimage import binary_fill_holes, distance_transform_edt, label, zoom

from exploration.planning.known.mosaic import Lattice, Mosaic, Picture
from exploration.planning.open.known_face import KnownFace
from primitives.arrays import Bools, Floats, Ints, frozen
from primitives.outlines import simplified, traced
from primitives.plate import Plate
from primitives.pose import frame_along, pose
from primitives.soft_outlines import sharpened


@dataclass(frozen=True)
class PlatesConfig:
    """What is a plate, and how its outlines are drawn."""

    opposed: float = 0.9998  # least cosine of a side's normal with the other's, reversed but in a step
    thick: tuple[float, float] = (0.3, 250.0)  # [mm]
    step: tuple[float, float] = (1.0, 45.0)  # [mm] from a floor to the face over it
    blind: float = 45.0  # [mm] of thickness, from which holes in both sides may be two blind ones
    cells: int = 12  # felt places of either side, at least
    margin: float = 12.0  # [mm] round both, of the pictures
    finer: int = 2  # times as fine as the pictures, of the outlines
    straight: float = 0.4  # [mm] from a straight line, up to which an outline is straight
    beyond: float = 4.0  # [mm] past what was seen to be missing, that is missing too where nobody looked
    past: tuple[float, float] = (0.5, 12.0)  # [mm] of what was felt past a side, and may go on through it,
    back: float = 0.5  # unless it looks back at it, from such a cosine,
    beside: float = 3.0  # [mm] round which nothing is missing where nobody looked
    touched: float = 1.5  # [mm] of a touched place, where nothing is missing unless both sides were seen
    leans: tuple[float, float] = (0.15, 0.97)  # cosine of a way out of a slope with that of a step
    slope: float = 4.0  # [mm] from a felt place of it, seen from above, to where it comes down to the floor
    foot: float = 5.0  # [mm] from where a floor was seen to where a wall may stand on it


def plates(
    known: Sequence[KnownFace],
    mosaic: Mosaic,
    table: float | None = None,
    config: PlatesConfig = PlatesConfig(),
) -> list[Plate]:
    """Of all pairs of known faces, opposed or alike; and of each that looks up, down to a `table`.

    The table is told by its height [mm].  Of the face that lies on it nothing was seen: what is missing of the one
    above is missing down to it, unless that is all round it, as of a pocket.
    """
    flat = [own for own in known if own.fit.kind == "plane" and len(own.cells) >= config.cells]
    found: list[Plate] = []
    for one, other in combinations(flat, 2):
        up = _outward(one)
        thick = float((one.fit.shape.anchor - other.fit.shape.anchor) @ up)
        if float(up @ _outward(other)) < -config.opposed and config.thick[0] < thick < config.thick[1]:
            found.append(_plate((one, other), thick, known, mosaic, config))
    for own in flat:
        thick = -np.inf if table is None else float(own.fit.shape.anchor[2]) - table
        if _outward(own)[2] > config.opposed and config.thick[0] < thick < config.thick[1]:
            found.append(_plate((own,), thick, known, mosaic, config))
    for group in _alike(flat, config):
        found.extend(_steps(group, known, mosaic, config))
    return [plate for plate in found if plate.there and (plate.missing or not plate.step)]


def _outward(own: KnownFace) -> Floats:
    return own.side * own.fit.shape.direction


def _plate(
    sides: Sequence[KnownFace],
    thick: float,
    faces: Sequence[KnownFace],
    mosaic: Mosaic,
    config: PlatesConfig,
) -> Plate:
    """Of its upper side and, where there is one, its lower."""
    up = _outward(sides[0])
    turn = frame_along(up)
    cells = np.concatenate([own.cells for own in sides])
    lattice = Lattice.over(cells, turn[:, :2], mosaic.config.step, config.margin)
    seen = [mosaic.picture(own.fit.shape.anchor, _outward(own), lattice) for own in sides]
    share, known = np.array([own.share for own in seen]), np.all([own.known for own in seen], axis=0)
    both, neither = np.where(known, share.min(axis=0), 0.0), 1.0 - share.max(axis=0)
    there = _rims(both, known, lattice.step, config)
    felt = distance_transform_edt(~_touched(cells, lattice)) * lattice.step < config.touched
    gone = _beyond(np.where(felt & ~known, 0.0, neither), known | felt, config.beyond / lattice.step)
    gone = np.minimum(gone, neither)  # of a place that one side alone shows, too
    through = _through(faces, sides[0], thick, lattice, config)
    gone[through & ~known] = 0.0
    if len(sides) == 1 or thick > config.blind:
        gone[binary_fill_holes(both > 0.5)] = 0.0
    origin = np.array([*lattice.origin, float(sides[0].fit.shape.anchor @ up) - 0.5 * thick])
    missing = _rims(gone, known & (gone == neither), lattice.step, config)
    return Plate(pose(turn, turn @ origin), thick, there, missing, len(sides) == 1)


def _through(
    known: Sequence[KnownFace], upper: KnownFace, thick: float, lattice: Lattice, config: PlatesConfig
) -> Bools:
    """Where something that was felt past either side of a plate may go on through it, as a boss beside it."""
    up, felt = _outward(upper), np.zeros(lattice.shape, dtype=bool)
    low, high = config.past
    for own in known:
        over = (own.cells - upper.fit.shape.anchor) @ up
        past = np.maximum(over, -over - thick)
        back = -np.sign(over) * own.side * (own.fit.shape.normals(own.cells) @ up)
        felt |= _touched(own.cells[(past > low) & (past < high) & (back < config.back)], lattice)
    if not felt.any():
        return felt
    return np.asarray(distance_transform_edt(~felt) * lattice.step < config.beside)


def _touched(cells: Floats, lattice: Lattice) -> Bools:
    """Where a lattice has one of (n, 3) touched places."""
    touched = np.zeros(lattice.shape, dtype=bool)
    at = np.round((cells @ lattice.along - lattice.origin) / lattice.step).astype(np.int64)
    at = at[((at >= 0) & (at < lattice.shape)).all(axis=1)]
    touched[at[:, 0], at[:, 1]] = True
    return touched


def _alike(flat: Sequence[KnownFace], config: PlatesConfig) -> list[list[KnownFace]]:
    """Faces that look one way, together."""
    groups: list[list[KnownFace]] = []
    for own in flat:
        for group in groups:
            if float(_outward(group[0]) @ _outward(own)) > config.opposed:
                group.append(own)
                break
        else:
            groups.append([own])
    return groups


def _steps(
    group: Sequence[KnownFace], known: Sequence[KnownFace], mosaic: Mosaic, config: PlatesConfig
) -> Iterator[Plate]:
    """Of each face of a group and each floor below it: all are seen on one lattice, each once."""
    if len(group) < 2:
        return
    up = _outward(group[0])
    turn = frame_along(up)
    cells = np.concatenate([own.cells for own in group])
    lattice = Lattice.over(cells, turn[:, :2], mosaic.config.step, config.margin)
    heights = [float(own.fit.shape.anchor @ up) for own in group]
    seen = [mosaic.picture(own.fit.shape.anchor, up, lattice) for own in group]
    rims: dict[int, tuple[Floats, ...]] = {}  # of each that is the upper one of a step
    for upper, lower in permutations(range(len(group)), 2):
        thick = heights[upper] - heights[lower]
        if config.step[0] < thick < config.step[1]:
            low, high = heights[lower] + config.step[0], heights[upper] - config.step[0]
            ledges = [own for own, height in zip(seen, heights, strict=True) if low < height < high]
            floors = [own for own, height in zip(seen, heights, strict=True) if height < high]
            gone = _over(seen[upper], seen[lower], ledges, lattice, config)
            gone = np.maximum(gone, _pockets(seen[upper], seen[lower], floors, lattice, config))
            slope = _touched(_feet(known, up, (heights[lower], high), config), lattice)
            if slope.any():
                gone[distance_transform_edt(~slope) * lattice.step < config.slope] = 0.0
            origin = np.array([*lattice.origin, heights[upper] - 0.5 * thick])
            top = seen[upper]
            if upper not in rims:
                rims[upper] = _rims(np.where(top.known, top.share, 0.0), top.known, lattice.step, config)
            missing = _rims(gone, top.known & (gone == 1.0 - top.share), lattice.step, config)
            yield Plate(pose(turn, turn @ origin), thick, rims[upper], missing, step=True)


def _feet(
    known: Sequence[KnownFace], up: Floats, levels: tuple[float, float], config: PlatesConfig
) -> Floats:
    """(n, 3) where slopes that were felt between two levels come down to the lower, as a cone's foot does."""
    feet = [np.empty((0, 3))]
    for own in known:
        over, normals = own.cells @ up - levels[0], own.side * own.fit.shape.normals(own.cells)
        cosine = normals @ up
        leans = (cosine > config.leans[0]) & (cosine < config.leans[1])
        rows = np.flatnonzero(leans & (over > 0.0) & (over < levels[1] - levels[0]))
        out = normals[rows] - np.outer(cosine[rows], up)
        run = over[rows] * cosine[rows] / (1.0 - cosine[rows] ** 2)
        near = run * np.linalg.norm(out, axis=1) < config.slope
        feet.append((own.cells[rows] + run[:, None] * out)[near])
    return np.concatenate(feet)


def _over(
    top: Picture, floor: Picture, ledges: Sequence[Picture], lattice: Lattice, config: PlatesConfig
) -> Floats:
    """Share of what is missing over and beside a floor up to the face above it, but for ledges between them."""
    over = np.where(floor.there & ~top.there, floor.share, 0.0)
    gone = np.where(top.known, 1.0 - top.share, over)
    if not floor.there.any():
        return np.zeros(lattice.shape)
    away, nearest = distance_transform_edt(~floor.there, return_indices=True)
    gone[(away * lattice.step > config.foot) | _behind(top, nearest.astype(np.int64))] = 0.0
    for ledge in ledges:
        gone = np.where(ledge.known, np.minimum(gone, 1.0 - ledge.share), gone)
    return np.asarray(gone, dtype=np.float64)


def _pockets(
    top: Picture, floor: Picture, floors: Sequence[Picture], lattice: Lattice, config: PlatesConfig
) -> Floats:
    """Share of what is missing of openings with the face all round them, in which this floor alone was seen.

    A floor that was felt in a part of a pocket is taken for that of all of it.
    """
    gone = _beyond(np.where(top.known, 1.0 - top.share, 0.0), top.known, config.beyond / lattice.step)
    lots, _ = label(~top.there)
    border = np.unique(np.concatenate([lots[0], lots[-1], lots[:, 0], lots[:, -1]]))
    low = [lot for lot in np.unique(lots[floor.there & ~top.there]) if lot not in border]
    others = [other for other in floors if other is not floor]
    own = [lot for lot in low if not any((other.there & (lots == lot)).any() for other in others)]
    return np.where(np.isin(lots, own), gone, 0.0)


def _behind(top: Picture, nearest: Ints) -> Bools:
    """(n, m) whether the upper face lies between a place and (2, n, m) that of the floor nearest to it.

    So is a bore behind the wall of a tube, whose foot the floor is.
    """
    here = np.indices(top.share.shape)
    ways = [np.round(here + part * (nearest - here)).astype(np.int64) for part in (0.25, 0.5, 0.75)]
    return np.asarray(np.any([top.there[way[0], way[1]] for way in ways], axis=0), dtype=bool)


def _beyond(share: Floats, known: Bools, reach: float) -> Floats:
    """A share, where it is not known that of the nearest place where it is, within so many places."""
    away, nearest = distance_transform_edt(~known, return_indices=True)
    return np.where(away <= reach, share[tuple(nearest)], 0.0)


def _rims(share: Floats, told: Bools, step: float, config: PlatesConfig) -> tuple[Floats, ...]:
    """Closed rims [mm from the lattice's origin] of what looks like a share, where the pictures have `told` it."""
    shape = share.shape[0], share.shape[1]
    return _rims_of(share.astype(np.float32).tobytes(), told.tobytes(), shape, step, config)


@lru_cache(maxsize=32)
def _rims_of(
    share: bytes, told: bytes, shape: tuple[int, int], step: float, config: PlatesConfig
) -> tuple[Floats, ...]:
    """The same, once for each picture: drafts of the object see most of them again."""
    seen = np.frombuffer(share, np.float32).reshape(shape).astype(np.float64)
    fine = zoom(seen, config.finer, order=1, grid_mode=True, mode="nearest")
    half = [
        simplified(((loop - 0.5 * config.finer) / config.finer)[:, ::-1] * step, config.straight)[:-1]
        for loop in traced(fine > 0.5)
    ]
    return tuple(map(frozen, sharpened(seen, np.frombuffer(told, dtype=bool).reshape(shape), half, step)))
