"""Ways to come at an object from afar, where nobody has looked yet.

What an array passes through is seen, and holds nothing.  A cell near what was felt that was not passed through may
hold anything.  A straight approach from outside sees every cell on its way until something that was felt stops it;
the approach that sees most of what is unseen comes first (compare next-best-view planning, Connolly 1985).  From
a side that nothing was felt from, or where what comes first was not, as the end of a post of which the flank is
known, it is worth one for less.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.spatial import ConvexHull, KDTree

from exploration.planning.known.swept_cells import SweptCells
from exploration.planning.open.view_kernel import looked_into
from primitives import pose as se3
from primitives.arrays import Floats


@dataclass(frozen=True)
class ViewsConfig:
    """What is worth an approach."""

    about: float = 10.0  # [mm] about the hull of what was felt, that is looked into
    beside: float = 5.0  # [mm] from a felt place, within which a cell is its surface
    step: float = 10.0  # [mm] between approaches that are compared
    deep: float = 10.0  # [mm] of unseen space, over the whole pad, that is worth an approach
    side: float = 3.0  # [mm] the same from a side that was not felt yet
    end: float = 1.0  # [mm] the same before an end that was not felt from that side
    first: float = 8.0  # [mm] behind the first felt place on the way, up to where what comes first reaches
    facing: float = 0.8  # least cosine of a felt place that shows a side
    few: int = 10  # felt places, below which a side was not felt
    slanting: float = 0.6  # worth of an approach between the object's axes
    coarse: float = 4.0  # [mm] between felt places that count


@dataclass(frozen=True)
class View:
    """One approach: where the pad heads, how it is turned, and the cells that nobody has seen on its way."""

    target: Floats  # (4, 4) on the pad's line, at the middle of what was felt
    unseen: Floats  # (n, 3) [mm]


def best_view(
    felt: Floats,
    facing: Floats,
    seen: SweptCells,
    half: Floats,
    axes: Floats,
    beside: Floats | None = None,
    config: ViewsConfig = ViewsConfig(),
) -> View | None:
    """Of an object felt at (n, 3) places that face (n, 3) ways, for a pad of (2,) `half` sizes [mm].

    The columns of (3, 3) `axes` are the object's own directions; at (m, 3) places `beside` [mm] stands something
    else, that stops an approach, too.
    """
    if not len(felt):
        return None
    alike = np.round(np.concatenate([felt / config.coarse, facing], axis=1)).astype(int)
    _, first = np.unique(alike, axis=0, return_index=True)
    felt, facing = felt[first], facing[first]
    unseen = _unseen(felt, seen, config)
    other = np.empty((0, 3)) if beside is None else beside
    best, view = 1.0, None
    for way in _ways(axes) if len(unseen) else ():
        turn = se3.frame_along(way, axes[:, int(np.argmin(np.abs(way @ axes)))])
        straight = float(np.abs(way @ axes).max()) > 0.99
        over = 4.0 * half[0] * half[1] / seen.cell**3  # cells a millimeter of depth
        places, behind, shown = unseen @ turn, felt @ turn, facing @ -way > config.facing
        stands, known = (
            np.concatenate([felt, other]) @ turn,
            np.append(shown, np.ones(len(other), dtype=bool)),
        )
        low, high = places[:, :2].min(axis=0), places[:, :2].max(axis=0)
        x, y = (np.arange(a, b + config.step, config.step) for a, b in zip(low, high, strict=True))
        count, stop, new = looked_into(places, stands, known, x, y, half, config.first)
        deep = np.where(new, config.end, config.side if int(shown.sum()) < config.few else config.deep)
        least = over * (deep if straight else config.deep)
        worth = count * (1.0 if straight else config.slanting) / least
        if worth.max() > best:
            i, j = np.unravel_index(int(np.argmax(worth)), worth.shape)
            best = float(worth[i, j])
            middle = turn @ np.array([x[i], y[j], float(behind[:, 2].mean())])
            met = (np.abs(places[:, :2] - [x[i], y[j]]) < half).all(axis=1) & (places[:, 2] < stop[i, j])
            view = View(se3.pose(turn, middle), unseen[met])
    return view


def _unseen(felt: Floats, seen: SweptCells, config: ViewsConfig) -> Floats:
    """(n, 3) middles of the cells in and about the hull of felt places that hold nobody knows what."""
    wider = np.concatenate([felt + config.about * way for way in (*np.eye(3), *-np.eye(3))])
    sides = ConvexHull(wider).equations
    cells = seen.unseen_between(wider.min(axis=0), wider.max(axis=0))
    cells = cells[(cells @ sides[:, :3].T + sides[:, 3] < 0.0).all(axis=1)]
    return np.asarray(cells[KDTree(felt).query(cells)[0] > config.beside]) if len(cells) else cells


def _ways(axes: Floats) -> list[Floats]:
    """Along the axes both ways, and half-way between two."""
    steps = [np.array(s, dtype=float) for s in product((0, 1, -1), repeat=3) if 0 < np.abs(s).sum() < 3]
    return [axes @ (step / np.linalg.norm(step)) for step in sorted(steps, key=lambda s: np.abs(s).sum())]
