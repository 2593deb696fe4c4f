"""Walls between two faces that look the same way, one higher than the other, inferred where none was felt.

Whoever goes from the floor of a pocket outward comes to the face round its mouth, and from the top of an island to
the floor round it: in between a wall stands, whether or not any pad had room to face it.  On the way the one face
ends, and so do the places where the skin felt that the other is not there, and the other begins; the wall stands
upright between, as surely as that gap is narrow, or where a stroke was stopped in it (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial import ConvexHull

from exploration.planning.inferring.patch import Patch
from exploration.planning.known.surface_map import clusters
from exploration.planning.open.known_face import KnownFace
from exploration.planning.touching.stops import Stop
from primitives.arrays import Floats
from primitives.evidence import NOT_FELT, Contacts


@dataclass(frozen=True)
class RiserConfig:
    """What counts as two faces with a wall in between."""

    alike: float = 0.999  # least cosine between the two normals
    step: float = 1.5  # [mm] that one is higher than the other, at least
    upright: float = 0.03  # most cosine between their normal and a direction across it
    least: int = 4  # touched places of a patch from which one goes out
    cluster: float = 8.0  # [mm] between neighboring places of one patch
    strays: int = 1  # touched places on the way, that are none of a face there
    side: float = (
        0.2  # of a patch's places, on either hand, that lie beside the middle from which one goes out
    )
    beside: float = 0.75  # of a patch's places, at least, over or under which the other face does not lie
    over: float = 3.0  # [mm] across the two, within which it does
    wrong: float = 0.2  # of places, that may lie on the wrong side of where a face begins
    past: float = 6.0  # [mm] behind where a face has begun, within which places say where
    gap: float = 30.0  # [mm] between the two, from which nothing is said of the wall
    behind: float = 2.0  # [mm] behind a rim, where the wall's face cannot be any more
    as_wide: float = 0.15  # of its size, that a round patch may be wider than long
    row: float = 1.0  # [mm] that a patch is wide at most, of which all places are in a row
    corners: float = 0.88  # of its box, that a patch with corners covers; a round one covers pi / 4
    met: float = 2.0  # [mm] about the gap, within which what stopped a stroke was this wall
    normal_sigma: float = 0.05  # [rad]
    sigma: float = 0.5  # [mm] at least


class _Rim(NamedTuple):
    """Where, along one way [mm]."""

    at: float
    gap: float
    begun: float


_NOWHERE = _Rim(np.inf, 0.0, np.inf)


class Riser(NamedTuple):
    """A wall that nobody felt."""

    contacts: Contacts
    kind: str  # plane, or cylinder


def risers(
    known: Sequence[KnownFace], stops: Sequence[Stop] = (), config: RiserConfig = RiserConfig()
) -> list[Riser]:
    """Contacts of each wall that is missing, as if felt at a quarter and three quarters of its height."""
    ways = _ways(known)
    flat = [
        own
        for own in known
        if own.fit.kind == "plane"
        and len(own.cells) >= config.least
        and (own.face.contacts.touch != NOT_FELT).any()  # who guesses a face does not know where it ends
    ]
    out: list[Riser] = []
    for own in flat:
        normal = own.side * own.fit.shape.direction
        level = float((own.cells @ normal).mean())
        across = [w for w in ways if abs(float(w @ normal)) < config.upright]
        others = [
            (other, float((other.cells @ normal).mean()) - level)
            for other in flat
            if float(other.side * other.fit.shape.direction @ normal) > config.alike
        ]
        others = [(other, step) for other, step in others if abs(step) > config.step]
        if not others or not across:
            continue
        for members in clusters(own.cells, config.cluster):
            if members.sum() >= config.least:
                patch = Patch(own, own.cells[members], normal)
                steps = [
                    (other, step)
                    for other, step in others
                    if patch.beside(other.cells, config.over) > config.beside
                ]
                found = [_wall(patch, way, steps, known, stops, config) for way in _four(normal, across[0])]
                walls = [wall for wall in found if wall is not None]
                ring = _ring(patch, found, config) if len(walls) >= 3 else None
                out += (
                    [Riser(wall.contacts(patch, config), "plane") for wall in walls]
                    if ring is None
                    else [ring]
                )
    return out


def _four(normal: Floats, first: Floats) -> Iterator[Floats]:
    second = np.cross(normal, first)
    yield from (first, -first, second, -second)


@dataclass(frozen=True)
class _Wall:
    """Upright, across one way out of a patch."""

    way: Floats  # (3,)
    at: float  # [mm] along it
    gap: float  # [mm] that may hold it
    step: float  # [mm] up, or down where it is negative

    def contacts(self, patch: Patch, config: RiserConfig) -> Contacts:
        """As if felt at a quarter and three quarters of its height, in three places."""
        along = np.cross(patch.normal, self.way)
        reach = np.ptp(patch.cells @ along) / 2.0
        foot = patch.middle + (self.at - float(patch.middle @ self.way)) * self.way
        up = self.step * patch.normal
        places = np.array([foot + u * reach * along + v * up for u in (-1, 0, 1) for v in (0.25, 0.75)])
        looks = np.tile(-np.sign(self.step) * self.way, (len(places), 1))
        sigma = max(config.sigma, self.gap / np.sqrt(12.0))
        return Contacts.of(places, looks, sigma, config.normal_sigma, touch=NOT_FELT)


def _wall(
    patch: Patch,
    way: Floats,
    others: Sequence[tuple[KnownFace, float]],
    known: Sequence[KnownFace],
    stops: Sequence[Stop],
    config: RiserConfig,
) -> _Wall | None:
    """The wall that one comes to, where it is not known; that of the face that begins first."""
    seen = [(_where(patch, way, other, step > 0, config), step) for other, step in others]
    seen = [
        (rim, step) for rim, step in seen if step > 0.0 or not _rises(patch, way, rim.begun, others, config)
    ]
    rim, step = min(seen, key=lambda found: found[0][0], default=(_NOWHERE, 0.0))
    at, gap, _ = rim
    if not np.isfinite(at) or gap > config.gap or _stands(known, patch, way, rim, step, config):
        return None
    side = -np.sign(step)
    met = [
        side * s.offset
        for s in stops
        if side * float(s.normal @ way) > config.alike and abs(side * s.offset - at) < 0.5 * gap + config.met
    ]
    return _Wall(way, float(np.median(met)) if met else at, 0.0 if met else gap, step)


def _rises(
    patch: Patch, way: Floats, begun: float, others: Sequence[tuple[KnownFace, float]], config: RiserConfig
) -> bool:
    """Whether on the way down to where a face has begun one that is higher was felt: first one goes up there."""
    edge = patch.edge(way)
    for other, step in others:
        ahead = patch.ahead(other.cells, way, config.side) if step > 0.0 else np.empty(0)
        if np.count_nonzero((ahead > edge) & (ahead < begun)) > config.strays:
            return True
    return False


def _ring(patch: Patch, walls: Sequence[_Wall | None], config: RiserConfig) -> Riser | None:
    """One round wall in the place of four that go down, where the patch is as wide as long and lacks corners.

    One of them may be known, or have stopped a stroke: then the other two tell how wide the patch is.
    """
    told = [wall for wall in walls if wall is not None]
    if any(wall.step > 0.0 for wall in told):
        return None
    across, along = _span(walls[:2]), _span(walls[2:])
    width, length = across or along, along or across
    if width is None or length is None:
        return None
    first = next(wall.way for wall in walls[:2] if wall is not None) * (1.0 if walls[0] else -1.0)
    second = next(wall.way for wall in walls[2:] if wall is not None) * (1.0 if walls[2] else -1.0)
    spread = patch.cells @ np.column_stack([first, second])
    size = np.ptp(spread, axis=0)
    square = abs(width - length) <= config.as_wide * max(width, length)
    if not square or size.min() < config.row or np.ptp(size) > 2.0 * config.as_wide * size.max():
        return None
    if ConvexHull(spread).volume > config.corners * float(np.prod(size)):
        return None
    radius = 0.25 * (width + length)
    level = float((patch.cells @ patch.normal).mean())
    center = _middle(walls[:2], radius) * first + _middle(walls[2:], radius) * second
    turns = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    out = np.cos(turns)[:, None] * first + np.sin(turns)[:, None] * second
    places = [center + radius * out + (level + v * told[0].step) * patch.normal for v in (0.25, 0.75)]
    sigma = max(config.sigma, max(wall.gap for wall in told) / np.sqrt(12.0))
    looks = np.concatenate([out, out])
    return Riser(
        Contacts.of(np.concatenate(places), looks, sigma, config.normal_sigma, touch=NOT_FELT), "cylinder"
    )


def _span(pair: Sequence[_Wall | None]) -> float | None:
    """[mm] between two walls that look away from each other, where both are told."""
    one, other = pair
    return None if one is None or other is None else one.at + other.at


def _middle(pair: Sequence[_Wall | None], radius: float) -> float:
    """[mm] along the first one's way, of the middle of a round patch that one of them at least bounds."""
    one, other = pair
    sides = [*([one.at - radius] if one else []), *([radius - other.at] if other else [])]
    return float(np.mean(sides))


def _where(patch: Patch, way: Floats, other: KnownFace, up: bool, config: RiserConfig) -> _Rim:
    """Where one goes up or down along `way`, in how wide a gap, and where the other face begins.

    The place that leaves fewest touched and empty places on the wrong side; infinite where the other face never
    begins, or the patch's own goes on before.
    """
    edge = patch.edge(way) - config.behind
    begins = patch.ahead(other.cells, way, config.side)
    begins = begins[begins > edge]
    more = patch.ahead(patch.own.cells, way, config.side)
    more = more[more > edge + config.behind + config.cluster]
    if not len(begins) or (len(more) and float(more.min()) < float(np.quantile(begins, config.wrong))):
        return _NOWHERE
    lower, here = (other, patch.cells @ way) if up else (patch.own, patch.cells @ way)
    free = patch.ahead(lower.free, way, config.side)
    here, there = (
        (np.concatenate([here, free]), begins) if up else (here, np.concatenate([begins, free[free > edge]]))
    )
    begun = float(np.quantile(begins, config.wrong))
    end = float(np.quantile(there, config.wrong)) + config.past
    here, there = here[here < end], there[there < end]
    bounds = np.sort(np.concatenate([here, there]))
    cuts = 0.5 * (bounds[1:] + bounds[:-1])
    wrong = np.array([(there < cut).sum() + (here > cut).sum() for cut in cuts])
    best = np.flatnonzero(wrong == wrong.min())
    widest = best[np.argmax(bounds[best + 1] - bounds[best])]
    lost = wrong.min() > config.wrong * len(there) or cuts[widest] < edge
    return _NOWHERE if lost else _Rim(float(cuts[widest]), float(bounds[widest + 1] - bounds[widest]), begun)


def _stands(
    known: Sequence[KnownFace],
    patch: Patch,
    way: Floats,
    rim: _Rim,
    step: float,
    config: RiserConfig,
) -> bool:
    """Whether a known face is crossed on the way, half way up or down: into it going up, out of it going down.

    Blur lays touched places past an edge: it may stand as far on as where the face behind has surely begun.  That
    of a pyramid is crossed between where its top ends and where its foot begins.  Who goes up from the floor of a
    round hole comes to its wall, wherever the face above begins.
    """
    if step > 0.0 and patch.in_round_hole(known):
        return True
    (at, _, begun), side = rim, float(np.sign(step))
    near = at - config.past, max(at + config.behind, min(begun, at + config.past))
    far = at - config.past, max(at, begun) + config.behind
    leaning = [own for own in known if _leans(own, patch.normal, config)]
    return patch.enters(known, way, near, 0.5 * step, side) or patch.enters(
        leaning, way, far, 0.5 * step, side
    )


def _leans(own: KnownFace, normal: Floats, config: RiserConfig) -> bool:
    """Whether a flat face is neither level nor upright, so that it may reach from a foot to a top far aside."""
    lean = abs(float(own.fit.shape.direction @ normal)) if own.fit.kind == "plane" else 0.0
    return config.upright < lean < config.alike


def _ways(known: Sequence[KnownFace]) -> Floats:
    """(n, 3) directions of the object's flat faces and axes, those of most contacts first."""
    out: list[Floats] = []
    for own in sorted(known, key=lambda k: -len(k.face.contacts)):
        way = getattr(own.fit.shape, "direction", None)
        if way is not None and all(abs(float(way @ other)) < 0.995 for other in out):
            out.append(np.asarray(way))
    return np.array(out).reshape(-1, 3)
