"""Tactile edges as a problem of vision, after Muthukrishnan and others: median, mean threshold, edge operator.

A 3 x 3 median is applied until nothing changes (or `PASSES` times: a median may alternate for ever); what is above
the image's mean is on; the edge operator marks where on meets off.  Edges are then extracted by

- following contours: the marks in order along each outline, split where they leave the chord by more than
  `tolerance` (Ramer 1972), a least-squares line through each piece; or
- Burns's lines (see `burns`).

A mark lies half way between an on and an off taxel, and none lies on the pad's rim, where contact ends for want of
taxels.
"""

from dataclasses import dataclass
from itertools import pairwise

import numba
import numpy as np

from exploration.sensing.baselines.picture import contrast, line_through
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line import Line
from primitives.arrays import Bools, Floats, Ints

PASSES = 20
_TURNS = np.array([[0, 1], [1, 0], [0, -1], [-1, 0]])  # right, down, left, up: (row, column)


@dataclass(frozen=True)
class ContourConfig:
    """How outlines become lines."""

    tolerance: float = 2.5  # [taxels] off the chord; steps of whole taxels must not split an edge
    fewest: int = 4  # marks in a line


def contour_lines(
    image: TactileImage, most: int = 3, config: ContourConfig | None = None
) -> tuple[Line, ...]:
    """By following contours; those of most marks first."""
    config = config or ContourConfig()
    on = silhouette(image)
    if on is None:
        return ()
    pieces = [
        piece
        for chain in outlines(on)
        for piece in _pieces(chain, config.tolerance)
        if len(piece) >= config.fewest
    ]
    pieces.sort(key=len, reverse=True)
    lines = [_fitted(image, piece) for piece in pieces[:most]]
    return tuple(line for line in lines if line is not None)


def silhouette(image: TactileImage) -> Bools | None:
    """(rows, columns) what is above the mean of the median-filtered frame; None out of contact."""
    share = contrast(image)
    if share is None:
        return None
    smooth = settled(share)
    return np.asarray(smooth > smooth.mean())


@numba.njit(cache=True)
def settled(depth: Floats) -> Floats:
    """The 3 x 3 median again and again until nothing changes; at the rim, of the taxels that are there."""
    rows, columns = depth.shape
    now = depth.copy()
    window = np.empty(9)
    for _ in range(PASSES):
        new = np.empty_like(now)
        for i in range(rows):
            for j in range(columns):
                n = 0
                for a in range(max(0, i - 1), min(rows, i + 2)):
                    for b in range(max(0, j - 1), min(columns, j + 2)):
                        window[n] = now[a, b]
                        n += 1
                new[i, j] = np.median(window[:n])
        if np.array_equal(new, now):
            break
        now = new
    return now


def outlines(on: Bools) -> list[Floats]:
    """Chains (n, 2) of marks (column, row) between on and off taxels, in order along each outline."""
    marks, starts = _follow(np.asarray(on))
    bounds = [*starts.tolist(), len(marks)]
    return [marks[a:b] for a, b in pairwise(bounds) if b > a]


@numba.njit(cache=True)
def _follow(on: Bools) -> tuple[Floats, Ints]:
    """Walk along each border with the on taxels to the right; a chain breaks where the border leaves the pad."""
    rows, columns = on.shape
    seen = np.zeros((rows, columns, 4), dtype=np.bool_)
    marks = np.empty((4 * rows * columns, 2))
    starts = np.empty(4 * rows * columns, dtype=np.int64)
    n = chains = 0
    for rim_first in (True, False):
        for i0 in range(rows):
            for j0 in range(columns):
                for d0 in range(4):
                    if seen[i0, j0, d0] or not _faces_off(on, i0, j0, d0):
                        continue
                    if rim_first and _faces_off_before(on, i0, j0, d0):
                        continue
                    starts[chains] = n
                    chains += 1
                    i, j, d = i0, j0, d0
                    while _faces_off(on, i, j, d) and not seen[i, j, d]:
                        seen[i, j, d] = True
                        marks[n, 0] = j + 0.5 * _TURNS[d, 1]
                        marks[n, 1] = i + 0.5 * _TURNS[d, 0]
                        n += 1
                        i, j, d = _next(on, i, j, d)
    return marks[:n], starts[:chains]


@numba.njit(cache=True)
def _is_on(on: Bools, i: int, j: int) -> bool:
    return bool(0 <= i < on.shape[0] and 0 <= j < on.shape[1] and on[i, j])


@numba.njit(cache=True)
def _faces_off(on: Bools, i: int, j: int, d: int) -> bool:
    """Whether taxel (i, j) is on and its neighbor in direction d is on the pad and off."""
    a, b = i + _TURNS[d, 0], j + _TURNS[d, 1]
    return bool(_is_on(on, i, j) and 0 <= a < on.shape[0] and 0 <= b < on.shape[1] and not on[a, b])


@numba.njit(cache=True)
def _next(on: Bools, i: int, j: int, d: int) -> tuple[int, int, int]:
    """The border side after side d of (i, j): round the corner clockwise."""
    e = (d + 1) % 4
    a, b = i + _TURNS[e, 0], j + _TURNS[e, 1]
    if not _is_on(on, a, b):
        return i, j, e
    if _is_on(on, a + _TURNS[d, 0], b + _TURNS[d, 1]):
        return a + _TURNS[d, 0], b + _TURNS[d, 1], (d + 3) % 4
    return a, b, d


@numba.njit(cache=True)
def _faces_off_before(on: Bools, i: int, j: int, d: int) -> bool:
    """Whether the side before d of (i, j), counterclockwise, is a mark too."""
    e = (d + 3) % 4
    a, b = i + _TURNS[e, 0], j + _TURNS[e, 1]
    if not _is_on(on, a, b):
        return bool(_faces_off(on, i, j, e))
    if _is_on(on, a + _TURNS[d, 0], b + _TURNS[d, 1]):
        return bool(_faces_off(on, a + _TURNS[d, 0], b + _TURNS[d, 1], (d + 1) % 4))
    return bool(_faces_off(on, a, b, d))


def _pieces(chain: Floats, tolerance: float) -> list[Floats]:
    """Split where the chain is farthest from its chord, until all is near."""
    if len(chain) < 3:
        return [chain]
    chord = chain[-1] - chain[0]
    length = float(np.hypot(*chord))
    away = chain - chain[0]
    off = (
        np.abs(away[:, 0] * chord[1] - away[:, 1] * chord[0]) / length if length > 1.0 else np.hypot(*away.T)
    )
    at = int(np.argmax(off))
    if off[at] <= tolerance or at in (0, len(chain) - 1):
        return [chain]
    return _pieces(chain[: at + 1], tolerance) + _pieces(chain[at:], tolerance)


def _fitted(image: TactileImage, marks: Floats) -> Line | None:
    """The total least-squares line of marks."""
    center = marks.mean(axis=0)
    along = np.linalg.svd(marks - center, full_matrices=False)[2][0]
    return line_through(image, center, center + along, float(len(marks)))
