"""A face that curves away from the pad, seen as a flat one: what curves away is given back.

Beside a straight or bent edge, with v along and t inside it, a face of curvatures k and m is felt as deep as

    (A - k v^2 / 2 - m t^2 / 2) edge(t / w),

to first order in the blur; times A / (A - k v^2 / 2 - m t^2 / 2), its noise too, it is a flat face's.  Without
that, its depth's falling off along the edge passes for the edge's bend.
"""

from dataclasses import replace

import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.followed import Expected
from primitives.arrays import Floats, frozen

MOST = 2.5  # times, beyond which too little is felt


def flattened(
    image: TactileImage, edge: Expected, depth: float, curvatures: tuple[float, float]
) -> TactileImage:
    """The image of a face `depth` [mm] deep at its edge; `curvatures` [1/mm] are along the edge and across it."""
    if not any(curvatures):
        return image
    gain = _gain(image, edge, depth, curvatures)
    known = gain < MOST
    kept = np.where(known, gain, 1.0)
    return replace(
        image, depth=frozen(image.depth * kept), sigma=frozen(np.where(known, image.sigma * kept, np.inf))
    )


def _gain(image: TactileImage, edge: Expected, depth: float, curvatures: tuple[float, float]) -> Floats:
    rows, columns = image.array.shape
    px, py = image.array.pitch
    x = (np.arange(columns) - 0.5 * (columns - 1)) * px
    y = (np.arange(rows)[:, None] - 0.5 * (rows - 1)) * py
    ca, sa = np.cos(edge.angle), np.sin(edge.angle)
    along = ca * x + sa * y
    across = np.maximum(edge.side * (ca * y - sa * x - edge.offset), 0.0)
    left = depth - 0.5 * (curvatures[0] * along**2 + curvatures[1] * across**2)
    gain: Floats = depth / np.maximum(left, 1e-3 * depth)
    return gain
