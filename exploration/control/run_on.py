"""A run of ticks, run on at its ends by what other ticks saw of the same edge there.

Where a curve begins and ends it is drawn from one side only, and a smoothing spline ends unbent.  Where an outline
closes it has no ends: the ticks that came by its start at last lie before its first, and those that left the start
lie after its last.  A stretch that was followed twice stays seen twice: by how much the two differ there tells how
well the outline closes.
"""

from collections.abc import Sequence

import numpy as np

from exploration.control.edge_ticks import EdgeTick, Ticks
from primitives.arrays import Floats

ON = 15.0  # [mm] that an end is run on by
NEAR = 6.0  # [mm] of an end, within which others come by it,
SAME_WAY = 0.8  # and least cosine between the directions


def leading_to(ticks: Sequence[EdgeTick], end: EdgeTick) -> list[EdgeTick]:
    """The ticks before the last place in which they come by `end`."""
    return _beside(ticks, end, -1)


def leading_from(ticks: Sequence[EdgeTick], end: EdgeTick) -> list[EdgeTick]:
    """The ticks after the first place in which they come by `end`."""
    return _beside(ticks, end, 1)


def _beside(ticks: Sequence[EdgeTick], end: EdgeTick, way: int) -> list[EdgeTick]:
    rows = Ticks.of(ticks)
    if len(rows) < 2:
        return []
    travel = rows.travel
    place = _comes_by(rows.points - end.point, rows.tangents @ end.tangent, end.tangent, travel, way)
    if place is None:
        return []
    on = way * (travel - place)
    return [ticks[k] for k in np.flatnonzero((on > 0.0) & (on < ON)).tolist()]


def _comes_by(off: Floats, cosines: Floats, along: Floats, travel: Floats, way: int) -> float | None:
    """[mm] of travel at which places (n, 3) `off` an end pass it: at last, or at first for a `way` of 1."""
    past = off @ along
    there = np.flatnonzero((np.einsum("ij,ij->i", off, off) < NEAR**2) & (cosines > SAME_WAY))
    if not len(there):
        return None
    there = there[np.abs(travel[there] - travel[there[0 if way > 0 else -1]]) < 2.0 * NEAR]
    if not past[there].min() <= 0.0 < past[there].max():
        return None
    order = there[np.argsort(past[there])]
    return float(np.interp(0.0, past[order], travel[order]))
