"""Points that the pad felt, as contacts in the world."""

import numpy as np

from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.pose import rotate, transform_points


def in_world(
    xy: Floats,
    depth: Floats,
    slope: Floats,
    sigma: float | Floats,
    normal_sigma: float | Floats,
    world_from_sensor: Floats,
    touch: int,
    stroke: int,
    sensor: int,
) -> Contacts:
    """Contacts at (n, 2) places of the pad [mm], pressed (n,) `depth` deep, of (n, 2) `slope`; normals out."""
    outward = np.column_stack([-slope, -np.ones(len(xy))])
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    return Contacts.of(
        transform_points(world_from_sensor, np.column_stack([xy, -depth])),
        rotate(world_from_sensor, outward),
        sigma,
        normal_sigma,
        touch,
        stroke,
        sensor,
    )
