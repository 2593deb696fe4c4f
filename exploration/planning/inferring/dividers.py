"""Ribs and dividers that stand on a floor, inferred where one stroke was stopped and the floor goes on behind.

One stop tells neither how a wall lies nor how far it goes.  Where the floor was felt up to it and again behind
it, side by side over some width, and nowhere in between, what stands there goes all along; its far side is where
strokes from behind were stopped, else half way to where the floor begins again (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from exploration.planning.inferring.patch import Patch
from exploration.planning.open.known_face import KnownFace
from exploration.planning.touching.stops import Stop
from primitives.arrays import Bools, Floats
from primitives.evidence import NOT_FELT, Contacts


@dataclass(frozen=True)
class DividerConfig:
    """What counts as a floor on either side of one thing."""

    flush: float = 0.98  # least cosine between a stopped pad's normal and the floor's
    lay: float = 1.5  # [mm] of the pad from the floor
    thick: tuple[float, float] = (1.5, 12.0)  # [mm] from the stop to where the floor begins again
    near: float = 12.0  # [mm] before and behind, within which the floor was felt
    wide: float = 20.0  # [mm] side by side, at least
    parts: int = 3  # of that width, in each of which the floor was felt before and behind
    alike: float = 0.98  # least cosine between the way that was stopped and that of a stroke from behind
    within: float = 0.3  # [mm] past the stop at most, where a place still is of the floor before it
    height: tuple[float, float] = (2.0, 5.0)  # [mm] over the floor, where housings are stopped
    sigma: float = 0.3  # [mm] at least
    normal_sigma: float = 0.05  # [rad]


def dividers(
    known: Sequence[KnownFace], stops: Sequence[Stop], config: DividerConfig = DividerConfig()
) -> Iterator[Contacts]:
    """Contacts of each side that is missing, as if felt where housings would have been stopped."""
    for floor in known:
        if floor.fit.kind != "plane" or not (floor.face.contacts.touch != NOT_FELT).any():
            continue
        normal = floor.side * floor.fit.shape.direction
        mine = [stop for stop in stops if _on(floor, normal, stop, config)]
        for stop in mine:
            yield from _sides(floor, normal, stop, known, mine, config)


def _on(floor: KnownFace, normal: Floats, stop: Stop, config: DividerConfig) -> bool:
    """Whether a pad lay on a floor when it was stopped."""
    off = abs(float(normal @ (stop.wall.pose[:3, 3] - floor.fit.shape.anchor)))
    return off < config.lay and float(normal @ stop.wall.normal) > config.flush


def _sides(
    floor: KnownFace,
    normal: Floats,
    stop: Stop,
    known: Sequence[KnownFace],
    stops: Sequence[Stop],
    config: DividerConfig,
) -> Iterator[Contacts]:
    """Both sides of what stopped a stroke; `stops` are those on this floor."""
    way, at, along = -stop.normal, -stop.offset, np.cross(normal, -stop.normal)
    gap = _gap(floor.cells @ way - at, floor.cells @ along, config)
    if gap is None or not gap.beside(stop, along):
        return
    met = [
        other.offset
        for other in stops
        if float(other.normal @ way) > config.alike
        and 0.0 < other.offset - at < gap.wide
        and gap.beside(other, along)
    ]
    far = float(np.median(met)) if met else at + 0.5 * gap.wide
    unsure = config.sigma if met else max(config.sigma, gap.wide / np.sqrt(12.0))
    level = float(normal @ floor.fit.shape.anchor)
    patch = Patch(floor, floor.cells[gap.before], normal)
    for place, into, sigma in ((at, 1.0, config.sigma), (far, -1.0, unsure)):
        span = (place - config.thick[0], place + config.thick[0])
        if patch.enters(known, way, span, config.height[1], into):
            continue
        across = np.linspace(gap.low, gap.high, 3)[:, None, None] * along
        up = (level + np.array(config.height))[:, None] * normal
        points = (place * way + across + up).reshape(-1, 3)
        looks = np.tile(-into * way, (len(points), 1))
        yield Contacts.of(points, looks, sigma, config.normal_sigma, touch=NOT_FELT)


class _Gap(NamedTuple):
    """A strip of a floor where it was not felt, from a stop on."""

    low: float  # [mm] along it
    high: float
    wide: float  # [mm]
    before: Bools  # (n,) places of the floor right before it

    def beside(self, stop: Stop, along: Floats) -> bool:
        """Whether a stroke was stopped between its ends."""
        return self.low < float(stop.wall.pose[:3, 3] @ along) < self.high


def _gap(depth: Floats, beside: Floats, config: DividerConfig) -> _Gap | None:
    """Where a floor goes on, at (n,) [mm] behind a stop and along what stopped it."""
    before = (depth < config.within) & (depth > -config.near)
    behind = depth >= config.within
    if not before.any() or not behind.any():
        return None
    wide = float(depth[behind].min())
    behind &= depth < wide + config.near
    low = max(float(beside[side].min()) for side in (before, behind))
    high = min(float(beside[side].max()) for side in (before, behind))
    if high - low < config.wide or not config.thick[0] < wide < config.thick[1]:
        return None
    edges = np.linspace(low, high, config.parts + 1)
    felt = all(np.histogram(beside[side], edges)[0].min() > 0 for side in (before, behind))
    return _Gap(low, high, wide, before) if felt else None
