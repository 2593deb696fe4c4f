"""OpenCV's line finders; the only file that imports cv2, and only when one is called.

Canny marks whole pixels.  On the array's own pixels finer Hough bins make the votes worse; on an enlarged picture
they make them better, for more time.  Both are offered; settings are the best of `tests/bench/perception/tune.py`.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exploration.sensing.baselines.picture import (
    distinct,
    line_of_votes,
    line_through,
    picture,
)
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.edges import edge_points
from exploration.sensing.lines.line import Line


@dataclass(frozen=True)
class CannyConfig:
    """Canny, then votes."""

    low: float = 150.0  # gray values of the gradient
    high: float = 300.0
    enlarge: int = 1
    smooth: float = 0.0  # [taxels] Gaussian before Canny
    rho: float = 1.0  # [pixels of the enlarged picture]
    theta: float = 2.0  # [deg]
    votes: float = 4.0  # [taxels of edge] least
    length: float = 3.0  # [taxels] least, of HoughLinesP
    gap: float = 2.0  # [taxels] most, of HoughLinesP


@dataclass(frozen=True)
class PointsConfig:
    """HoughLinesPointSet."""

    rho: float = 0.5  # [taxels]
    theta: float = 0.5  # [deg]
    votes: int = 4


PLAIN = CannyConfig()
ENLARGED = CannyConfig(low=20.0, high=80.0, enlarge=4, smooth=1.0, rho=1.0, theta=0.25)
SEGMENTS = CannyConfig(low=70.0, high=300.0, smooth=0.7, rho=0.5, theta=1.0, gap=5.0)
SAME_TURN, SAME_SHIFT = np.radians(15.0), 1.5  # [rad], [taxels] of two peaks that are one line


def hough_lines(image: TactileImage, most: int = 3, config: CannyConfig = PLAIN) -> tuple[Line, ...]:
    """cv2.Canny and cv2.HoughLines; peaks by votes."""
    import cv2

    edges = _edges(image, config)
    if edges is None:
        return ()
    votes = max(1, round(config.votes * config.enlarge))
    found = cv2.HoughLines(edges, config.rho, np.radians(config.theta), votes)
    if found is None:
        return ()
    peaks = found.reshape(len(found), -1)[: 12 * most, :2].tolist()
    lines = (line_of_votes(image, *_shrunk(r, t, config.enlarge), float(votes)) for r, t in peaks)
    return distinct(lines, most, SAME_TURN, SAME_SHIFT * image.array.pitch[0])


def hough_segments(image: TactileImage, most: int = 3, config: CannyConfig = SEGMENTS) -> tuple[Line, ...]:
    """cv2.Canny and cv2.HoughLinesP; the longest segments."""
    import cv2

    edges = _edges(image, config)
    if edges is None:
        return ()
    s = config.enlarge
    found = cv2.HoughLinesP(
        edges,
        config.rho,
        np.radians(config.theta),
        max(1, round(config.votes * s)),
        minLineLength=config.length * s,
        maxLineGap=config.gap * s,
    )
    if found is None:
        return ()
    ends = (found.reshape(-1, 2, 2) + 0.5) / s - 0.5
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    lines = (line_through(image, ends[i, 0], ends[i, 1], float(length[i])) for i in np.argsort(-length))
    return distinct(lines, most, SAME_TURN, SAME_SHIFT * image.array.pitch[0])


def hough_points(image: TactileImage, most: int = 3, config: PointsConfig | None = None) -> tuple[Line, ...]:
    """cv2.HoughLinesPointSet on half-plateau crossings between taxels."""
    import cv2

    config = config or PointsConfig()
    if picture(image) is None:
        return ()
    found = edge_points(image).points
    if len(found) < config.votes:
        return ()
    pitch = np.array(image.array.pitch)
    points = found / pitch + np.array([image.array.columns, image.array.rows])
    reach = float(2.0 * np.hypot(image.array.columns, image.array.rows))
    peaks = cv2.HoughLinesPointSet(
        points.astype(np.float32)[:, None],
        12 * most,
        config.votes,
        -reach,
        reach,
        config.rho,
        0.0,
        np.pi,
        np.radians(config.theta),
    )
    if peaks is None:
        return ()
    back = np.array([image.array.columns + 1, image.array.rows + 1]) / 2
    lines = []
    for votes, rho, theta in peaks.reshape(-1, 3):
        shift = float(back @ [np.cos(theta), np.sin(theta)])
        lines.append(line_of_votes(image, float(rho) - shift, float(theta), float(votes)))
    return distinct(lines, most, SAME_TURN, SAME_SHIFT * image.array.pitch[0])


def fitted_crossings(image: TactileImage, most: int = 1) -> tuple[Line, ...]:
    """cv2.fitLine with Huber's weights through all crossings: one line, whatever they are."""
    import cv2

    del most
    if picture(image) is None:
        return ()
    found = edge_points(image).points
    if len(found) < 4:
        return ()
    vx, vy, x, y = cv2.fitLine(found.astype(np.float32), cv2.DIST_HUBER, 0, 0.01, 0.01).ravel()
    middle = np.array([image.array.columns - 1, image.array.rows - 1]) / 2
    at = np.array([x, y]) / image.array.pitch + middle
    along = np.array([vx, vy]) / image.array.pitch
    line = line_through(image, at, at + along, float(len(found)))
    return () if line is None else (line,)


def _edges(image: TactileImage, config: CannyConfig) -> Any:
    gray = picture(image)
    return None if gray is None else canny(gray, config)


def canny(gray: NDArray[np.uint8], config: CannyConfig) -> Any:
    """(rows, columns) times the enlargement: 255 where Canny marks an edge of a picture."""
    import cv2

    if config.enlarge > 1:
        size = (gray.shape[1] * config.enlarge, gray.shape[0] * config.enlarge)
        gray = cv2.resize(gray, size, interpolation=cv2.INTER_CUBIC)
    if config.smooth > 0:
        gray = cv2.GaussianBlur(gray, (0, 0), config.smooth * config.enlarge)
    return cv2.Canny(gray, config.low, config.high, apertureSize=3)


def _shrunk(rho: float, theta: float, s: int) -> tuple[float, float]:
    """A line of the enlarged picture in pixels of the array: x_small = (x + 1/2) / s - 1/2."""
    return (rho + 0.5 * (np.cos(theta) + np.sin(theta)) * (1 - s)) / s, theta
