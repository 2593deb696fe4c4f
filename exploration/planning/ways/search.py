"""Where to look for an object of unknown place: parallel sweeps through the workspace, from its middle outward."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from primitives import pose as se3
from primitives.arrays import Floats, Ints


@dataclass(frozen=True)
class Pass:
    """One going over a box; shares are of half its sides, from its middle."""

    wide: float  # share that its lines lie within
    deep: float  # share below the middle that they end at
    apart: float  # share of the box's sides between them, or as little as leaves no gap


PASSES = (Pass(0.1, 0.15, 0.0), Pass(0.7, 0.6, 1 / 8), Pass(1.0, 1.0, 1 / 16), Pass(1.0, 1.0, 0.0))


def sweeps(box: Floats, pad: tuple[float, float], feature: float = 10.0) -> Iterator[tuple[Floats, Floats]]:
    """Start and end (4, 4) poses of downward sweeps through a (6,) box [mm] with a pad of (x, y) size [mm].

    They go from the middle outward.  Their spacing is such that of an object `feature` mm across no more than two
    thirds pass between them.
    """
    cells, spacing = _cells(box, pad, feature)
    for x, y in _middle(box)[:2] + cells * spacing:
        yield _down(x, y, box[5]), _down(x, y, box[2])


def coarse_first(
    box: Floats, pad: tuple[float, float], feature: float = 10.0, standing: bool = False
) -> Iterator[tuple[Floats, Floats]]:
    """The same sweeps: near the middle of the (6,) box [mm] first, then far apart, then those between.

    An object is mostly wider than the smallest that must not be missed, and nearer to the middle than to the
    bottom, unless it is `standing` there: then each sweep goes all the way.  All come from the top; a later one
    at the same place begins where the one before it ended, for above that it is free.  Our derivation: `PASSES`
    by the mean time until the pad comes to an object, near the middle, at any distance from it alike, anywhere.
    """
    cells, spacing = _cells(box, pad, feature)
    middle, half = _middle(box), (box[3:] - box[:3]) / 2
    reached = np.full(len(cells), box[5])
    for goes in PASSES:
        stride = np.maximum(np.round(goes.apart * 2 * half[:2] / spacing), 1).astype(int)
        bottom = box[2] if standing else middle[2] - goes.deep * half[2]
        beside = np.abs(cells * spacing) <= goes.wide * half[:2] + np.asarray(pad) / 2
        due = (
            (cells % stride == 0).all(axis=1) & (beside.all(axis=1) | (goes.wide == 1.0)) & (reached > bottom)
        )
        for k in np.flatnonzero(due):
            x, y = middle[:2] + cells[k] * spacing
            yield _down(x, y, reached[k]), _down(x, y, bottom)
            reached[k] = bottom


def _cells(box: Floats, pad: tuple[float, float], feature: float) -> tuple[Ints, Floats]:
    """(n, 2) steps from the middle, nearest first, and (2,) [mm] of one."""
    spacing = np.asarray(pad) + 2.0 * feature / 3.0
    count = np.maximum(np.ceil((box[3:5] - box[:2]) / spacing / 2).astype(int), 0)
    cells = np.stack(np.meshgrid(*(np.arange(-n, n + 1) for n in count), indexing="ij"), axis=-1).reshape(
        -1, 2
    )
    return cells[np.argsort(np.linalg.norm(cells * spacing, axis=1), kind="stable")], spacing


def _middle(box: Floats) -> Floats:
    return np.asarray((box[:3] + box[3:]) / 2)


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
