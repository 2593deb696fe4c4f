"""Straight edges of a plate that no array has room to face, inferred from where both its sides end.

The places at which the two sides of a plate were felt last lie about its outline.  Where those of both lie along
one line, all looking out across it, and neither was felt past it, the plate ends at a wall there, upright between
the two.  The run of most places comes first, through pairs of places drawn at random (compare Fischler and Bolles
1981); one that bends is a piece of a round outline, and none (our derivation).  Single places are known to a taxel
only, a run of them better.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np
from scipy.spatial import KDTree

from exploration.planning.open.known_face import KnownFace
from primitives.arcs import circle_through
from primitives.arrays import Bools, Floats, Ints
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.pose import frame_along


@dataclass(frozen=True)
class OutlinesConfig:
    """What is a plate, and a straight piece of its outline."""

    opposed: float = 0.998  # least cosine between a side's normal and the reverse of the other's
    thick: tuple[float, float] = (0.3, 15.0)  # [mm]
    told: float = 2.5  # [mm] from a face that is known by now, of places that it explains
    facing: float = 0.3  # least cosine between the ways out there
    band: float = 1.6  # [mm] to either side of a line
    out: float = 0.5  # least cosine between a place's way out and the line's
    apart: tuple[float, float] = (4.0, 60.0)  # [mm] between two places that a line is laid through
    gap: float = 6.0  # [mm] between neighbors of one run
    longer: float = 10.0  # [mm] of a run, at least
    each: int = 4  # places of either side, at least
    upright: float = 0.02  # most cosine between such a wall's way and a side's
    snap: float = 0.15  # [rad] from a direction of the object, that is its own then
    bends: float = 0.45  # [mm] of a run's sagitta, at most
    past: tuple[float, float] = (1.5, 6.0)  # [mm] past it, where hardly anything was felt:
    felt: int = 2  # places at most
    ahead: float = 4.0  # [mm] past a single place, where nothing was felt
    clear: float = 2.0  # [mm] round there
    rounded: float = 0.8  # [mm] the same, up to where corners at its ends may be rounded
    middle: float = 0.6  # of such a run, that tells where it is
    steps: int = 4  # in which a circle takes in what is round
    many: int = 5  # ways that tangents of one circle look, from which they are pieces of it,
    tangent: float = 1.0  # [mm] from it at most
    trim: float = 2.0  # [mm] of its ends, beside which another side may begin
    tried: int = 400  # pairs of places for each run
    most: int = 16  # runs of one plate
    step: float = 3.0  # [mm] between the contacts of a wall
    rows: tuple[float, ...] = (0.2, 0.5, 0.8)  # of its height, where they are
    sigma: float = 0.3  # [mm]
    normal_sigma: float = 0.03  # [rad]


@dataclass(frozen=True)
class _Run:
    """Places of a flat outline along n . x = d, from one end to the other along t = (-n_y, n_x)."""

    normal: Floats  # (2,)
    offset: float  # [mm]
    low: float  # [mm]
    high: float  # [mm]

    @property
    def along(self) -> Floats:
        """(2,) its own direction."""
        return np.array([-self.normal[1], self.normal[0]])


def outline_walls(
    known: Sequence[KnownFace],
    ends: Sequence[tuple[Floats, Floats]],
    faces: Sequence[Face],
    config: OutlinesConfig = OutlinesConfig(),
) -> list[Contacts]:
    """Contacts of each straight wall between two sides of a plate; nobody felt it.

    `ends[k]` are (n, 3) places at which the `known` face k was felt last, with the ways out of it there; `faces`
    are all that are known by now, inferred ones as well.
    """
    found: list[Contacts] = []
    flat = [
        (own, *_left(own, *end, faces, config)) for own, end in zip(known, ends, strict=True) if _flat(own)
    ]
    for (one, at, out), (other, behind, back) in combinations(flat, 2):
        up = one.side * one.fit.shape.direction
        deep = float((one.fit.shape.anchor - other.fit.shape.anchor) @ up)
        against = float(other.side * other.fit.shape.direction @ up) < -config.opposed
        if not against or not config.thick[0] < deep < config.thick[1]:
            continue
        turn, side = frame_along(up), np.repeat([0, 1], [len(at), len(behind)])
        places, ways = (np.concatenate(lots) @ turn[:, :2] for lots in ((at, behind), (out, back)))
        cells = np.concatenate([one.cells, other.cells]) @ turn[:, :2]
        own = _directions(faces, up, config) @ turn[:, :2]
        level = float(one.fit.shape.anchor @ up)
        runs = list(_runs(places, ways, side, cells, own, config))
        if not _of_one_circle(runs, config):
            found += [_wall(run, turn, (level - deep, level), config) for run in runs]
    return found


def _flat(own: KnownFace) -> bool:
    return own.fit.kind == "plane" and len(own.cells) > 0


def _left(
    own: KnownFace, at: Floats, out: Floats, faces: Sequence[Face], config: OutlinesConfig
) -> tuple[Floats, Floats]:
    """Those of (n, 3) places and ways out of a face that no other explains."""
    told = np.zeros(len(at), dtype=bool)
    for face in faces:
        if isinstance(face.fit, Fit) and face.id != own.face.id:
            side = 1.0 if face.fit.convex else -1.0
            looks = side * (face.fit.shape.normals(at) * out).sum(axis=1) > config.facing
            told |= looks & (np.abs(face.fit.shape.signed_distance(at)) < config.told)
    return at[~told], out[~told]


def _directions(faces: Sequence[Face], up: Floats, config: OutlinesConfig) -> Floats:
    """(n, 3) ways across `up` that flat faces look, or run."""
    flat = [
        face.fit.shape.direction for face in faces if isinstance(face.fit, Fit) and face.fit.kind == "plane"
    ]
    ways = [way for way in flat if abs(float(way @ up)) < config.upright]
    both = [way for one in ways for way in (one, np.cross(up, one))]
    return np.array([sign * way for way in both for sign in (1.0, -1.0)]).reshape(-1, 3)


def _runs(
    places: Floats, ways: Floats, side: Ints, cells: Floats, own: Floats, config: OutlinesConfig
) -> Iterator[_Run]:
    """Straight runs of (n, 2) places with (n, 2) ways out, of either `side`, past which no (m, 2) cells are.

    They look one of the (k, 2) `own` ways of the object, or along or across those before, where that is as likely.
    """
    left, rng = _outermost(places, ways, cells, config), np.random.default_rng(0)
    for _ in range(config.most):
        members = _fullest(places, ways, side, left, rng, config)
        if members is None:
            return
        left &= ~members
        run, bends = _fitted(places[members], ways[members], own, config)
        if config.bends < bends < config.rounded:
            inner = _inner(run, places[members], ways[members], config)
            if len(inner[0]) >= 2 * config.each and config.middle * (run.high - run.low) > config.longer:
                run, bends = _fitted(*inner, own, config)
        if bends > config.bends:
            left &= ~_round(members, places, ways, config)
        elif _past(run, cells, config) <= config.felt:
            left &= ~_beside(run, places, ways, config)
            own = np.concatenate([own, np.outer([1.0, -1.0], run.normal), np.outer([1.0, -1.0], run.along)])
            yield run


def _outermost(places: Floats, ways: Floats, cells: Floats, config: OutlinesConfig) -> Bools:
    """(n,) which places nothing was felt past, of either side."""
    near = KDTree(cells).query(places + config.ahead * ways)[0]
    return np.asarray(near > config.clear)


def _fullest(
    places: Floats, ways: Floats, side: Ints, left: Bools, rng: np.random.Generator, config: OutlinesConfig
) -> Bools | None:
    """(n,) which places are of the fullest run among those left."""
    rows = np.flatnonzero(left)
    best, found = 0, None
    for _ in range(config.tried if len(rows) >= 2 * config.each else 0):
        i, j = rng.choice(rows, 2, replace=False)
        apart = places[j] - places[i]
        far = float(np.linalg.norm(apart))
        if not config.apart[0] < far < config.apart[1]:
            continue
        along = apart / far
        normal = np.array([along[1], -along[0]])
        normal = normal if normal @ ways[i] > 0.0 else -normal
        on = left & (np.abs((places - places[i]) @ normal) < config.band) & (ways @ normal > config.out)
        if not (on[i] and on[j]):
            continue
        run = _together(on, places @ along, i, config.gap)
        both = min(int((side[run] == k).sum()) for k in (0, 1))
        long = float(np.ptp(places[run] @ along)) > config.longer
        if long and int(run.sum()) > best and both >= config.each:
            best, found = int(run.sum()), run
    return found


def _together(on: Bools, along: Floats, i: int, gap: float) -> Bools:
    """(n,) which of the places `on` a line hang together with place i."""
    rows = np.flatnonzero(on)
    rows = rows[np.argsort(along[rows], kind="stable")]
    lot = np.concatenate([[0], np.cumsum(np.diff(along[rows]) > gap)])
    out = np.zeros(len(on), dtype=bool)
    out[rows[lot == lot[rows == i]]] = True
    return out


def _fitted(places: Floats, ways: Floats, own: Floats, config: OutlinesConfig) -> tuple[_Run, float]:
    """The line through (n, 2) places, and [mm] of how far it surely bends between its ends."""
    middle = places.mean(axis=0)
    normal = np.linalg.svd(places - middle)[2][1]
    normal = normal * np.sign(ways.mean(axis=0) @ normal)
    if len(own) and float((own @ normal).max()) > np.cos(config.snap):
        normal = own[int((own @ normal).argmax())]
    along = np.array([-normal[1], normal[0]])
    t = (places - middle) @ along
    off = (places - middle) @ normal
    bend = abs(float(np.polyfit(t, off, 2)[0])) * (0.5 * float(np.ptp(t))) ** 2
    unsure = 0.25 * float(off.std()) * np.sqrt(180.0 / len(off))  # of a parabola through places spread evenly
    low, high = float((places @ along).min()), float((places @ along).max())
    return _Run(normal, float(middle @ normal), low, high), bend - unsure


def _inner(run: _Run, places: Floats, ways: Floats, config: OutlinesConfig) -> tuple[Floats, Floats]:
    """Those of (n, 2) places and ways that are well inside a run, at whose ends a corner may be rounded."""
    along = places @ run.along
    middle, half = 0.5 * (run.low + run.high), 0.5 * config.middle * (run.high - run.low)
    inside = np.abs(along - middle) < half
    return places[inside], ways[inside]


def _of_one_circle(runs: Sequence[_Run], config: OutlinesConfig) -> bool:
    """Whether runs that look many ways are tangents of one circle: n . c + r = d for all of them."""
    apart: list[Floats] = []
    for run in runs:
        if all(float(run.normal @ other) < np.cos(config.snap) for other in apart):
            apart.append(run.normal)
    if len(apart) < config.many:
        return False
    rows = np.array([[*run.normal, 1.0] for run in runs])
    offsets = np.array([run.offset for run in runs])
    solved = np.linalg.lstsq(rows, offsets, rcond=None)[0]
    return bool(np.abs(rows @ solved - offsets).max() < config.tangent)


def _beside(run: _Run, places: Floats, ways: Floats, config: OutlinesConfig) -> Bools:
    """(n,) which places a run explains as well."""
    t, off = places @ run.along, np.abs(places @ run.normal - run.offset)
    within = (t > run.low - config.told) & (t < run.high + config.told)
    return np.asarray(within & (off < config.told) & (ways @ run.normal > config.facing))


def _round(bent: Bools, places: Floats, ways: Floats, config: OutlinesConfig) -> Bools:
    """(n,) which places are of the circle through the `bent` ones, of which it takes in more at each step."""
    for _ in range(config.steps):
        middle = places[bent].mean(axis=0)
        circle = circle_through(places[bent] - middle)
        if circle is None:
            break
        away = places - middle - circle[0]
        far = np.linalg.norm(away, axis=1)
        across = np.abs((away * ways).sum(axis=1)) > config.facing * far
        bent = bent | (across & (np.abs(far - circle[1]) < config.told))
    return bent


def _past(run: _Run, cells: Floats, config: OutlinesConfig) -> int:
    """How many of (m, 2) cells were felt straight past a run."""
    over, t = cells @ run.normal - run.offset, cells @ run.along
    beside = (t > run.low + config.trim) & (t < run.high - config.trim)
    return int((beside & (over > config.past[0]) & (over < config.past[1])).sum())


def _wall(run: _Run, turn: Floats, between: tuple[float, float], config: OutlinesConfig) -> Contacts:
    """Contacts of the wall along a run, between two levels [mm] along the third column of `turn`."""
    count = max(3, round((run.high - run.low) / config.step))
    t = np.linspace(run.low, run.high, count + 2)[1:-1]
    low, high = between
    levels = [low + row * (high - low) for row in config.rows]
    flat = run.offset * run.normal + np.outer(t, run.along)
    points = np.concatenate([np.column_stack([flat, np.full(count, level)]) for level in levels]) @ turn.T
    normals = np.broadcast_to(turn[:, :2] @ run.normal, points.shape)
    return Contacts.of(points, normals, config.sigma, config.normal_sigma, touch=NOT_FELT)
