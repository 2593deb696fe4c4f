"""Inner sides of thin walls, inferred where none was felt: those of an open box, a channel or a cup.

The array lay on a floor, so the space over the floor is free as far as it came; the outer side beyond that was
felt higher than the floor, so there is material behind it.  In between stands a side that looks back over the
floor: where strokes were stopped there, else half way, as surely as the two are near (our derivation).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from exploration.planning.inferring.patch import Patch
from exploration.planning.known.surface_map import clusters
from exploration.planning.open.known_face import KnownFace
from exploration.planning.touching.stops import Stop
from primitives.evidence import NOT_FELT, Contacts


@dataclass(frozen=True)
class ThinWallConfig:
    """What counts as a floor with a wall beside it."""

    least: int = 4  # touched places of a floor, and of the outer side that is higher
    cluster: float = 8.0  # [mm] between neighboring places of one floor
    upright: float = 0.03  # most cosine between the normals of floor and outer side
    higher: float = 4.0  # [mm] over the floor, where the outer side was felt
    across: float = 0.1  # of a floor's places, on either hand, that lie beside what is looked at
    thick: tuple[float, float] = (0.8, 12.0)  # [mm] from the floor's last place to the outer side
    alike: float = 0.98  # least cosine between the way out and that of a stroke's stop
    lay: float = 1.5  # [mm] of a pad that was stopped, from the floor
    before: float = 2.0  # [mm] before the floor's last place, from which a side may stand
    sigma: float = 0.3  # [mm] at least
    normal_sigma: float = 0.05  # [rad]


def thin_walls(
    known: Sequence[KnownFace], stops: Sequence[Stop] = (), config: ThinWallConfig = ThinWallConfig()
) -> Iterator[Contacts]:
    """Contacts of each inner side that is missing, as if felt at a quarter and three quarters of its height."""
    flat = [
        own
        for own in known
        if own.fit.kind == "plane"
        and len(own.cells) >= config.least
        and (own.face.contacts.touch != NOT_FELT).any()
    ]
    for floor in flat:
        normal = floor.side * floor.fit.shape.direction
        for members in clusters(floor.cells, config.cluster):
            if members.sum() < config.least:
                continue
            patch = Patch(floor, floor.cells[members], normal)
            for outer in flat:
                if (lot := _inner_side(patch, outer, known, stops, config)) is not None:
                    yield lot


def _inner_side(
    patch: Patch,
    outer: KnownFace,
    known: Sequence[KnownFace],
    stops: Sequence[Stop],
    config: ThinWallConfig,
) -> Contacts | None:
    """What stands between a floor and an outer side, where they are near and no known face does."""
    way = outer.side * outer.fit.shape.direction
    if abs(float(way @ patch.normal)) > config.upright:
        return None
    along = np.cross(patch.normal, way)
    low, high = np.quantile(patch.cells @ along, [config.across, 1.0 - config.across])
    level = float(patch.middle @ patch.normal)
    height, where = outer.cells @ patch.normal - level, outer.cells @ along
    beside = outer.cells[(height > config.higher) & (where > low) & (where < high)]
    if len(beside) < config.least:
        return None
    last, end = patch.edge(way), float(np.median(beside @ way))
    top = float(np.quantile(beside @ patch.normal, 0.9)) - level
    if not config.thick[0] < end - last < config.thick[1]:
        return None
    if patch.enters(known, way, (last - config.before, end - config.thick[0]), 0.5 * top):
        return None
    met = [
        -stop.offset
        for stop in stops
        if float(stop.normal @ way) < -config.alike
        and last - config.before < -stop.offset < end
        and low < float(stop.wall.pose[:3, 3] @ along) < high
        and abs(float(stop.wall.pose[:3, 3] @ patch.normal) - level) < config.lay
    ]
    at = float(np.median(met)) if met else 0.5 * (last + end)
    sigma = config.sigma if met else max(config.sigma, (end - last) / np.sqrt(12.0))
    foot = at * way + level * patch.normal
    places = [foot + u * along + v * top * patch.normal for u in (low, 0.5 * (low + high), high) for v in _UP]
    return Contacts.of(
        np.array(places), np.tile(-way, (len(places), 1)), sigma, config.normal_sigma, touch=NOT_FELT
    )


_UP = (0.25, 0.75)  # of its height
