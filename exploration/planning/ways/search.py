"""Where to look for an object of unknown place: parallel sweeps through the workspace, from its middle outward."""

from collections.abc import Iterator

import numpy as np

from primitives import pose as se3
from primitives.arrays import Floats


def sweeps(box: Floats, pad: tuple[float, float], feature: float = 10.0) -> Iterator[tuple[Floats, Floats]]:
    """Start and end (4, 4) poses of downward sweeps through a (6,) box [mm] with a pad of (x, y) size [mm].

    Their spacing is such that of an object `feature` mm across no more than two thirds pass between them.
    """
    low, high = box[:3], box[3:]
    middle = (low + high) / 2
    spacing = np.asarray(pad) + 2.0 * feature / 3.0
    count = np.maximum(np.ceil((high[:2] - low[:2]) / spacing / 2).astype(int), 0)
    steps = [np.arange(-n, n + 1) * d for n, d in zip(count, spacing, strict=True)]
    grid = np.stack(np.meshgrid(*steps, indexing="ij"), axis=-1).reshape(-1, 2)
    facing_down = np.diag([1.0, -1.0, -1.0])
    for x, y in middle[:2] + grid[np.argsort(np.linalg.norm(grid, axis=1), kind="stable")]:
        yield (
            se3.pose(facing_down, [x, y, high[2]]),
            se3.pose(facing_down, [x, y, low[2]]),
        )
