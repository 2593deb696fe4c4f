"""Whether an object is small for the arrays that felt it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exploration.sensing.spec import SensorSpec
from primitives.arrays import Floats

_FEW = 30  # contacts, of which less do not tell how large an object is
_SMALL = 0.75  # of the pad's longer side: an object that is no longer lies under it whole, edges and all,
_TAXELS = 16.0  # and with fewer taxels along it, what they show of it is a handful each of faces and edges


def small_for(points: Floats, specs: Sequence[SensorSpec]) -> list[str]:
    """A warning where all the (n, 3) contacts [mm] lie closer together than the widest of the pads is long."""
    if len(points) < _FEW:
        return []
    spec = max(specs, key=lambda s: max(s.array.size))
    about = points - points.mean(axis=0)
    along = np.sort(np.ptp(about @ np.linalg.svd(about, full_matrices=False)[2].T, axis=0))
    longest, broad = float(along[-1]), float(along[-2])
    if longest >= _SMALL * max(spec.array.size) or broad >= min(spec.array.size):
        return []
    if longest >= _TAXELS * max(spec.array.pitch):
        return []
    x, y = spec.array.size
    return [
        f"all that was touched lies within {longest:.2g} mm, under one pad of {spec.name} ({x:.3g} x {y:.3g} mm): "
        "it blurs such small faces and edges into each other: trust the model less, and use an array of finer "
        "taxels (--sensor optical)"
    ]
