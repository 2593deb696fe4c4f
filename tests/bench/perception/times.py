"""Times on one core, each method on the same frame before the next frame comes: medians.

cv2 alone is Canny and HoughLines on a picture already made, without a line as ours; with one it is in the other
rows.  The erf fit is the baseline's, step alone.
"""

import time
from collections.abc import Callable
from typing import Any

import numpy as np
from perception.edges import OURS, drawn
from perception.noise import Noise
from perception.presses import edge
from perception.score import row

from exploration.control.feel import feel
from exploration.sensing.baselines.erf_fit import erf_fit
from exploration.sensing.baselines.opencv_lines import PLAIN
from exploration.sensing.baselines.picture import picture
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.hough import find_lines
from exploration.sensing.touch import perceive

try:
    import cv2
except ImportError:
    cv2 = None


def time_rows(noise: Noise, frames: int) -> list[dict[str, Any]]:
    """Ours beside cv2 alone and the erf fit."""
    work: dict[str, Callable[[TactileImage], Any]] = {
        "lines": find_lines,
        "erf": erf_fit,
        "slope": feel,
        "touch": perceive,
    }
    if cv2 is not None:
        cv2.setNumThreads(1)
        work["cv2"] = _cv2_alone
    images = [image for _, image in drawn(edge, noise, frames, 41)]
    spent: dict[str, list[float]] = {name: [] for name in work}
    for image in images[:5]:
        for do in work.values():
            do(image)
    for image in images:
        for name, do in work.items():
            took = do(image) if name == "cv2" else _seconds(do, image)
            spent[name].append(took)
    middle = {name: 1e6 * float(np.median(times)) for name, times in spent.items()}
    rows = [
        row(OURS, "frame to polished line", middle["lines"], "us", 50.0),
        row("erf fit", "frame to fitted line", middle["erf"], "us"),
        row(OURS, "time over the erf fit's", middle["lines"] / middle["erf"], "1", 0.1),
        row(OURS, "frame to force and slope", middle["slope"], "us", 20.0),
        row(OURS, "frame to touch", middle["touch"], "us"),
    ]
    if cv2 is not None:
        rows += [
            row("cv2.Canny + HoughLines", "picture to votes, alone", middle["cv2"], "us"),
            row(OURS, "time over cv2's alone", middle["lines"] / middle["cv2"], "1", 1.0),
        ]
    return rows


def _seconds(do: Callable[[TactileImage], Any], image: TactileImage) -> float:
    began = time.perf_counter()
    do(image)
    return time.perf_counter() - began


def _cv2_alone(image: TactileImage) -> float:
    """Seconds of Canny and HoughLines."""
    gray = picture(image)
    began = time.perf_counter()
    edges = cv2.Canny(gray, PLAIN.low, PLAIN.high, apertureSize=3)
    if PLAIN.smooth > 0:
        edges = cv2.Canny(cv2.GaussianBlur(gray, (0, 0), PLAIN.smooth), PLAIN.low, PLAIN.high, apertureSize=3)
    cv2.HoughLines(edges, PLAIN.rho, np.radians(PLAIN.theta), max(1, round(PLAIN.votes)))
    return time.perf_counter() - began
