"""What an array passed through holds nothing: boxes and round holes take away what a body has there.

Walls that no array has room to lie on may be known and still bound no cell, as the sides of a slot of which nobody
felt the end; then a body of cells is solid where the array went.  Such places, hanging together, make a hollow.  A
side of it is open where the body ends just behind it, is a wall that is known there, and else lies between the
last place of the hollow and the first contact behind it (our derivation).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exploration.planning.known.surface_map import clusters
from models.csg import Csg, Cube
from models.csg import Cylinder as Bar
from models.solid import Solid
from primitives.arrays import Bools, Floats
from primitives.pose import frame_along, pose
from primitives.shapes import Cylinder, Plane
from recognition.assembly.enclosing import enclosing_circle
from recognition.assembly.made import FLUSH, Body, Known, among, axis_beside, drawn, level_of, thinned
from recognition.assembly.piece import Piece

HOLLOW = "a hollow that no faces close is taken away where an array passed through"


@dataclass(frozen=True)
class HollowConfig:
    """What counts as a hollow, and where its sides are."""

    deep: float = (
        2.0  # [mm] under a body's surface, from which a place that was passed through contradicts it
    )
    apart: float = 2.0  # [mm] between places that are told apart
    cell: float = 4.0  # [mm] between the places that a side of a hollow is looked for behind
    together: float = 6.0  # [mm] between neighbors of one hollow
    least: int = 6  # places of it
    most: int = 6  # hollows
    step: float = 0.5  # [mm] at which it is looked past a side
    opens: float = 5.0  # [mm] past the last place, within which the body ends behind an open side
    opened: float = 0.6  # share of the places at a side, that find it so
    past: float = 1.0  # [mm] that what takes away reaches out of the body there
    over: float = 1.0  # [mm] from the hollow, straight behind which contacts shut a side
    wall: tuple[float, float] = (-1.0, 8.0)  # [mm] past the last place, where a known wall is the side
    beside: float = 6.0  # [mm] from the hollow to the nearest place of that wall
    unfelt: float = 12.0  # [mm] past the last place, up to which the first contact tells of the side
    aside: float = 4.0  # [mm] aside of the hollow, that such a contact may be
    margin: float = 1.5  # [mm] past the last place, where a side is that nothing tells of
    inside: float = 1.5  # [mm] in a hollow, from where a contact contradicts it
    lost: int = 2  # such contacts at most
    worth: float = 4.0  # [mm^3] for each place of a hollow, that must go with it
    samples: int = 2000  # of what is taken away, to ask how much of it was passed through
    near: float = 2.8  # [mm] from a place that was passed through, that is so too
    full: float = 0.5  # least share of what is taken away, that was passed through;
    known: float = 1.5  # each known surface that is a side counts for so many times as much
    coaxial: float = 3.0  # [mm] between the axes of a hollow and of a known round wall, and of their radii


def hollowed(body: Body, free: Floats | None, known: Known, config: HollowConfig = HollowConfig()) -> Body:
    """A body without what (n, 3) `free` places [mm] on a lattice contradict, as far as that is understood."""
    if free is None or not len(free):
        return body
    free, felt = thinned(free, config.apart), thinned(known.felt, config.apart)
    given_up = np.zeros(len(free), dtype=bool)
    for _ in range(config.most):
        buried = (body.solid.signed_distance(free) < -config.deep) & ~given_up
        hollow = _largest(free, buried, config)
        if hollow.sum() < config.least:
            break
        found = _best(body.solid, free, _grown(body.solid, free, free[hollow], config), felt, known, config)
        less = None if found is None else body.less(found)
        given_up |= hollow
        if less is not None and body.solid.volume - less.solid.volume > config.worth * hollow.sum():
            body, given_up = less, given_up & (less.solid.signed_distance(free) < 0.0)
    return body


def _largest(free: Floats, buried: Bools, config: HollowConfig) -> Bools:
    """(n,) the largest lot of buried places that hang together; of small ones all, which may lie in one ring."""
    out = np.zeros(len(free), dtype=bool)
    rows = np.flatnonzero(buried)
    if len(rows):
        most = max(clusters(free[rows], config.together), key=np.count_nonzero)
        out[rows if most.sum() < config.least else rows[most]] = True
    return out


def _grown(solid: Solid, free: Floats, hollow: Floats, config: HollowConfig) -> Floats:
    """A hollow with what lies beside it just under the body's surface."""
    near = free[among(free, hollow, config.together)]
    return near[solid.signed_distance(near) < 0.0]


def _best(
    solid: Solid, free: Floats, hollow: Floats, felt: Floats, known: Known, config: HollowConfig
) -> Piece | None:
    """What takes a hollow away best: most of it was passed through, and no contact is lost with it."""
    sides = _Sides(solid, hollow, felt, known, config)
    tried = [sides.box(frame) for frame in known.frames]
    tried += [sides.bar(axis) for axis in known.directions]
    best, most = None, 0.0
    for piece in tried:
        if piece is None or _lost(piece.placed, felt, config) > config.lost:
            continue
        known_sides = config.known ** len(piece.surfaces)
        share = _passed(piece.placed, solid, free, config) * known_sides
        likely = share * float((piece.placed.signed_distance(hollow) < 0.0).mean())
        if share > config.full and likely > most:
            best, most = piece, likely
    return best


def _passed(tree: Csg, solid: Solid, free: Floats, config: HollowConfig) -> float:
    """Share of what a tree takes from a solid, that was passed through."""
    low, high = tree.bounds()
    some = drawn(low, high, config.samples)
    some = some[tree.signed_distance(some) < 0.0]
    some = some[solid.signed_distance(some) < 0.0]
    return float(among(some, free, config.near).mean()) if len(some) else 0.0


def _lost(tree: Csg, felt: Floats, config: HollowConfig) -> int:
    """Contacts that what is taken away leaves in the air."""
    return int((tree.signed_distance(felt) < -config.inside).sum()) if len(felt) else 0


@dataclass(frozen=True)
class _Side:
    level: float  # [mm] along the way out
    wall: int | None = None  # the surface that it is
    opens: bool = False  # to the air


class _Sides:
    """Where a hollow ends."""

    def __init__(
        self, solid: Solid, hollow: Floats, felt: Floats, known: Known, config: HollowConfig
    ) -> None:
        self._solid, self._hollow, self._middle = solid, hollow, hollow.mean(axis=0)
        self._felt, self._known, self._config = felt, known, config

    def box(self, frame: Floats) -> Piece | None:
        """Along the columns of a (3, 3) frame."""
        sides = [(self._side(-way, frame), self._side(way, frame)) for way in frame.T]
        low, high = np.array([[-below.level, above.level] for below, above in sides]).T
        if not (high > low).all():
            return None
        size = high - low
        middle = frame @ (0.5 * (low + high))
        ends = tuple((below.wall, above.wall) for below, above in sides)
        return Piece("cube", "subtract", Cube(tuple(size.tolist())), pose(frame, middle), None, ends, HOLLOW)

    def bar(self, axis: Floats) -> Piece | None:
        """Round an axis, from an open end: of a known round wall, else of the least circle round the places."""
        frame = frame_along(axis)
        flat = (self._hollow @ frame)[:, :2]
        center, radius = enclosing_circle(flat)
        felt = self._felt @ frame
        low, high = (self._hollow @ axis).min(), (self._hollow @ axis).max()
        level = (felt[:, 2] > low - self._config.aside) & (felt[:, 2] < high + self._config.aside)
        radius, body = self._short_of(radius, np.linalg.norm(felt[level, :2] - center, axis=1)), None
        for number, shape in enumerate(self._known.shapes):
            if isinstance(shape, Cylinder) and abs(float(shape.direction @ axis)) > FLUSH:
                at = (axis_beside(shape, self._middle) @ frame)[:2]
                off = max(float(np.linalg.norm(at - center)), abs(shape.radius - radius))
                if off < self._config.coaxial and self._wall_beside(number):
                    center, radius, body = at, shape.radius, number
        below, above = self._side(-axis, frame), self._side(axis, frame)
        tall = above.level + below.level
        if tall <= 0.0 or radius <= 0.0 or not (below.opens or above.opens):
            return None
        middle = frame @ np.array([*center, 0.5 * (above.level - below.level)])
        return Piece(
            "cylinder", "subtract", Bar(float(radius), float(tall)), pose(frame, middle), body,
            ((below.wall, above.wall),), HOLLOW,
        )  # fmt: skip

    def _side(self, way: Floats, frame: Floats) -> _Side:
        """Along a (3,) way out, which is a column of a (3, 3) frame or against one."""
        config, along = self._config, self._hollow @ way
        last = float(along.max())
        front = self._hollow[along > last - config.cell]
        shapes = range(len(self._known.shapes))
        walls = [wall for k in shapes if (wall := self._wall(k, way, last)) is not None]
        wall = min(walls, key=lambda wall: wall.level, default=None)
        room = self._to_air(front, way, last)
        if (
            room is not None
            and (wall is None or wall.level > last + room)
            and not self._shut(way, last + room)
        ):
            return _Side(last + room + config.past, opens=True)
        if wall is not None:
            return wall
        across = [column for column in frame.T if abs(float(column @ way)) < 0.5]
        straight = np.ones(len(self._felt), dtype=bool)
        for column in across:
            mine, theirs = self._hollow @ column, self._felt @ column
            straight &= (theirs > mine.min() - config.aside) & (theirs < mine.max() + config.aside)
        return _Side(self._short_of(last, (self._felt @ way)[straight]))

    def _to_air(self, front: Floats, way: Floats, last: float) -> float | None:
        """[mm] past the last place to where the body ends, before most of the places at the side."""
        config = self._config
        ahead = np.arange(config.step, config.opens + config.step, config.step)
        level = front + (last - front @ way)[:, None] * way
        steps = level[:, None] + ahead[:, None] * way
        out = self._solid.signed_distance(steps.reshape(-1, 3)).reshape(len(front), -1) > 0.0
        ends = out.any(axis=1)
        return float(ahead[out[ends].argmax(axis=1)].max()) if ends.mean() >= config.opened else None

    def _shut(self, way: Floats, end: float) -> bool:
        """Whether a face was felt over the hollow where the body ends, `end` mm along a (3,) way out."""
        there = np.abs(self._felt @ way - end) < self._config.past
        flat = [at - np.outer(at @ way, way) for at in (self._felt[there], self._hollow)]
        return int(among(flat[0], flat[1], self._config.over).sum()) > self._config.lost

    def _wall(self, number: int, way: Floats, last: float) -> _Side | None:
        """A flat wall that is known past the last place, looking back into the hollow."""
        shape, (near, far) = self._known.shapes[number], self._config.wall
        if not isinstance(shape, Plane) or float(shape.normal @ way) > -FLUSH:
            return None
        level = level_of(shape, way, self._middle)
        is_side = near < level - last < far and self._wall_beside(number)
        return _Side(level, number) if is_side else None

    def _wall_beside(self, number: int) -> bool:
        """Whether a known surface has a place in the box round the hollow, or just beside it."""
        at, room = self._known.places[number], self._config.beside + self._config.wall[1]
        low, high = self._hollow.min(axis=0) - room, self._hollow.max(axis=0) + room
        return bool(((at > low) & (at < high)).all(axis=1).any())

    def _short_of(self, last: float, felt: Floats) -> float:
        """[mm] half way from the last place to the first contact behind it; a little behind it without one."""
        behind = felt[(felt > last) & (felt < last + self._config.unfelt)]
        return 0.5 * (last + float(behind.min())) if len(behind) else last + self._config.margin
