"""Stiffness: from a step of known height, and from known weights.

Pressed over a step with both its faces in contact, the pad feels depth = a + b x + c y + H edge(t / w): one tilt,
and the step between.  In units of the nominal stiffness and gain, the apparent height H over the true one is the
ratio of counts per mm, true over nominal.  A press of known force gives counts per N in the same way: it needs a
body that lies within the pad, so that the taxels feel all of it.  Stiffness is N/mm^3 = (counts/mm) / (counts /
(N/mm^2)); without weights the mean gain is taken from the data sheet.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from exploration.sensing.calibration import Calibration, correct
from exploration.sensing.contact_mask import repaired
from exploration.sensing.frame import TactileImage, TaxelArray, TaxelFrame
from exploration.sensing.lines.line_fit import softened
from exploration.sensing.response import response_of
from primitives.arrays import Floats
from primitives.errors import PalpateError

HEADINGS = 12  # directions from which the step is looked for
LEAST_RATIO = 5.0  # of a step's height over its sigma


@dataclass(frozen=True)
class Ratio:
    """True over nominal, with its sigma."""

    value: float
    sigma: float


def counts_per_depth(
    presses: Sequence[TaxelFrame],
    height: float,
    calibration: Calibration,
    array: TaxelArray,
    height_sigma: float = 0.0,
) -> Ratio:
    """Counts per mm over the calibration's, from presses over a step `height` [mm] high."""
    if not height > 0:
        raise PalpateError(f"the step's height must be positive, in mm, not {height}")
    whole = [press for press in presses if press.counts.max() < calibration.full_scale - 0.5]
    if presses and not whole:
        raise PalpateError("every press on the step drives taxels to full scale; press more lightly")
    found = [_step(correct(press, calibration, array)) for press in whole]
    seen = [(h, s) for h, s in found if h > LEAST_RATIO * s]
    if not seen:
        raise PalpateError(
            "no press shows the step; press until both its faces touch, its edge across the middle"
        )
    ratio = _mean(np.array(seen) / height)
    return Ratio(ratio.value, float(np.hypot(ratio.sigma, ratio.value * height_sigma / height)))


def counts_per_force(
    presses: Sequence[tuple[TaxelFrame, float]], calibration: Calibration, array: TaxelArray
) -> Ratio:
    """Counts per N/mm^2 over the calibration's, from (frame, force [N]) of bodies that lie within the pad."""
    if not presses or min(force for _, force in presses) <= 0:
        raise PalpateError("weights need frames, each with its force in N, more than none")
    if max(frame.counts.max() for frame, _ in presses) >= calibration.full_scale - 0.5:
        raise PalpateError(
            "a weight drives taxels to full scale; take a lighter one, or a wider body under it"
        )
    area = array.pitch[0] * array.pitch[1] * calibration.stiffness
    seen = []
    for frame, force in presses:
        image = correct(frame, calibration, array)
        depth, alive = repaired(image.depth, image.sigma)
        noise = float(np.sqrt(np.sum(image.sigma[alive] ** 2)))
        seen.append((area * float(np.sum(depth)) / force, area * noise / force))
    return _mean(np.array(seen))


def _mean(seen: Floats) -> Ratio:
    """Weighted, its sigma no less than what the scatter shows."""
    weight = 1.0 / np.maximum(seen[:, 1], 1e-12) ** 2
    value = float(np.sum(weight * seen[:, 0]) / weight.sum())
    own = 1.0 / float(np.sqrt(weight.sum()))
    chi2 = float(np.sum(weight * (seen[:, 0] - value) ** 2))
    return Ratio(value, own * float(np.sqrt(max(1.0, chi2 / max(1, len(seen) - 1)))))


def _step(image: TactileImage) -> tuple[float, float]:
    """Apparent height of the best step [mm], and its sigma."""
    soft, response = softened(image), response_of(image)
    x, y = np.meshgrid(image.array.x, image.array.y)
    live = np.isfinite(soft.sigma)
    x, y, depth, sigma = x[live], y[live], soft.depth[live], soft.sigma[live]

    def design(angle: float, offset: float) -> Floats:
        ca, sa = np.cos(angle), np.sin(angle)
        cover = response.edge(y * ca - x * sa - offset, response.width([-sa, ca]))
        return np.stack([np.ones_like(x), x, y, cover], axis=1) / sigma[:, None]

    def residual(p: Floats) -> Floats:
        matrix = design(p[0], p[1])
        rest: Floats = matrix @ np.linalg.lstsq(matrix, depth / sigma, rcond=None)[0] - depth / sigma
        return rest

    reach = 0.25 * min(image.array.size)
    starts = [(a, o) for a in np.arange(HEADINGS) * np.pi / HEADINGS for o in (-reach, 0.0, reach)]
    start = min(starts, key=lambda p: float(np.sum(residual(np.array(p)) ** 2)))
    fit = least_squares(residual, start, x_scale=[0.1, 1.0], loss="huber", f_scale=3.0)
    angle, offset = fit.x
    matrix = design(angle, offset)
    coefficients = np.linalg.lstsq(matrix, depth / sigma, rcond=None)[0]
    turns = [(design(angle + 1e-5, offset) - matrix) @ coefficients / 1e-5]
    turns.append((design(angle, offset + 1e-5) - matrix) @ coefficients / 1e-5)
    full = np.column_stack([matrix, *turns])
    covariance = np.linalg.pinv(full.T @ full) * max(1.0, 2 * float(fit.cost) / max(1, len(x) - 6))
    return abs(float(coefficients[3])), float(np.sqrt(covariance[3, 3]))
