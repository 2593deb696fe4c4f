"""Who is told what kind of outline lies under the pad, and starts from the true one: a limit of all searches.

The likelihood is that of the closed form of the sensor, which the rows of a single edge hold against simulated
frames.  Nobody who must find the kind or the start as well finds a greater one near the truth.  Frames are found
that look like an edge, by their noise too, so that on those even who is told errs to one side.

Who is not told the kind, but tries the true one from the truth beside all that ours finds, keeps what has more
evidence: what no search betters, where kinds are as likely before touch as ours takes them for.
"""

from dataclasses import dataclass
from itertools import product
from math import hypot

import numpy as np
from perception.scene import Scene

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.estimate_bias import bias_of
from exploration.sensing.lines.line_fit import softened
from exploration.sensing.lines.outline import LIKELIEST, find_outline
from exploration.sensing.lines.outline_evidence import log_over, log_weight
from exploration.sensing.lines.region import NO_TERMS, WHOLE, Region, Terms
from exploration.sensing.lines.region_fit import LEVEL, SLOPE, RegionFit, fit_region
from exploration.sensing.response import response_of
from primitives.arrays import Floats

TOLD = "told the kind, from the truth"
FOUND = "told the kind, where palpate finds a line"
TRIED = "not told it, but tried it from the truth"
CLEARLY = 0.1  # [log] beyond what steps that ended elsewhere differ by


@dataclass(frozen=True)
class Said:
    """A line by its two numbers [rad], [mm]."""

    angle: float
    offset: float


def told_lines(scene: Scene, image: TactileImage, terms: Terms) -> RegionFit:
    """The likeliest lines, joined as the true ones are."""
    truth = scene.found
    soft = softened(image)
    response = response_of(image)
    kinds = [Region(sides, terms) for sides in product((1.0, -1.0), repeat=len(truth))]
    true = min(kinds, key=lambda kind: fit_region(soft, response, kind, truth.ravel(), 0).chi2)
    return fit_region(soft, response, true, truth.ravel())


def said(fit: RegionFit) -> tuple[Said, ...]:
    """Its lines."""
    p = fit.parameters[3:]
    return tuple(Said(float(p[k]), float(p[k + 1])) for k in range(0, len(p), 2))


def is_missed(fit: RegionFit, image: TactileImage) -> bool:
    """Whether a fit has clearly more evidence than what our search found instead."""
    ours = find_outline(image, config=LIKELIEST).fit
    if ours is None or not fit.converged:
        return False
    size = hypot(*image.array.size)
    return log_over(fit, ours) + log_weight(fit, size) > log_weight(ours, size) + CLEARLY


def told_disc(scene: Scene, image: TactileImage, boss: bool) -> Floats:
    """(3,) center and radius [mm] of the likeliest boss or hole, less what those are off on average."""
    region = Region((), NO_TERMS if boss else WHOLE, (1.0 if boss else -1.0,))
    soft, response = softened(image), response_of(image)
    fit = fit_region(soft, response, region, scene.found[0], slope=LEVEL if boss else SLOPE)
    off = bias_of(soft, response, fit) if fit.converged else np.zeros(region.unknowns)
    return np.asarray((fit.parameters - off)[3:])
