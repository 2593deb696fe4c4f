"""Where to look for an object of unknown place: parallel sweeps through the workspace, from its middle outward."""

from collections.abc import Iterator, Sequence

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
    for x, y in middle[:2] + grid[np.argsort(np.linalg.norm(grid, axis=1), kind="stable")]:
        yield _down(x, y, high[2]), _down(x, y, low[2])


def deepening_sweeps(
    box: Floats, pad: tuple[float, float], feature: float = 10.0
) -> Iterator[tuple[Floats, Floats]]:
    """The same sweeps, those near the middle first and no deeper than they are far out: box in box in box.

    The inner ones have a quarter and half of the (6,) `box`'s sides [mm] and its middle; all come from the top of
    the whole.  A later sweep at the same place begins where the one before it ended: above that it is free.
    Our derivation: an object stands nearer to the middle of its workspace than to the bottom.
    """
    lines = list(sweeps(box, pad, feature))
    middle = (box[:3] + box[3:]) / 2
    reached = [float(box[5])] * len(lines)
    for share in (0.25, 0.5, 1.0):
        bottom = middle[2] - share * (middle[2] - box[2])
        within = share * (box[3:5] - box[:2]) / 2 + np.asarray(pad) / 2
        for k, (start, _) in enumerate(lines):
            x, y = start[:2, 3]
            if share == 1.0 or (np.abs([x, y] - middle[:2]) <= within).all():
                yield _down(x, y, reached[k]), _down(x, y, bottom)
                reached[k] = bottom


def beside_first(
    left: Sequence[tuple[Floats, Floats]], place: Floats, within: float = 60.0
) -> list[tuple[Floats, Floats]]:
    """Sweeps, first those down past a (3,) place `within` mm of it, nearest first; the others as they were.

    One that goes on where another ended stays behind that.
    """

    def away(sweep: tuple[Floats, Floats]) -> float:
        begin = sweep[0][:3, 3]
        far = float(np.linalg.norm(begin[:2] - place[:2]))
        return far if begin[2] >= place[2] and far < within else np.inf

    return sorted(left, key=away)


def not_below(
    left: Sequence[tuple[Floats, Floats]], place: Floats, within: float = 1.0
) -> list[tuple[Floats, Floats]]:
    """Sweeps without those that go on below a (3,) place [mm] where one was stopped."""
    return [
        (start, end)
        for start, end in left
        if float(np.linalg.norm(start[:2, 3] - place[:2])) > within or start[2, 3] > place[2]
    ]


def from_above(here: Floats, start: Floats, top: float) -> list[Floats]:
    """(4, 4) stops from here straight up to a height [mm], over the (4, 4) start of a sweep, and down to it."""
    high = max(top, float(here[2, 3]))
    return [*(se3.pose(start[:3, :3], [x, y, high]) for x, y in (here[:2, 3], start[:2, 3])), start]


def _down(x: float, y: float, z: float) -> Floats:
    """(4, 4) pose of a pad that faces down."""
    return se3.pose(np.diag([1.0, -1.0, -1.0]), [x, y, z])
