"""The one clearance check: how far the housing behind a skin is from a surface.

The box is sampled on its six faces; the clearance is the least signed distance of the samples, so a feature
narrower than the sample spacing may reach up to half that spacing closer.
"""

from functools import lru_cache

import numpy as np

from exploration.sensing.spec import SensorSpec
from primitives.arrays import Floats, frozen
from primitives.pose import transform_points
from primitives.surface import Surface

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
