"""What image tools are given, and how their pixels become our lines.

A frame is scaled so that its plateau (98th percentile) is `WHITE`, whatever the press; dead taxels are filled from
their neighbors.  A frame whose plateau is within `LEAST` sigma of nothing holds no picture: no tool tells a level
of noise from a face by itself, and all are given the same help.  Pixels are (column, row), the first at (0, 0).
"""

from collections.abc import Iterable, Sequence
from math import atan2, cos, hypot, inf, pi, sin

import numpy as np
from numba import njit
from numpy.typing import NDArray

from exploration.sensing.contact_mask import noise_of, repaired, usable
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line import Line, clipped, normalized
from primitives.arrays import Floats, frozen

WHITE = 200.0  # gray value of the plateau
LEAST = 4.0  # [sigma] plateau of a frame in contact
UNSTATED = frozen(np.full((2, 2), np.inf))  # covariance of who gives none


def contrast(image: TactileImage) -> Floats | None:
    """(rows, columns) depth over its plateau; None out of contact."""
    if not usable(image):
        return None
    depth = repaired(image.depth, image.sigma)[0]
    top = depth.size - max(1, depth.size // 50)
    plateau = float(np.partition(depth, top, axis=None)[top])
    return depth / plateau if plateau > LEAST * noise_of(image.sigma) else None


def picture(image: TactileImage) -> NDArray[np.uint8] | None:
    """(rows, columns) gray values."""
    share = contrast(image)
    return None if share is None else np.clip(share * WHITE, 0.0, 255.0).astype(np.uint8)


def line_through(
    image: TactileImage, p: Sequence[float] | Floats, q: Sequence[float] | Floats, strength: float
) -> Line | None:
    """The line through two pixels, strong by its tool's own measure; None where they coincide."""
    array = image.array
    (px, py), c, r = array.pitch, (array.columns - 1) / 2, (array.rows - 1) / 2
    x, y = (float(p[0]) - c) * px, (float(p[1]) - r) * py
    dx, dy = (float(q[0]) - c) * px - x, (float(q[1]) - r) * py - y
    length = hypot(dx, dy)
    if not 0.0 < length < inf:
        return None
    return line_at(image, atan2(dy, dx), (y * dx - x * dy) / length, strength)


def line_of_votes(image: TactileImage, rho: float, theta: float, strength: float) -> Line | None:
    """The line x cos(theta) + y sin(theta) = rho of pixels."""
    c, s = cos(theta), sin(theta)
    x, y = rho * c, rho * s
    return line_through(image, (x + s, y - c), (x - s, y + c), strength)


def line_at(image: TactileImage, angle: float, offset: float, strength: float) -> Line | None:
    """A line as ours are, material on its deeper side; None where it misses the pad."""
    angle, offset, _ = normalized(angle, offset, 1)
    (px, py), array = image.array.pitch, image.array
    low, high = clipped(angle, offset, (array.size[0] / 2, array.size[1] / 2))
    if high <= low:
        return None
    c, s = cos(angle), sin(angle)
    over, under = _sides(image.depth, image.sigma, px, py, c, s, offset)
    return Line(
        angle,
        offset,
        UNSTATED,
        high - low,
        np.array([low * c - offset * s, low * s + offset * c]),
        np.array([high * c - offset * s, high * s + offset * c]),
        strength,
        1 if over >= under else -1,
        max(over, under),
    )


@njit(cache=True)
def _sides(
    depth: Floats, sigma: Floats, px: float, py: float, c: float, s: float, offset: float
) -> tuple[float, float]:
    """Mean depth of the living taxels on either side of a line."""
    rows, columns = depth.shape
    total = np.zeros(2)
    count = np.zeros(2)
    for i in range(rows):
        for j in range(columns):
            if sigma[i, j] != np.inf:
                away = (i - (rows - 1) / 2) * py * c - (j - (columns - 1) / 2) * px * s
                side = 0 if away > offset else 1
                total[side] += depth[i, j]
                count[side] += 1.0
    return total[0] / max(1.0, count[0]), total[1] / max(1.0, count[1])


def distinct(lines: Iterable[Line | None], most: int, turn: float, shift: float) -> tuple[Line, ...]:
    """The first lines that differ from all before by `turn` [rad] or, at the pad's center, `shift` [mm]."""
    kept: list[Line] = []
    for line in lines:
        if line is None or any(_alike(line, other, turn, shift) for other in kept):
            continue
        kept.append(line)
        if len(kept) == most:
            break
    return tuple(kept)


def _alike(a: Line, b: Line, turn: float, shift: float) -> bool:
    apart = (a.angle - b.angle + pi / 2) % pi - pi / 2
    offset = b.offset if abs(a.angle - b.angle) < pi / 2 else -b.offset
    return abs(apart) < turn and abs(a.offset - offset) < shift
