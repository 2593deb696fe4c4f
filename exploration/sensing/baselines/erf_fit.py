"""The erf of a pressed edge, fitted by Gauss and Newton in numpy from the start that the image's moments give.

depth = (A + c v) E(t) + b (t E(t) + w phi(t / w)),  E(t) = (1 + erf(t / (sqrt(2) w))) / 2, t the distance into
the material, v along the edge, w^2 = spread^2 + pitch^2/12; b and c only where `slopes` are asked for.  One line,
always: what a general least-squares fitter gives whoever writes the model down.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr

from exploration.sensing.baselines.picture import contrast, line_at
from exploration.sensing.contact_mask import repaired
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.line import Line
from primitives.arrays import Floats


@dataclass(frozen=True)
class ErfConfig:
    """How it is fitted; five steps are where more change nothing."""

    slopes: bool = False  # the plateau's two, fitted too
    steps: int = 5


STEP, SLOPED = ErfConfig(), ErfConfig(slopes=True)


def erf_fit(image: TactileImage, most: int = 1, config: ErfConfig = STEP) -> tuple[Line, ...]:
    """The one line that fits best."""
    del most
    if contrast(image) is None:
        return ()
    depth = repaired(image.depth, image.sigma)[0]
    px, py = image.array.pitch
    x, y = np.meshgrid(image.array.x, image.array.y)
    gy, gx = np.gradient(depth, py, px)
    weight = gx * gx + gy * gy
    total = weight.sum()
    if not total > 0:
        return ()
    angle = float(np.arctan2(-gx.sum(), gy.sum()))
    center = np.array([np.sum(weight * x), np.sum(weight * y)]) / total
    offset = float(center[1] * np.cos(angle) - center[0] * np.sin(angle))
    p = np.array([angle, offset, float(np.percentile(depth, 90)), 0.0, 0.0])
    free = 5 if config.slopes else 3
    w = float(np.sqrt(image.spread**2 + px * py / 12))
    inverse = np.where(np.isfinite(image.sigma), 1 / image.sigma, 0.0).ravel()
    with np.errstate(over="ignore", invalid="ignore"):  # a fit that runs away ends as no line
        for _ in range(config.steps):
            model, jacobian = _model(p, x, y, w, free)
            jacobian *= inverse
            misfit = (depth.ravel() - model) * inverse
            try:
                p[:free] += np.linalg.solve(jacobian @ jacobian.T, jacobian @ misfit)
            except np.linalg.LinAlgError:
                return ()
    if not np.isfinite(p).all():
        return ()
    line = line_at(image, float(p[0]), float(p[1]), float(abs(p[2]) * inverse.max()))
    return () if line is None else (line,)


def _model(p: Floats, x: Floats, y: Floats, w: float, free: int) -> tuple[Floats, Floats]:
    c, s = np.cos(p[0]), np.sin(p[0])
    across, v = y * c - x * s, x * c + y * s
    t = across - p[1]
    step = ndtr(t / w)
    bell = np.exp(-0.5 * (t / w) ** 2) / np.sqrt(2 * np.pi)
    height = p[2] + p[4] * v
    ramp = t * step + w * bell
    model = height * step + p[3] * ramp
    slope = height * bell / w + p[3] * step
    jacobian = np.empty((free, x.size))
    jacobian[0] = (-v * slope + p[4] * across * step).ravel()
    jacobian[1] = -slope.ravel()
    jacobian[2] = step.ravel()
    if free == 5:
        jacobian[3] = ramp.ravel()
        jacobian[4] = (v * step).ravel()
    return model.ravel(), jacobian
