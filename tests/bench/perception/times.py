"""Times on one core: medians, each method in turn on the same few frames, as a control loop runs one method on.

cv2 alone is Canny and HoughLines on a picture already made, without a line as ours; with one it is in the other
rows.  Its most accurate setting is on a picture four times as large, where it errs half as much.  The erf fit is
the baseline's, step alone.
"""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from perception.edges import OURS, drawn
from perception.noise import Noise
from perception.presses import edge
from perception.score import row

from exploration.control.feel import feel
from exploration.sensing.baselines.erf_fit import erf_fit
from exploration.sensing.baselines.opencv_lines import ENLARGED, PLAIN, CannyConfig, canny
from exploration.sensing.baselines.picture import picture
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.hough import find_lines
from exploration.sensing.touch import perceive

try:
    import cv2
except ImportError:
    cv2 = None

TURN = 20  # frames


def time_rows(noise: Noise, frames: int) -> list[dict[str, Any]]:
    """Ours beside cv2 alone and the erf fit."""
    work: dict[str, Callable[[TactileImage], Any]] = {
        "lines": find_lines,
        "erf": erf_fit,
        "slope": feel,
        "touch": perceive,
    }
    alone = {}
    if cv2 is not None:
        cv2.setNumThreads(1)
        alone = {"cv2": partial(_cv2_alone, config=PLAIN), "enlarged": partial(_cv2_alone, config=ENLARGED)}
    images = [image for _, image in drawn(edge, noise, frames, 41)]
    spent: dict[str, list[float]] = {name: [] for name in (*work, *alone)}
    for image in images[:5]:
        for do in work.values():
            do(image)
    for start in range(0, len(images), TURN):
        turn = images[start : start + TURN]
        for name, do in work.items():
            spent[name] += [_seconds(do, image) for image in turn]
        for name, seconds in alone.items():
            spent[name] += [seconds(image) for image in turn]
    middle = {name: 1e6 * float(np.median(times)) for name, times in spent.items()}
    rows = [
        row(OURS, "frame to polished line", middle["lines"], "us", 50.0),
        row("erf fit", "frame to fitted line", middle["erf"], "us"),
        row(OURS, "time over the erf fit's", middle["lines"] / middle["erf"], "1", 0.1),
        row(OURS, "frame to force and slope", middle["slope"], "us", 20.0),
        row(OURS, "frame to touch", middle["touch"], "us"),
    ]
    for name, title, asked in (
        ("enlarged", "cv2.Canny + HoughLines, enlarged", 1.0),
        ("cv2", "cv2.Canny + HoughLines", None),
    ):
        if name in middle:
            rows += [
                row(title, "picture to votes, alone", middle[name], "us"),
                row(OURS, f"time over {title}, alone", middle["lines"] / middle[name], "1", asked),
            ]
    return rows


def _seconds(do: Callable[[TactileImage], Any], image: TactileImage) -> float:
    began = time.perf_counter()
    do(image)
    return time.perf_counter() - began


def _cv2_alone(image: TactileImage, config: CannyConfig) -> float:
    """Seconds of Canny and HoughLines."""
    gray = picture(image)
    began = time.perf_counter()
    edges = canny(gray, config)
    cv2.HoughLines(edges, config.rho, np.radians(config.theta), max(1, round(config.votes * config.enlarge)))
    return time.perf_counter() - began
