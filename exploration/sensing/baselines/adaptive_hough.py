"""Illingworth and Kittler's adaptive Hough transform (1987): a small accumulator that looks closer and closer.

Points of strong gradient vote in `cells` x `cells` over a window of angle and offset.  Cells above `level` of the
highest are on; of their connected groups the one of most votes sets the next window: centered on the group and
shrunk where it lies inside, shifted where it touches the border, widened where it fills the window.  When the
window is small enough its center is a line; its points are taken out and the search begins again.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label

from exploration.sensing.baselines.picture import contrast, line_of_votes
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line import Line
from primitives.arrays import Floats

_EIGHT = np.ones((3, 3))


@dataclass(frozen=True)
class AdaptiveHoughConfig:
    """Windows and thresholds."""

    cells: int = 13  # an axis
    level: float = 0.7  # of the highest cell
    finest: tuple[float, float] = (
        8.0,
        1.0,
    )  # [deg], [taxels] cell at which the search ends: votes spread as wide
    shrink: float = 0.5
    least: float = 0.5  # of the greatest gradient
    band: float = 1.5  # [taxels] of points that a found line takes out
    fewest: int = 4  # points on a line
    rounds: int = 20


def adaptive_hough(
    image: TactileImage, most: int = 3, config: AdaptiveHoughConfig | None = None
) -> tuple[Line, ...]:
    """Lines in the order in which they are found."""
    config = config or AdaptiveHoughConfig()
    share = contrast(image)
    if share is None:
        return ()
    gy, gx = np.gradient(share)
    size = np.hypot(gx, gy)
    row, column = np.nonzero(size > config.least * size.max())
    middle = np.array([image.array.columns - 1, image.array.rows - 1]) / 2
    points = np.stack([column, row], axis=1) - middle
    lines: list[Line] = []
    while len(lines) < most and len(points) >= config.fewest:
        theta, rho = _search(points, float(np.hypot(*middle)), config)
        away = np.abs(points @ [np.cos(theta), np.sin(theta)] - rho)
        taken = away < config.band
        if taken.sum() < config.fewest:
            break
        shift = float(middle @ [np.cos(theta), np.sin(theta)])
        line = line_of_votes(image, rho + shift, theta, float(taken.sum()))
        if line is not None:
            lines.append(line)
        points = points[~taken]
    return tuple(lines)


def _search(points: Floats, reach: float, config: AdaptiveHoughConfig) -> tuple[float, float]:
    """Angle of the normal [rad] and offset [taxels] of one line; offsets from the picture's middle."""
    center = np.array([np.pi / 2, 0.0])
    half = np.array([np.pi / 2, reach])
    finest = np.array([np.radians(config.finest[0]), config.finest[1]]) * config.cells / 2
    votes = _votes(points, center, half, config.cells)
    for _ in range(config.rounds):
        if np.all(half <= finest):
            break
        on, count = label(votes >= config.level * votes.max(), _EIGHT)
        best = 1 + int(np.argmax([votes[on == k].sum() for k in range(1, count + 1)]))
        cells = np.argwhere(on == best)
        low, high = cells.min(axis=0), cells.max(axis=0) + 1
        size = 2 * half / config.cells
        middle = center - half + (low + high) / 2 * size
        for axis in range(2):
            filled = (high - low)[axis] >= config.cells
            at_border = low[axis] == 0 or high[axis] == config.cells
            center[axis] = middle[axis]
            if filled:
                half[axis] = min(half[axis] / config.shrink, (np.pi / 2, reach)[axis])
            elif not at_border:
                half[axis] = max(half[axis] * config.shrink, (high - low)[axis] * size[axis] / 2)
        votes = _votes(points, center, half, config.cells)
    return float(center[0]), float(center[1])


def _votes(points: Floats, center: Floats, half: Floats, cells: int) -> Floats:
    """(cells, cells) each point's sinusoid, sampled at the middle of each column of cells."""
    theta = center[0] + half[0] * ((2 * np.arange(cells) + 1) / cells - 1)
    rho = np.cos(theta)[:, None] * points[:, 0] + np.sin(theta)[:, None] * points[:, 1]
    cell = np.floor((rho - center[1] + half[1]) / (2 * half[1]) * cells).astype(int)
    inside = (cell >= 0) & (cell < cells)
    flat = (np.arange(cells)[:, None] * cells + cell)[inside]
    return np.bincount(flat, minlength=cells * cells).reshape(cells, cells).astype(float)
