"""scikit-image's line finders; the only file that imports skimage, and only when one is called.

Settings are the best of `tests/bench/perception/tune.py`.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np

from exploration.sensing.baselines.picture import contrast, distinct, line_of_votes, line_through
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line import Line


@dataclass(frozen=True)
class SkimageConfig:
    """Canny, then votes."""

    smooth: float = 1.4  # [taxels] Canny's own Gaussian
    low: float = 0.05  # of the plateau
    high: float = 0.1
    theta: float = 0.5  # [deg]
    peak: float = 0.5  # of the highest, least
    votes: int = 4  # of the probabilistic one
    length: int = 4  # [taxels] least, of the probabilistic one
    gap: int = 2  # [taxels]


STRAIGHT = SkimageConfig()
PROBABILISTIC = SkimageConfig(high=0.2, theta=1.0, votes=5, gap=3)
SAME_TURN, SAME_SHIFT = np.radians(15.0), 1.5  # [rad], [taxels] of two peaks that are one line


def hough_lines(image: TactileImage, most: int = 3, config: SkimageConfig = STRAIGHT) -> tuple[Line, ...]:
    """canny, hough_line and hough_line_peaks."""
    from skimage.transform import hough_line, hough_line_peaks

    edges = _edges(image, config)
    if edges is None or not edges.any():
        return ()
    theta = np.radians(np.arange(-90.0, 90.0, config.theta))
    votes, angles, offsets = hough_line(edges, theta)
    found = hough_line_peaks(
        votes,
        angles,
        offsets,
        min_distance=1,
        min_angle=1,
        threshold=config.peak * votes.max(),
        num_peaks=12 * most,
    )
    lines = (line_of_votes(image, float(r), float(t), float(v)) for v, t, r in zip(*found, strict=True))
    return distinct(lines, most, SAME_TURN, SAME_SHIFT * image.array.pitch[0])


def hough_segments(
    image: TactileImage, most: int = 3, config: SkimageConfig = PROBABILISTIC
) -> tuple[Line, ...]:
    """Canny and probabilistic_hough_line; the longest segments."""
    from skimage.transform import probabilistic_hough_line

    edges = _edges(image, config)
    if edges is None or not edges.any():
        return ()
    theta = np.radians(np.arange(-90.0, 90.0, config.theta))
    found = probabilistic_hough_line(
        edges, config.votes, config.length, config.gap, theta, rng=np.random.default_rng(0)
    )
    ends = np.array(found, dtype=float).reshape(-1, 2, 2)
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    lines = (line_through(image, ends[i, 0], ends[i, 1], float(length[i])) for i in np.argsort(-length))
    return distinct(lines, most, SAME_TURN, SAME_SHIFT * image.array.pitch[0])


def _edges(image: TactileImage, config: SkimageConfig) -> Any:
    from skimage.feature import canny

    share = contrast(image)
    if share is None:
        return None
    return canny(share, config.smooth, config.low, config.high, mode="nearest")
