"""What was felt where a body has nothing: boxes and bars that stand under such contacts.

A limb of which too little was felt to close it is no cell, and a body of cells leaves its contacts in the air.
Those that hang together span it: a box or a bar whose sides are known surfaces where one is there, and else where
contact ended.  A bar about the axis of what was felt to be round is as likely as one more known side makes it.  It
holds nothing that an array passed through (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exploration.planning.known.surface_map import clusters
from models.csg import Csg, Cube
from models.csg import Cylinder as Bar
from models.solid import Solid
from primitives.arrays import Floats
from primitives.pose import frame_along, pose
from primitives.shapes import Cylinder, Plane
from recognition.assembly.enclosing import enclosing_circle
from recognition.assembly.made import FLUSH, Body, Known, among, axis_beside, drawn, level_of, thinned
from recognition.assembly.piece import Piece

LIMB = "a limb that no faces close is added where contacts lie off all else"
_STEP = 0.25  # [mm] at which it is looked into a body
_COAXIAL = 0.01  # [mm] between axes that are one
_ALONG = 0.5  # cosine to a body's surface, up to which a bar lies along it and does not stand on it


@dataclass(frozen=True)
class LimbConfig:
    """What counts as a limb, and where its sides are."""

    out: float = 2.0  # [mm] outside a body, from which a contact is in the air
    together: float = 15.0  # [mm] between neighbors of one limb
    least: int = 6  # contacts of it that lie on known surfaces
    most: int = 4  # limbs
    root: float = 8.0  # [mm] that it reaches on to the body that it stands on
    past: float = 0.5  # [mm] past the last contact, where a side is that no surface is
    wall: float = 2.5  # [mm] from the last contact, within which a known surface is the side
    thin: float = 0.4  # [mm] that a limb is thick at least
    unknown: float = 2.0  # [mm] that it is taken to be thick where one face alone was felt
    samples: int = 2000  # of a limb, to ask how much of it was passed through
    near: float = 2.0  # [mm] from a place that was passed through, that is so too
    empty: float = 0.12  # of it at most
    on: float = 2.0  # [mm] from its surface, up to which a contact is on it
    share: float = 0.5  # of its contacts at least, that are so
    side: float = 0.05  # of them, that a side at a known surface counts for
    strays: float = 0.2  # of as many contacts, up to which others may be buried by it
    apart: float = 2.0  # [mm] between contacts that are told apart


@dataclass(frozen=True)
class _Side:
    level: float  # [mm] along the way out
    wall: int | None = None  # the surface that it is


def with_limbs(body: Body, free: Floats | None, known: Known, config: LimbConfig = LimbConfig()) -> Body:
    """A body with what its contacts ask for besides; (n, 3) places `free` [mm] hold nothing."""
    on, strays = thinned(known.felt, config.apart), thinned(known.stray, config.apart)
    felt, named = np.concatenate([on, strays]), np.arange(len(on) + len(strays)) < len(on)
    nowhere = np.empty((0, 3)) if free is None else thinned(free, config.apart)
    given_up = np.zeros(len(felt), dtype=bool)
    for _ in range(config.most):
        away = body.solid.signed_distance(felt)
        rows = np.flatnonzero((away > config.out) & ~given_up)
        if named[rows].sum() < config.least:
            break
        limb = rows[max(clusters(felt[rows], config.together), key=np.count_nonzero)]
        given_up[limb] = True
        if named[limb].sum() < config.least:
            continue
        tried = [_rooted(piece, body.solid, config) for piece in _tried(felt[limb], known, config)]
        kept = [piece for piece in tried if not _empty(piece, nowhere, config)]
        joined = [whole for piece in kept if (whole := body.more(piece)) is not None]
        stood = [whole for whole in joined if _stands(whole, body, felt, felt[limb], config)]
        if stood:
            body = max(stood, key=lambda whole: _likely(whole, felt[limb], known, config))
            given_up &= body.solid.signed_distance(felt) > config.out
    return body


def _stands(whole: Body, before: Body, felt: Floats, limb: Floats, config: LimbConfig) -> bool:
    """Whether a body explains most of a limb, and buries hardly any contact that it did not bury before."""
    deep = (body.solid.signed_distance(felt) < -config.out for body in (whole, before))
    buried = int((next(deep) & ~next(deep)).sum())
    return buried <= config.strays * len(limb) and _explained(whole, limb, config) > config.share


def _explained(whole: Body, limb: Floats, config: LimbConfig) -> float:
    """Share of a limb's contacts on the surface of a body."""
    return float((np.abs(whole.solid.signed_distance(limb)) < config.on).mean())


def _likely(whole: Body, limb: Floats, known: Known, config: LimbConfig) -> float:
    """The same, and a little more for each side of the last piece at a known surface, or about a known axis."""
    piece = whole.pieces[-1]
    middle, axis = piece.world_from_piece[:3, 3], piece.world_from_piece[:3, 2]
    turned = isinstance(piece.solid, Bar) and any(
        np.linalg.norm(at - middle) < _COAXIAL for _, at in _axes(axis, middle, known)
    )
    return _explained(whole, limb, config) + config.side * (len(piece.surfaces) + turned)


def _axes(axis: Floats, middle: Floats, known: Known) -> list[tuple[int, Floats]]:
    """The known cylinders along a (3,) direction, and the (3,) places on their axes beside a middle."""
    return [
        (number, axis_beside(shape, middle))
        for number, shape in enumerate(known.shapes)
        if isinstance(shape, Cylinder) and abs(float(shape.direction @ axis)) > FLUSH
    ]


def _radius(number: int, known: Known) -> float:
    shape = known.shapes[number]
    assert isinstance(shape, Cylinder)
    return shape.radius


def _empty(piece: Piece, free: Floats, config: LimbConfig) -> bool:
    """Whether too much of a piece was passed through."""
    low, high = piece.placed.bounds()
    some = drawn(low, high, config.samples)
    some = some[_inside(piece.placed, some)]
    return not len(some) or float(among(some, free, config.near).mean()) > config.empty


def _inside(tree: Csg, points: Floats) -> Floats:
    return np.asarray(tree.signed_distance(points) < 0.0)


def _rooted(piece: Piece, solid: Solid, config: LimbConfig) -> Piece:
    """A piece that reaches on into the body that it stands on, but not out of that behind."""
    turn, middle = piece.world_from_piece[:3, :3], piece.world_from_piece[:3, 3]
    way = solid.normals(middle[None])[0] @ turn  # out of the body, as the piece lies
    axis = int(np.argmax(np.abs(way))) if isinstance(piece.solid, Cube) else 2
    if abs(float(way[axis])) < _ALONG:
        return piece  # it lies along the body
    above = float(way[axis]) < 0.0  # the end that stands on the body
    down = (1.0 if above else -1.0) * turn[:, axis]
    tall = piece.size(axis)
    steps = np.arange(_STEP, config.root + _STEP, _STEP)
    inside = solid.signed_distance(middle + np.outer(0.5 * tall + steps, down)) < 0.0
    into = steps[inside]
    if not len(into):
        return piece
    deep = float(into[0]) + 0.5 * float(np.count_nonzero(inside)) * _STEP
    return piece.longer(axis, above, deep)


def _tried(limb: Floats, known: Known, config: LimbConfig) -> list[Piece]:
    """Boxes along the object's frames and bars along its directions, round a limb."""
    boxes = [_box(frame, limb, known, config) for frame in known.frames]
    bars = [_bar(axis, limb, known, config) for axis in known.directions]
    return [piece for piece in (*boxes, *bars) if piece is not None]


def _box(frame: Floats, limb: Floats, known: Known, config: LimbConfig) -> Piece | None:
    low, high, ends = np.empty(3), np.empty(3), []
    for k, way in enumerate(frame.T):
        below, above = _sides(way, limb, known, config)
        low[k], high[k] = -below.level, above.level
        ends.append((below.wall, above.wall))
    size = high - low
    if (size < config.thin).any():
        return None
    middle = frame @ (0.5 * (low + high))
    return Piece("cube", "add", Cube(tuple(size.tolist())), pose(frame, middle), None, tuple(ends), LIMB)


def _bar(axis: Floats, limb: Floats, known: Known, config: LimbConfig) -> Piece | None:
    frame, body = frame_along(axis), None
    flat = limb @ frame[:, :2]
    center, radius = enclosing_circle(flat)
    about = [(number, at @ frame[:, :2]) for number, at in _axes(axis, limb.mean(axis=0), known)]
    about = [(number, at) for number, at in about if float(np.linalg.norm(at - center)) < config.wall]
    own = [(number, at) for number, at in about if abs(_radius(number, known) - radius) < config.wall]
    if own:
        body, center = own[-1]
        radius = _radius(body, known)
    elif about:
        center = about[0][1]
        radius = float(np.linalg.norm(flat - center, axis=1).max())
    below, above = _sides(axis, limb, known, config)
    tall = above.level + below.level
    if tall < config.thin or radius < config.thin:
        return None
    middle = frame @ np.array([*center, 0.5 * (above.level - below.level)])
    ends = ((below.wall, above.wall),)
    return Piece("cylinder", "add", Bar(float(radius), float(tall)), pose(frame, middle), body, ends, LIMB)


def _sides(way: Floats, limb: Floats, known: Known, config: LimbConfig) -> tuple[_Side, _Side]:
    """Where it ends against a (3,) way, and along it."""
    below, above = _side(-way, limb, known, config), _side(way, limb, known, config)
    if above.level + below.level < config.unknown:  # contacts of one face alone
        if below.wall is not None:
            above = _behind(way, -below.level, limb, known, config)
        elif above.wall is not None:
            below = _behind(-way, -above.level, limb, known, config)
    return below, above


def _side(way: Floats, limb: Floats, known: Known, config: LimbConfig) -> _Side:
    """Where it ends along a (3,) way out."""
    last = float((limb @ way).max())
    walls = [(abs(level - last), number, level) for number, level in _walls(way, limb, known)]
    off, number, level = min(walls, default=(np.inf, -1, 0.0))
    return _Side(level, number) if off < config.wall else _Side(last + config.past)


def _behind(way: Floats, felt: float, limb: Floats, known: Known, config: LimbConfig) -> _Side:
    """The next known wall along a (3,) way, from a face felt at a level [mm]; without one as thin as can be."""
    walls = [(level, number) for number, level in _walls(way, limb, known) if level > felt + config.thin]
    return _Side(*min(walls)) if walls else _Side(felt + config.unknown)


def _walls(way: Floats, limb: Floats, known: Known) -> list[tuple[int, float]]:
    """The known flat surfaces that look along a (3,) way, and how far along it [mm] they pass a limb's middle."""
    return [
        (number, level_of(shape, way, limb.mean(axis=0)))
        for number, shape in enumerate(known.shapes)
        if isinstance(shape, Plane) and float(shape.normal @ way) > FLUSH
    ]
