"""The Hough transform as it is usually written: every strong gradient votes, bins are fixed, a parabola refines.

Each taxel whose gradient is strong votes with its size for the lines through it whose normal is within `window` of
the gradient (O'Gorman and Clowes 1976).  One accumulator over angle and offset; the highest bin, a parabola
through its neighbors along each axis; then its taxels' votes are taken out and the next highest is sought.
"""

from dataclasses import dataclass

import numpy as np

from exploration.sensing.baselines.picture import contrast, line_of_votes
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line import Line
from primitives.arrays import Floats


@dataclass(frozen=True)
class PlainHoughConfig:
    """Bins and thresholds."""

    theta: float = 2.0  # [deg] bin
    rho: float = 1.0  # [taxels] bin: an edge blurred over two taxels fills no finer one
    window: float = 10.0  # [deg] of a vote about the gradient
    least: float = 0.5  # of the greatest gradient
    band: float = 1.5  # [taxels] of votes that a found line takes out
    votes: float = 0.3  # of the first line's, least


def plain_hough(
    image: TactileImage, most: int = 3, config: PlainHoughConfig | None = None
) -> tuple[Line, ...]:
    """Lines by votes."""
    config = config or PlainHoughConfig()
    share = contrast(image)
    if share is None:
        return ()
    gy, gx = np.gradient(share)
    size = np.hypot(gx, gy)
    row, column = np.nonzero(size > config.least * size.max())
    weight, direction = size[row, column], np.arctan2(gy, gx)[row, column]
    theta = np.radians(np.arange(0.0, 180.0, config.theta))
    near = np.abs((theta[:, None] - direction + np.pi / 2) % np.pi - np.pi / 2) < np.radians(config.window)
    rho = np.cos(theta)[:, None] * column + np.sin(theta)[:, None] * row
    lines: list[Line] = []
    first = 0.0
    while len(lines) < most and len(weight):
        angle, offset, votes = _peak(rho, near * weight, theta, config)
        first = max(first, votes)
        if votes < config.votes * first or votes <= 0:
            break
        line = line_of_votes(image, offset, angle, votes)
        if line is not None:
            lines.append(line)
        away = np.abs(np.cos(angle) * column + np.sin(angle) * row - offset)
        weight = np.where(away < config.band, 0.0, weight)
    return tuple(lines)


def _peak(rho: Floats, weight: Floats, theta: Floats, config: PlainHoughConfig) -> tuple[float, float, float]:
    """Angle [rad], offset [taxels] and votes of the highest bin, refined."""
    low = float(rho.min()) - 2 * config.rho
    place = (rho - low) / config.rho
    bins = int(place.max()) + 3
    cell = place.astype(int)
    part = place - cell
    base = np.arange(len(theta))[:, None] * bins + cell
    count = np.bincount(base.ravel(), (weight * (1 - part)).ravel(), len(theta) * bins)
    count += np.bincount((base + 1).ravel(), (weight * part).ravel(), len(theta) * bins)
    votes = count.reshape(len(theta), bins)
    t, r = np.unravel_index(int(np.argmax(votes)), votes.shape)
    row = votes[t]
    dr = _vertex(row[r - 1], row[r], row[r + 1]) if 0 < r < bins - 1 else 0.0
    up = votes[t - 1, r] if t > 0 else 0.0
    down = votes[t + 1, r] if t + 1 < len(theta) else 0.0
    dt = _vertex(up, votes[t, r], down) if 0 < t < len(theta) - 1 else 0.0
    return float(theta[t] + dt * np.radians(config.theta)), low + (r + dr) * config.rho, float(votes[t, r])


def _vertex(a: float, b: float, c: float) -> float:
    """Where a parabola through three equally spaced values is highest, in steps from the middle."""
    bend = a - 2 * b + c
    return float(np.clip(0.5 * (a - c) / bend, -0.5, 0.5)) if bend < 0 else 0.0
