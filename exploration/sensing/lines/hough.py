"""Lines of a frame: one straight edge at once, or the Modified Adaptive Hough Transform and a polish of its peaks.

Most frames show one edge or none, and `single_edge` is sure of that in one kernel.  Most others show the outline
of a flat face, several lines at once (`outline`).  In what is left, peaks of the votes (`hough_votes`) are
extracted one after another, each taking its points away, and each is fitted to the sensor model with the surface
around it (`fitted_peaks`). "No line" is the usual answer.
"""

from math import pi

from exploration.sensing.contact_mask import usable
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.fitted_peaks import DEFAULT, HoughConfig, fitted_peaks
from exploration.sensing.lines.line import Line
from exploration.sensing.lines.outline import LIKELIEST, UNMISTAKABLE, OutlineConfig, find_outline
from exploration.sensing.lines.single_edge import DOUBTFUL, first_look, single_edge
from exploration.sensing.response import Response, response_of
from primitives.errors import PalpateError


def find_lines(
    image: TactileImage,
    max_lines: int = 3,
    response: Response | None = None,
    config: HoughConfig | None = None,
    dihedral: float = pi / 2,
) -> tuple[Line, ...]:
    """The straight edges of a frame, strongest first; empty where there is none.

    A wall that is hardly wider than the blur has its edges, though a cylinder narrower than the pad may explain it
    as well; so have a strip of a face, which may be a wide cylinder beside the pad's middle, and a cut corner,
    which may be an arc, unless those are clearly likelier.

    `dihedral` [rad] is the angle between an edge's two faces.  No single frame tells a wider one than a right
    angle from more blur: not told, an edge of 120 or 150 degrees pressed z0 deep is placed
    z0 tan(dihedral - pi/2) / 2 too far outside, 0.14 or 0.43 mm at 0.5 mm.
    """
    _check(image)
    if not usable(image):
        return ()
    response = response_of(image, response)
    verdict, line = first_look(image, response, dihedral)
    if verdict != DOUBTFUL:
        return () if line is None else (line,)
    return _several(image, max_lines, response, config or DEFAULT, LIKELIEST)


def sure_lines(image: TactileImage, max_lines: int = 3) -> tuple[Line, ...]:
    """The straight edges that are worth steering by: none where any smooth surface explains the frame.

    That is seen at once, where weighing one against the other takes a millisecond.
    """
    _check(image)
    if not usable(image):
        return ()
    response = response_of(image)
    verdict, line = single_edge(image, response)
    if verdict != DOUBTFUL:
        return () if line is None else (line,)
    return _several(image, max_lines, response, DEFAULT, UNMISTAKABLE)


def _check(image: TactileImage) -> None:
    if image.depth.shape != image.array.shape or image.sigma.shape != image.array.shape:
        raise PalpateError(
            f"image of {image.depth.shape} taxels and {image.sigma.shape} sigmas on array {image.array.name} "
            f"{image.array.shape}: make it by `correct` with the array's own calibration"
        )


def _several(
    image: TactileImage,
    max_lines: int,
    response: Response,
    config: HoughConfig,
    outlines: OutlineConfig,
) -> tuple[Line, ...]:
    """The lines of a frame that more than one edge may explain."""
    outline = find_outline(image, max_lines, response, outlines)
    explained = outline.explains(config.greatest_misfit) and not outline.arcs
    return (
        _high(image, outline.lines, config) if explained else voted_lines(image, max_lines, response, config)
    )


def voted_lines(
    image: TactileImage,
    max_lines: int = 3,
    response: Response | None = None,
    config: HoughConfig = DEFAULT,
) -> tuple[Line, ...]:
    """The lines of a frame that no flat face's outline explains: rims, and edges of curved faces."""
    return _high(image, fitted_peaks(image, max_lines, response_of(image, response), config), config)


def _high(image: TactileImage, lines: tuple[Line, ...], config: HoughConfig) -> tuple[Line, ...]:
    """Without the low ends of planes that run out."""
    low = config.least_share * float(image.depth.max())
    return tuple(line for line in lines if line.plateau > low)
