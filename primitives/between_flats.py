"""Rounded edges between two flat faces, from contacts that lie on neither and look between both.

With a and b how deep such a contact is behind the two planes, across each other, it lies on the rounding of radius

    r = a + b + sqrt(2 a b),

and looks along (r - a) n1 + (r - b) n2 (our derivation).  So each contact tells the radius, and those of one edge
must agree.  A pad that rolls over an edge is on it for few contacts, and what they were taken for, a cylinder
through the roundings of two edges or a bevel, is none once they are known to be of one.  An edge that nobody was
on, and toward which both faces end as early, is taken to be rounded as the others are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit, NoFit, refit
from primitives.flat_edges import Flat, Stretch, flats
from primitives.patch_graph import Face, PatchGraph
from primitives.shapes import Cylinder, Plane


@dataclass(frozen=True)
class BetweenFlatsConfig:
    """Which contacts are of a rounding."""

    square: float = 0.1  # most cosine between the normals of two faces
    sure: int = 20  # contacts of either,
    broad: float = 1.5  # [mm] and standard deviation of them the narrower way: a bevel is felt along a line
    near: float = 22.0  # [mm] of the edge, that both were felt
    past: float = 0.1  # share of a face's contacts, that may lie past an edge where it ends
    ends: float = -6.0  # [mm] left out at either end of where both were felt: less, for they end early
    deep: tuple[float, float] = (-0.4, 10.0)  # [mm] behind either face
    between: float = 0.15  # least cosine to the normals of both faces,
    along: float = 0.25  # and most to the edge
    radii: tuple[float, float] = (1.5, 14.0)  # [mm]
    off: tuple[float, float] = (0.3, 0.1)  # [mm], and of the radius, that a contact tells another,
    sigmas: float = 5.0  # or of contacts, where that is more
    leans: float = 0.3  # [rad] from where it should look, at most
    few: int = 6  # contacts of an edge, at least,
    share: float = 0.7  # and of all that lie there
    turns: float = 0.25  # [rad] between the first and last of them round the edge, so that it is no bevel,
    bevel: float = 0.5  # and no nearer to a straight one than so many times as they are to the rounding,
    follows: float = 0.5  # nor do they turn by less than so much of what their places do
    alike: float = 0.12  # of its radius, to those of other edges, so that it need not turn
    early: float = 0.6  # of that radius before an edge, that both faces end at least where nobody was on it
    amiss: float = 0.8  # [mm] off such a rounding, from which contacts contradict it
    gone: float = 0.5  # share of a face's contacts, from which it was none
    crumb: int = 100  # contacts, below which what lies at rounded edges alone is no face
    laid: bool = True  # whether inferred contacts say how far a rounding goes,
    rows: int = 12  # of them along an edge,
    across: tuple[float, ...] = (0.06, 0.28, 0.5, 0.72, 0.94)  # of the way from one face to the other
    sigma: float = 0.1  # [mm] of theirs
    normal_sigma: float = 0.05  # [rad]


@dataclass(frozen=True)
class _Edge:
    """Contacts of one edge, as parts of what lies between flat faces."""

    one: Flat
    other: Flat
    stretch: Stretch
    ends: float  # [mm] before the edge, that the faces were felt at most
    used: Bools  # (n,)
    radius: float  # [mm]; nan where no contact tells it
    turn: float  # [rad]


def between_flats(graph: PatchGraph, config: BetweenFlatsConfig = BetweenFlatsConfig()) -> PatchGraph:
    """The graph with a cylinder for each rounded edge, and without what its contacts were taken for."""
    known = [flat for flat in flats(graph.faces) if len(flat.felt) >= config.sure and is_broad(flat, config)]
    whose, rest = _rest(graph.faces, known)
    if len(rest) < config.few:
        return graph
    found = [e for pair in combinations(known, 2) if (e := _edge(*pair, rest, config)) is not None]
    turned = [edge.radius for edge in found if edge.turn > config.turns]
    if not turned:
        return graph
    usual = float(np.median(turned))
    edges = [e for e in found if any(abs(e.radius - r) < config.alike * r for r in turned)]
    felt = Contacts.concatenate([face.contacts for face in graph.faces])
    felt = felt.select((felt.touch != NOT_FELT) & felt.has_normal)
    early = (e for e in found if np.isnan(e.radius) and e.ends > config.early * usual)
    unfelt = (replace(edge, radius=usual) for edge in early)
    edges += [edge for edge in unfelt if not _contradicted(edge, felt, config)]
    used = np.any([edge.used for edge in edges], axis=0)
    made = [new for edge in edges if (new := _made(edge, rest, config)) is not None]
    return regrouped(graph, made, used, whose, config, lambda face: _crumb(face, edges, config))


def _contradicted(edge: _Edge, felt: Contacts, config: BetweenFlatsConfig) -> bool:
    """Whether something was felt where a rounding leaves nothing, or looks between its faces and is not on it."""
    one, other, radius = edge.one, edge.other, edge.radius
    a, b = one.offset - felt.points @ one.normal, other.offset - felt.points @ other.normal
    there = (
        edge.stretch.beside(felt.points) & (np.minimum(a, b) > config.deep[0]) & (np.maximum(a, b) < radius)
    )
    past = np.hypot(radius - a, radius - b) - radius
    cosines = felt.normals @ np.column_stack([one.normal, other.normal])
    amiss = (past > config.amiss) | ((cosines.min(axis=1) > config.between) & (past < -config.amiss))
    return int((there & amiss).sum()) >= config.few


def regrouped(
    graph: PatchGraph,
    made: Sequence[Face],
    used: Bools,
    whose: Floats,
    config: BetweenFlatsConfig,
    crumb: Callable[[Face], bool] = lambda _: False,
) -> PatchGraph:
    """The graph with new faces, which `used` (n,) contacts `whose` (n,) faces' they were before.

    A face that most of them were taken from, and each `crumb`, is none; what is left of it names no face.
    """
    kept, lost = list[Face](), [Contacts.of([])]
    for face in graph.faces:
        mine = used[whose == face.id]
        mine = mine if len(mine) else np.zeros(len(face.contacts), dtype=bool)
        none = (mine.any() and mine.mean() > config.gone) or crumb(face)
        lost += [face.contacts.select(~mine)] if none else []
        kept += [] if none else [face.only(~mine) if mine.any() else face]
    rest = Face(-1, NoFit("contacts beside roundings name no face"), Contacts.concatenate(lost))
    new = [face for face in (*made, rest) if len(face.contacts)]
    whole = [*kept, *(replace(face, id=graph.next_id + k) for k, face in enumerate(new))]
    ids = {face.id for face in whole}
    lines = tuple(e for e in graph.edges if all(number is None or number in ids for number in e.faces))
    return replace(graph, faces=tuple(whole), edges=lines)


def is_broad(flat: Flat, config: BetweenFlatsConfig = BetweenFlatsConfig()) -> bool:
    """Whether a flat face was felt over more than a line, as no bevel is."""
    spread = np.linalg.svd(flat.felt - flat.felt.mean(axis=0), compute_uv=False)
    return bool(spread[1] > config.broad * np.sqrt(len(flat.felt)))


def _rest(faces: Sequence[Face], known: Sequence[Flat]) -> tuple[Floats, Contacts]:
    """(n,) the face of each contact that was felt, with a normal, on none of the known flat faces; and those."""
    lots = [np.empty(0)], [Contacts.of([])]
    for face in faces:
        shape = face.fit.shape if isinstance(face.fit, Fit) else None
        if isinstance(shape, Plane) and any(abs(float(shape.normal @ flat.normal)) > 0.999 for flat in known):
            continue
        lots[0].append(np.full(len(face.contacts), face.id))
        lots[1].append(face.contacts)
    whose, rest = np.concatenate(lots[0]), Contacts.concatenate(lots[1])
    return whose, rest


def _edge(one: Flat, other: Flat, rest: Contacts, config: BetweenFlatsConfig) -> _Edge | None:
    """The edge at which two flat faces would meet, and what contacts tell of its rounding."""
    if abs(float(one.normal @ other.normal)) > config.square:
        return None
    near = []
    for own, beside in ((one, other), (other, one)):
        inside = beside.offset - own.felt @ beside.normal
        if np.mean(inside < config.deep[0]) > config.past:
            return None  # going on past it
        near.append(own.felt[inside < config.near])
    stretch = Stretch.of(one, other, near, config.ends)
    if stretch is None or stretch.length <= 0.0:
        return None
    a, b = one.offset - rest.points @ one.normal, other.offset - rest.points @ other.normal
    low, high = config.deep
    normals = np.nan_to_num(rest.normals)
    there = (
        (rest.touch != NOT_FELT)
        & stretch.beside(rest.points)
        & (np.minimum(a, b) > low)
        & (np.maximum(a, b) < high)
    )
    there &= (normals @ one.normal > config.between) & (normals @ other.normal > config.between)
    there &= np.abs(normals @ stretch.along) < config.along
    bare = [
        float((beside.offset - own @ beside.normal)[stretch.beside(own)].min(initial=np.inf))
        for own, beside in zip(near, (other, one), strict=True)
    ]
    unfelt = _Edge(one, other, stretch, min(bare), np.zeros(len(rest), dtype=bool), np.nan, 0.0)
    if there.sum() < config.few:
        return unfelt if not there.any() else None
    told = told_radius((a, b), (one.normal, other.normal), there, rest, config)
    return None if told is None else replace(unfelt, used=told[1], radius=told[0], turn=told[2])


def told_radius(
    deep: tuple[Floats, Floats],
    out: tuple[Floats, Floats],
    there: Bools,
    contacts: Contacts,
    config: BetweenFlatsConfig,
) -> tuple[float, Bools, float] | None:
    """Radius [mm] of the rounding that contacts `there` (n,) tell, which of them do, and over what turn [rad].

    Each is `deep` (n,) [mm] behind two faces that look `out` (3,) or (n, 3), across each other.
    """
    a, b = (np.maximum(each, 0.0) for each in deep)
    radii = a + b + np.sqrt(2.0 * a * b)
    radius = float(np.median(radii[there]))
    if not config.radii[0] < radius < config.radii[1]:
        return None
    looks = (radius - a)[:, None] * out[0] + (radius - b)[:, None] * out[1]
    looks = looks / np.maximum(np.linalg.norm(looks, axis=1), 1e-9)[:, None]
    off = max(config.off[0], config.off[1] * radius, config.sigmas * float(np.median(contacts.sigma[there])))
    used = there & (np.abs(radii - radius) < off)
    facing = (looks * np.nan_to_num(contacts.normals)).sum(axis=1)
    used &= np.arccos(np.clip(facing, -1.0, 1.0)) < config.leans
    if used.sum() < max(config.few, config.share * there.sum()):
        return None
    turns = np.arctan2(radius - b[used], radius - a[used])
    over = float(np.ptp(turns))
    across = ((contacts.normals * way).sum(axis=1)[used] for way in (out[1], out[0]))
    follows = float(np.polyfit(turns, np.arctan2(*across), 1)[0]) if over > config.turns else 1.0
    if _bevel(a[used], b[used], radius) < config.bevel or follows < config.follows:
        return None
    return float(np.median(radii[used])), used, over


def _bevel(a: Floats, b: Floats, radius: float) -> float:
    """How far contacts (n,) deep behind two faces are off a straight bevel, over how far off a rounding."""
    deep = np.column_stack([a - a.mean(), b - b.mean()])
    straight = float(np.linalg.svd(deep, compute_uv=False)[-1])
    return straight / max(float(np.std(np.hypot(radius - a, radius - b))) * float(np.sqrt(len(a))), 1e-9)


def _made(edge: _Edge, rest: Contacts, config: BetweenFlatsConfig) -> Face | None:
    """The face: what was felt of it, and what nobody felt between the two beside it."""
    lot = rest.select(edge.used)
    if config.laid:
        lot = Contacts.concatenate([lot, Contacts.of(*_laid(edge, config), touch=NOT_FELT)])
    middle = edge.stretch.corner - edge.radius * (edge.one.normal + edge.other.normal)
    made = refit(Cylinder(middle, edge.stretch.along, edge.radius), True, lot)
    return Face(-1, made, lot) if isinstance(made, Fit) else None


def _laid(edge: _Edge, config: BetweenFlatsConfig) -> tuple[Floats, Floats, float, float]:
    turn = 0.5 * np.pi * np.array(config.across)[:, None]
    ways = np.cos(turn) * edge.one.normal + np.sin(turn) * edge.other.normal
    felt = replace(edge.stretch, low=edge.stretch.low - config.ends, high=edge.stretch.high + config.ends)
    rows = (felt if felt.length > 0.0 else edge.stretch).rows(config.rows)
    middle = edge.stretch.corner - edge.radius * (edge.one.normal + edge.other.normal)
    points = ((middle + rows)[:, None] + edge.radius * ways).reshape(-1, 3)
    return points, np.tile(ways, (len(rows), 1)), config.sigma, config.normal_sigma


def _crumb(face: Face, edges: Sequence[_Edge], config: BetweenFlatsConfig) -> bool:
    """Whether the few contacts of a face all lie at a rounded edge, or where such edges meet."""
    if len(face.contacts) >= config.crumb or not isinstance(face.fit, Fit):
        return False
    points, at = face.contacts.points, np.zeros(len(face.contacts), dtype=bool)
    for edge in edges:
        past = 2.0 * edge.radius
        deep = [flat.offset - points @ flat.normal for flat in (edge.one, edge.other)]
        along = points @ edge.stretch.along
        beside = (along > edge.stretch.low - past) & (along < edge.stretch.high + past)
        at |= beside & (np.minimum(*deep) > config.deep[0]) & (np.maximum(*deep) < edge.radius)
    return bool(at.mean() > config.gone)
