"""Every baseline by name."""

from collections.abc import Callable
from importlib.util import find_spec

from exploration.sensing.baselines import opencv_lines, skimage_lines
from exploration.sensing.baselines.adaptive_hough import adaptive_hough
from exploration.sensing.baselines.burns import burns_lines
from exploration.sensing.baselines.erf_fit import SLOPED, erf_fit
from exploration.sensing.baselines.muthukrishnan import contour_lines
from exploration.sensing.baselines.plain_hough import plain_hough
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line import Line

Finder = Callable[[TactileImage], tuple[Line, ...]]


def _sloped_erf_fit(image: TactileImage) -> tuple[Line, ...]:
    return erf_fit(image, config=SLOPED)


def _hough_lines_enlarged(image: TactileImage) -> tuple[Line, ...]:
    return opencv_lines.hough_lines(image, config=opencv_lines.ENLARGED)


_OWN: dict[str, Finder] = {
    "Muthukrishnan, contours": contour_lines,
    "Muthukrishnan, Burns": burns_lines,
    "plain Hough": plain_hough,
    "adaptive Hough": adaptive_hough,
    "erf fit": erf_fit,
    "erf fit with slopes": _sloped_erf_fit,
}
_OPENCV: dict[str, Finder] = {
    "cv2.Canny + HoughLines": opencv_lines.hough_lines,
    "cv2.Canny + HoughLines, enlarged": _hough_lines_enlarged,
    "cv2.HoughLinesP": opencv_lines.hough_segments,
    "cv2.HoughLinesPointSet": opencv_lines.hough_points,
    "cv2.fitLine on crossings": opencv_lines.fitted_crossings,
}
_SKIMAGE: dict[str, Finder] = {
    "skimage hough_line": skimage_lines.hough_lines,
    "skimage probabilistic": skimage_lines.hough_segments,
}


def baselines() -> dict[str, Finder]:
    """Those whose packages are installed."""
    return {
        **_OWN,
        **(_OPENCV if find_spec("cv2") else {}),
        **(_SKIMAGE if find_spec("skimage") else {}),
    }
