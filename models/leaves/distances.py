"""What the primitives share: checked lengths, and distances to a box's sides and to a segment."""

import numpy as np

from primitives.arrays import Floats
from primitives.errors import PalpateError


def positive_length(value: float, what: str) -> float:
    """The value as a float; an error that names `what` unless it is a positive length [mm]."""
    length = float(value)
    if not (np.isfinite(length) and length > 0):
        raise PalpateError(f"{what} must be a positive length in mm, not {value!r}")
    return length


def box_distance(beyond: Floats) -> Floats:
    """(n,) distance of a product of shapes, from (n, k) signed distances in orthogonal directions."""
    outside = np.linalg.norm(np.maximum(beyond, 0.0), axis=1)
    distance: Floats = outside + np.minimum(beyond.max(axis=1), 0.0)
    return distance


def segment_distance(q: Floats, a: Floats, b: Floats) -> Floats:
    """(n,) distance of (n, 2) points from the segment a to b."""
    along = b - a
    length = float(along @ along)
    share = np.clip((q - a) @ along / length, 0.0, 1.0) if length > 0 else np.zeros(len(q))
    distance: Floats = np.linalg.norm(q - a - share[:, None] * along, axis=1)
    return distance
