"""Which points of an object an array can press: somewhere on its pad, with the housing clear of the object.

The pad lies in the tangent plane, the point under its middle, an edge or a corner, turned two ways; the skin may
be pressed by as much as its rubber gives, and housing and arm behind it, a straight column as wide as the housing,
may hold no material (our derivation).  The clearance is asked of the distance field, so it is good to half a cell.
"""

from __future__ import annotations

import numpy as np

from exploration.sensing.spec import SensorSpec
from models.library import Entry
from primitives.arrays import Bools, Floats
from primitives.pose import frame_along

_COLUMN = (2.0, 15.0, 50.0, 120.0)  # [mm] behind the housing's face where clearance is asked


def touchable(entry: Entry, points: Floats, normals: Floats, sensor: SensorSpec) -> Bools:
    """(n,) whether each of (n, 3) points with outward normals can be pressed."""
    array, housing = sensor.array, sensor.housing
    pad = np.array([array.columns * array.pitch[0], array.rows * array.pitch[1]]) / 2
    wide = np.maximum(np.array(housing.size[:2]) / 2, pad)
    give = sensor.elastomer.thickness
    slack = 0.5 * entry.field.spacing
    out = np.zeros(len(points), dtype=bool)
    for k, (point, normal) in enumerate(zip(points, normals, strict=True)):
        out[k] = _fits(entry, point, frame_along(normal), pad, wide, (housing.proud, give, slack))
    return out


_SIDES = np.array([(x, y) for x in (-1.0, 0.0, 1.0) for y in (-1.0, 0.0, 1.0)])


def _fits(
    entry: Entry, point: Floats, frame: Floats, pad: Floats, wide: Floats, depth: tuple[float, float, float]
) -> bool:
    proud, give, slack = depth
    x, y, z = frame.T
    across = np.concatenate([_SIDES * pad, _SIDES[:, ::-1] * pad[::-1]]) * 0.95
    turned = np.repeat([False, True], len(_SIDES))
    for offset, swap in zip(across, turned, strict=True):
        middle = point + offset[0] * x + offset[1] * y
        u, v = (y, x) if swap else (x, y)
        skin = middle + (_SIDES * pad) @ np.stack([u, v])
        if (entry.field.signed_distance(skin) < -give - slack).any():
            continue
        column = np.concatenate(
            [middle + (_SIDES * wide) @ np.stack([u, v]) + (proud + h) * z for h in _COLUMN]
        )
        if (entry.field.signed_distance(column) > -slack).all():
            return True
    return False
