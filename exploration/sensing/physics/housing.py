"""The one clearance check: how far the housing behind a skin is from a surface, and whether they overlap.

For any surface the box is sampled on its six faces; the clearance is the least signed distance of the samples, so
a feature narrower than the sample spacing may reach up to half that spacing closer.  Triangles are clipped to the
box, which finds every overlap; `HousingWatch` looks again only after the sensor has moved by the gap it found.
"""

from functools import lru_cache

import numpy as np
from numba import njit

from exploration.sensing.physics.coverage import clip
from exploration.sensing.physics.facets import NearFacets, facets_of
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Floats, Ints, frozen
from primitives.pose import transform_points
from primitives.surface import Surface, TriangleSurface

_SPACING = 4.0  # [mm] at most, between samples


def clearance(surface: Surface, world_from_sensor: Floats, spec: SensorSpec) -> float:
    """Least signed distance [mm] of the housing to a surface; negative when they overlap."""
    return float(surface.signed_distance(transform_points(world_from_sensor, housing_samples(spec))).min())


def housing_box(spec: SensorSpec) -> tuple[Floats, Floats]:
    """Least and greatest corner (3,) [mm] of the housing in the sensor frame."""
    x, y, z = spec.housing.size
    return np.array([-x / 2, -y / 2, -spec.housing.proud - z]), np.array([x / 2, y / 2, -spec.housing.proud])


@lru_cache(maxsize=32)
def housing_samples(spec: SensorSpec) -> Floats:
    """(n, 3) points [mm] all over the housing, in the sensor frame."""
    low, high = housing_box(spec)
    counts = np.maximum(2, np.ceil((high - low) / _SPACING).astype(int) + 1)
    axes = [np.linspace(a, b, n) for a, b, n in zip(low, high, counts, strict=True)]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    return frozen(grid[((grid == low) | (grid == high)).any(axis=1)])


class HousingWatch:
    """One housing near one surface, pose after pose."""

    def __init__(self, surface: Surface, spec: SensorSpec) -> None:
        self._surface, self._spec = surface, spec
        self._low, self._high = housing_box(spec)
        self._reach = float(np.linalg.norm(np.maximum(-self._low, self._high)))
        self._near: NearFacets | None = None
        if isinstance(surface, TriangleSurface):
            radius = float(np.linalg.norm(self._high - self._low)) / 2
            self._near = NearFacets(facets_of(surface), radius)
        self._room = (
            np.zeros((2, int(np.diff(self._near.all.start).max(initial=0)) + 12, 3))
            if self._near
            else np.zeros((2, 12, 3))
        )
        self._seen_from: Floats | None = None
        self._gap = 0.0

    def overlap(self, world_from_sensor: Floats) -> float:
        """How deep the surface reaches into the housing [mm]; 0 where it does not."""
        if self._seen_from is not None and moved(self._seen_from, world_from_sensor, self._reach) < self._gap:
            return 0.0
        self._seen_from = world_from_sensor
        if self._near is None:
            self._gap = clearance(self._surface, world_from_sensor, self._spec)
            return max(0.0, -self._gap)
        center = world_from_sensor[:3, :3] @ ((self._low + self._high) / 2) + world_from_sensor[:3, 3]
        self._gap = min(self._near.around(center[0], center[1], center[2]), self._near.slack)
        near = self._near.facets
        if len(near.normals) == 0:
            return 0.0
        depth, gap = _overlap(world_from_sensor, self._low, self._high, near.start, near.loop, self._room)
        self._gap = min(self._gap, gap)
        return float(depth)


@njit(cache=True, error_model="numpy")
def moved(before: Floats, now: Floats, reach: float) -> float:
    """The most that any point within `reach` [mm] of a frame's origin has moved."""
    shift = swing = 0.0
    for i in range(3):
        shift += (now[i, 3] - before[i, 3]) ** 2
        for j in range(3):
            swing += (now[i, j] - before[i, j]) ** 2
    return float(np.sqrt(shift) + reach * np.sqrt(swing))


@njit(cache=True, error_model="numpy")
def _overlap(
    pose: Floats, low: Floats, high: Floats, start: Ints, loop: Floats, room: Floats
) -> tuple[float, float]:
    """Depth of the deepest facet in the box, and a distance within which there is none otherwise."""
    p, spare = room[0], room[1]
    deepest, nearest = 0.0, np.inf
    for f in range(len(start) - 1):
        count = start[f + 1] - start[f]
        for i in range(count):
            v = loop[start[f] + i]
            dx, dy, dz = v[0] - pose[0, 3], v[1] - pose[1, 3], v[2] - pose[2, 3]
            for k in range(3):
                p[i, k] = pose[0, k] * dx + pose[1, k] * dy + pose[2, k] * dz
        away = 0.0
        for k in range(3):
            least = most = p[0, k]
            for i in range(1, count):
                least, most = min(least, p[i, k]), max(most, p[i, k])
            away += max(0.0, least - high[k], low[k] - most) ** 2
        if away > 0.0:
            nearest = min(nearest, np.sqrt(away))
            continue
        for k in range(3):
            count = clip(p, count, spare, k, 1.0, high[k])
            count = clip(p, count, spare, k, -1.0, -low[k]) if count >= 3 else 0
            if count < 3:
                break
        nearest = 0.0
        if count < 3:
            continue
        for k in range(3):
            spare[0, k] = p[:count, k].mean()
        for i in range(-1, count):
            corner = spare[0] if i < 0 else p[i]
            inside = np.inf
            for k in range(3):
                inside = min(inside, high[k] - corner[k], corner[k] - low[k])
            deepest = max(deepest, inside)
    return deepest, nearest
