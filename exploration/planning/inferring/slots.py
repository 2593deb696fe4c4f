"""Slots that no array has room in: a long gap in a flat face, and in the face behind it places that are not there.

Along a gap in a flat face the free places end where the touched ones begin, across it on both sides, and at both
of its ends.  Each of these four rims is where fewest places lie on the wrong side.  Where the face that looks away
from it is not there behind the gap either, a slot goes through, its ends round, as a mill leaves them (our
derivation; that is likely and not measured, so its walls are marked as inferred).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy.spatial import KDTree

from exploration.planning.known.surface_map import clusters
from exploration.planning.open.known_face import KnownFace
from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit
from primitives.patch_graph import Face
from primitives.shapes import Plane


@dataclass(frozen=True)
class SlotConfig:
    """What is a slot."""

    clear: float = 1.2  # [mm] of a free place from all that was touched
    cell: float = 1.0  # [mm] free places nearer than this are one
    together: float = 3.5  # [mm] between neighbors of one gap
    least: int = 6  # places of it
    longer: float = 1.6  # times as long as wide
    middle: float = 0.7  # of its length, over which its sides are looked for, and of its width, its ends
    past: float = 10.0  # [mm] behind a rim, within which places say where it is
    over: float = 1.2  # [mm] past a rim, that places count as touched: skin that bends over it reads so
    wrong: float = 0.2  # of those, that may lie on the wrong side
    sides: int = 2  # touched places that a rim takes
    snap: float = 0.15  # [rad] from a direction of the object, that is its own then
    opposed: float = 0.98  # least cosine between the two faces' ways
    aside: float = (
        2.0  # [mm] in all, that the face behind may reach over its rim; and between slots that are one
    )
    parts: int = 6  # of its length,
    seen: float = 0.6  # share of them in which the face behind is known not to be
    mouth: float = 1.0  # [mm] before it, that is its mouth
    lip: float = 2.5  # [mm] from its round ends, where what looks like a straight edge is a part of them
    slant: float = 0.3  # sine from its axes, from which an edge there is none of a straight end
    sigma: float = 0.5  # [mm] at least
    normal_sigma: float = 0.05  # [rad]


@dataclass(frozen=True)
class SlotRim:
    """A long gap in a flat face."""

    center: Floats  # (3,) [mm]
    axis: Floats  # (3,) out of the face
    along: Floats  # (3,)
    length: float  # [mm] over its ends
    width: float  # [mm]
    sigma: float  # [mm] of where its sides are


@dataclass(frozen=True)
class Slot:
    """One that goes through, between two gaps."""

    center: Floats  # (3,) [mm] half way down
    axis: Floats  # (3,)
    along: Floats  # (3,)
    length: float  # [mm] over its round ends
    width: float  # [mm]
    depth: float  # [mm]
    sigma: float  # [mm]

    def sides(self, config: SlotConfig = SlotConfig()) -> list[Contacts]:
        """Contacts of its two flat walls, which nobody felt."""
        across, straight = np.cross(self.axis, self.along), 0.5 * (self.length - self.width)
        down = [share * self.depth * self.axis for share in (-0.35, 0.0, 0.35)]
        reach = np.linspace(-straight, straight, 5)[:, None] * self.along
        out: list[Contacts] = []
        for side in (1.0, -1.0):
            wall = self.center + side * 0.5 * self.width * across + reach
            out.append(self._contacts(np.concatenate([wall + d for d in down]), -side * across, config))
        return out

    def ends(self, config: SlotConfig = SlotConfig()) -> list[Contacts]:
        """Contacts of its two half-round walls, likewise."""
        across, straight = np.cross(self.axis, self.along), 0.5 * (self.length - self.width)
        turn = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 9)[1:-1, None]
        out: list[Contacts] = []
        for side in (1.0, -1.0):
            ways = np.cos(turn) * side * self.along + np.sin(turn) * across
            wall = self.center + side * straight * self.along + 0.5 * self.width * ways
            places = [wall + share * self.depth * self.axis for share in (-0.35, 0.0, 0.35)]
            out.append(self._contacts(np.concatenate(places), np.tile(-ways, (3, 1)), config))
        return out

    def between(self, walls: Sequence[Plane]) -> Slot:
        """With its sides where two walls turned out to be, of which the first is ahead across it."""
        across = np.cross(self.axis, self.along)
        ahead, behind = (
            float((wall.origin - self.center) @ wall.normal / (across @ wall.normal)) for wall in walls
        )
        return replace(self, center=self.center + 0.5 * (ahead + behind) * across, width=ahead - behind)

    def off(self, face: Face, config: SlotConfig = SlotConfig()) -> Face:
        """A face without its contacts in a mouth, where a pad lay over it and none has a place of its own."""
        if not isinstance(face.fit, Fit) or face.fit.kind != "plane":
            return face
        return face.only(~self.holds(face.contacts.points, config))

    def holds(self, points: Floats, config: SlotConfig) -> Bools:
        """(n,) whether (n, 3) points are in it or in one of its mouths."""
        away = points - self.center
        past = np.maximum(np.abs(away @ self.along) - 0.5 * (self.length - self.width), 0.0)
        aside = np.hypot(past, away @ np.cross(self.axis, self.along))
        return np.asarray(
            (aside < 0.5 * self.width) & (np.abs(away @ self.axis) < 0.5 * self.depth + config.mouth)
        )

    def rounds(self, point: Floats, outward: Floats, config: SlotConfig = SlotConfig()) -> bool:
        """Whether an edge at a (3,) point that leads (3,) `outward` from its face is a part of a round end."""
        away = point - self.center
        past = abs(float(away @ self.along)) - 0.5 * (self.length - self.width)
        aside = np.hypot(past, float(away @ np.cross(self.axis, self.along)))
        at_end = past > 0.0 and abs(aside - 0.5 * self.width) < config.lip
        level = abs(float(away @ self.axis)) < 0.5 * self.depth + config.mouth
        slanting = config.slant < abs(float(outward @ self.along)) < np.sqrt(1.0 - config.slant**2)
        return bool(at_end and level and slanting)

    def _contacts(self, places: Floats, looks: Floats, config: SlotConfig) -> Contacts:
        normals = np.broadcast_to(looks, places.shape)
        return Contacts.of(places, normals, self.sigma, config.normal_sigma, touch=NOT_FELT)


def slots(known: Sequence[KnownFace], config: SlotConfig = SlotConfig()) -> list[Slot]:
    """The slots that go through, each once."""
    flat = [own for own in known if own.fit.kind == "plane"]
    axes = [own.fit.shape.direction for own in flat]
    crossed = [np.cross(a, b) for a, b in combinations(axes, 2) if abs(float(a @ b)) < config.snap]
    ways = np.array([*axes, *crossed]).reshape(-1, 3)
    out: list[Slot] = []
    for own in flat:
        for rim in slot_rims(own, ways, config):
            found = next((slot for other in flat if (slot := _through(rim, other, config))), None)
            if found is not None and not any(_same(found, slot, config) for slot in out):
                out.append(found)
    return out


def slot_rims(own: KnownFace, ways: Floats, config: SlotConfig = SlotConfig()) -> list[SlotRim]:
    """The long gaps in a flat face; `ways` (n, 3) are directions that the object has."""
    if not len(own.cells) or not len(own.free):
        return []
    axis = own.side * own.fit.shape.direction
    flat = own.fit.shape.project(own.free)
    _, first = np.unique(np.round(flat / config.cell).astype(int), axis=0, return_index=True)
    flat = flat[np.sort(first)]
    flat = flat[KDTree(own.cells).query(flat)[0] > config.clear]
    found: list[SlotRim] = []
    for members in clusters(flat, config.together) if len(flat) else ():
        if members.sum() >= config.least:
            rim = _rim_of(flat[members], own.cells, axis, ways, config)
            found += [rim] if rim is not None else []
    return found


def _rim_of(free: Floats, cells: Floats, axis: Floats, ways: Floats, config: SlotConfig) -> SlotRim | None:
    """The gap of (n, 3) free places among (m, 3) touched ones, where it is long and shut all round."""
    middle = free.mean(axis=0)
    along = np.linalg.svd(free - middle, full_matrices=False)[2][0]
    near = ways[np.linalg.norm(np.cross(ways, along), axis=1) < config.snap]
    along = along if not len(near) else near[0] - float(near[0] @ axis) * axis
    along = along / np.linalg.norm(along)
    turn = np.column_stack([along, np.cross(axis, along)])
    inside, felt = (free - middle) @ turn, (cells - middle) @ turn
    long, wide = np.ptp(inside, axis=0)
    if long < config.longer * wide:
        return None
    core = np.abs(inside[:, 0] - np.median(inside[:, 0])) < 0.5 * config.middle * long
    beside = np.abs(felt[:, 0] - np.median(inside[:, 0])) < 0.5 * config.middle * long
    sides = [_cut(s * inside[core, 1], s * felt[beside, 1], config) for s in (1.0, -1.0)]
    if sides[0] is None or sides[1] is None:
        return None
    width, across = sides[0][0] + sides[1][0], 0.5 * (sides[0][0] - sides[1][0])
    core = np.abs(inside[:, 1] - across) < 0.3 * config.middle * width
    before = np.abs(felt[:, 1] - across) < 0.5 * config.middle * width
    ends = [_cut(s * inside[core, 0], s * felt[before, 0], config) for s in (1.0, -1.0)]
    if ends[0] is None or ends[1] is None or ends[0][0] + ends[1][0] < config.longer * width:
        return None
    center = middle + turn @ np.array([0.5 * (ends[0][0] - ends[1][0]), across])
    sigma = max(config.sigma, max(sides[0][1], sides[1][1]) / np.sqrt(12.0))
    return SlotRim(center, axis, along, ends[0][0] + ends[1][0], width, float(sigma))


def _cut(inside: Floats, felt: Floats, config: SlotConfig) -> tuple[float, float] | None:
    """[mm] where a gap ends along a way out, and how unsure that is, from (n,) free and (m,) touched places."""
    if not len(inside):
        return None
    here, there = inside, felt[(felt > 0.0) & (felt < float(inside.max()) + config.past)]
    if len(there) < config.sides:
        return None
    bounds = np.sort(np.concatenate([here, there]))
    cuts = 0.5 * (bounds[1:] + bounds[:-1])
    wrong = np.array([(there < cut).sum() + (here > cut).sum() for cut in cuts])
    best = np.flatnonzero(wrong == wrong.min())
    widest = best[np.argmax(bounds[best + 1] - bounds[best])]
    if wrong.min() > config.wrong * min(len(there), len(here)):
        return None
    return float(cuts[widest]) + config.over, float(bounds[widest + 1] - bounds[widest])


def _through(rim: SlotRim, other: KnownFace, config: SlotConfig) -> Slot | None:
    """The slot from a gap to a face behind it that looks away from it, and is not there either."""
    normal = other.side * other.fit.shape.direction
    depth = -float((other.fit.shape.anchor - rim.center) @ rim.axis)
    if float(normal @ rim.axis) > -config.opposed or depth <= 0.0:
        return None
    center = rim.center - 0.5 * depth * rim.axis
    slot = Slot(center, rim.axis, rim.along, rim.length, rim.width, depth, rim.sigma)
    free = other.free[slot.holds(other.free, config)]
    inner = replace(slot, length=rim.length - config.aside, width=rim.width - config.aside)
    stands = inner.holds(other.cells, config).sum()
    parts = np.unique(np.floor((free - center) @ rim.along / rim.length * config.parts))
    there = len(parts) >= config.seen * config.parts and stands <= config.wrong * len(free)
    return slot if there else None


def _same(a: Slot, b: Slot, config: SlotConfig) -> bool:
    return float(np.linalg.norm(a.center - b.center)) < config.aside
