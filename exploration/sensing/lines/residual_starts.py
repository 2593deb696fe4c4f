"""Where to start on contacts and gaps hardly wider than the blur, which no half-height crossing outlines.

A blurred disc of radius R has the variance R^2/4 + blur^2 along each axis, which gives R.  A hole takes the volume
pi R^2 z0 out of a face z0 deep, and a slot takes its width times its length times z0 (our derivation).
"""

from math import atan2, cos, sin

import numpy as np

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line import clipped
from exploration.sensing.lines.outline_starts import Circle, Straight
from exploration.sensing.response import Response
from primitives.arrays import Floats

SHARE = 0.15  # of the deepest 3 x 3 taxels, from which others belong to a small contact
LEAST = 0.3  # [blurs] radius to start from


def blob(image: TactileImage, response: Response) -> Circle | None:
    """The disc whose blur has the first two moments of a small contact; none where nothing is felt."""
    x, y = image.array.x, image.array.y
    depth = np.where(np.isfinite(image.sigma), image.depth, 0.0)
    smooth = means(depth)
    depth = np.where(smooth > SHARE * smooth.max(), depth, 0.0)
    total = float(depth.sum())
    if total <= 0.0:
        return None
    along, across = depth.sum(axis=0), depth.sum(axis=1)
    cx, cy = float(along @ x) / total, float(across @ y) / total
    variance = float(along @ (x - cx) ** 2 + across @ (y - cy) ** 2) / total
    radius = 2.0 * max(0.5 * (variance - float(response.variance.sum())), 0.0) ** 0.5
    return cx, cy, max(radius, LEAST * response.mean_width), 1.0


def dip(left: Floats, x: Floats, y: Floats, height: float, reach: float) -> Circle | None:
    """The hole that takes as much from a face `height` deep as is missing around the deepest dip of `left`."""
    smooth = means(left)
    row, column = np.unravel_index(int(np.argmin(smooth)), smooth.shape)
    gx, gy = np.meshgrid(x, y)
    here = np.hypot(gx - x[column], gy - y[row]) < reach
    missing = np.where(here, np.maximum(-left, 0.0), 0.0)
    total = float(missing.sum())
    if total <= 0.0 or height <= 0.0:
        return None
    area = total * abs((x[-1] - x[0]) * (y[-1] - y[0])) / max(1, (len(x) - 1) * (len(y) - 1)) / height
    return (
        float((missing * gx).sum()) / total,
        float((missing * gy).sum()) / total,
        (area / np.pi) ** 0.5,
        -1.0,
    )


def trough(left: Floats, x: Floats, y: Floats, height: float, size: tuple[float, float]) -> list[Straight]:
    """The slot that takes as much from a face as is missing along the dips of `left`."""
    missing = np.maximum(-means(left), 0.0)
    total = float(missing.sum())
    if total <= 0.0 or height <= 0.0:
        return []
    gx, gy = np.meshgrid(x, y)
    cx, cy = float((missing * gx).sum()) / total, float((missing * gy).sum()) / total
    dx, dy = gx - cx, gy - cy
    angle = 0.5 * atan2(2.0 * float((missing * dx * dy).sum()), float((missing * (dx * dx - dy * dy)).sum()))
    offset = cy * cos(angle) - cx * sin(angle)
    low, high = clipped(angle, offset, (size[0] / 2, size[1] / 2))
    area = total * size[0] * size[1] / left.size / height
    half = 0.5 * area / max(high - low, 1e-3)
    return [(angle, offset + half, 1.0), (angle, offset - half, -1.0)]


def opposite(line: Straight, depth: Floats, x: Floats, y: Floats) -> Straight:
    """The far side of a bar that begins at a line: what is felt has its middle halfway across."""
    angle, offset, side = line
    gx, gy = np.meshgrid(x, y)
    inside = side * (gy * cos(angle) - gx * sin(angle) - offset)
    felt = np.where(inside > 0.0, np.maximum(depth, 0.0), 0.0)
    width = 2.0 * float((felt * inside).sum()) / max(float(felt.sum()), 1e-12)
    return angle, offset + side * width, -side


def means(values: Floats) -> Floats:
    """Means over 3 x 3, the rim counted twice."""
    padded = np.pad(values, 1, mode="edge")
    rows = padded[:-2] + padded[1:-1] + padded[2:]
    means: Floats = (rows[:, :-2] + rows[:, 1:-1] + rows[:, 2:]) / 9.0
    return means
