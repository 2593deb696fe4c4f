"""Where a ball of known radius sits before the pad, from one press of it.

A ball of radius R whose center is at (x0, y0, R - d) indents the skin by

    depth(x, y) = sqrt(R^2 - (x - x0)^2 - (y - y0)^2) - R + d     where that is positive, on the skin,

which the rubber spreads (a Gaussian of `spread`) and the taxels average.  x0, y0 and d are fitted by least squares
on a grid finer than the taxels; their covariance is that of the fit, times chi2 / dof where the model does not fit
to the noise (our derivation).
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import gaussian_filter
from scipy.optimize import least_squares

from exploration.sensing.calibration import Calibration, correct
from exploration.sensing.frame import TaxelArray, TaxelFrame
from primitives.arrays import Floats, frozen

_FINE = 5  # cells of the grid to a taxel, along each side
_LEAST_DEPTH = 5.0  # of a press's deepest taxel, over its sigma


@dataclass(frozen=True)
class BallPress:
    """A ball before the pad: its center is at (x, y, radius - depth) in the sensor's frame."""

    place: Floats  # (3,) x, y, depth [mm]
    sigma: Floats  # (3,) [mm]
    radius: float  # [mm]


@dataclass(frozen=True)
class NoBall:
    """Why none was seen; false in a condition."""

    reason: str

    def __bool__(self) -> bool:
        return False


def ball_of(
    press: TaxelFrame, radius: float, calibration: Calibration, array: TaxelArray
) -> BallPress | NoBall:
    """The ball of `radius` [mm] in a press."""
    image = correct(press, calibration, array)
    live = np.isfinite(image.sigma)
    deepest = np.unravel_index(int(np.argmax(np.where(live, image.depth / image.sigma, -1.0))), array.shape)
    if image.depth[deepest] < _LEAST_DEPTH * image.sigma[deepest]:
        return NoBall("the ball was not felt; press it further")
    model = _Model(array, calibration, radius)
    weight = 1.0 / image.sigma[live]

    def residual(p: Floats) -> Floats:
        return np.asarray((model.depth(p)[live] - image.depth[live]) * weight)

    start = [float(array.x[deepest[1]]), float(array.y[deepest[0]]), 1.3 * float(image.depth[deepest])]
    fit = least_squares(residual, start, x_scale=[1.0, 1.0, 0.1], diff_step=[1e-3] * 3)
    x0, y0, depth = fit.x
    rim = np.sqrt(2.0 * radius * max(depth, 0.0))
    if abs(x0) + 0.5 * rim > array.size[0] / 2 or abs(y0) + 0.5 * rim > array.size[1] / 2:
        return NoBall("the ball was felt at the pad's rim; press it nearer the middle")
    spare = max(1, int(live.sum()) - 3)
    jacobian = np.asarray(fit.jac)
    covariance = np.linalg.pinv(jacobian.T @ jacobian) * max(1.0, 2.0 * float(fit.cost) / spare)
    return BallPress(frozen(fit.x), frozen(np.sqrt(np.diag(covariance))), radius)


class _Model:
    """The indentation of a ball as the taxels feel it."""

    def __init__(self, array: TaxelArray, calibration: Calibration, radius: float) -> None:
        self._radius, self._shape = radius, array.shape
        step = np.array(array.pitch) / _FINE
        reach = min(calibration.margin, 4.0 * calibration.spread)
        self._past = np.ceil(reach / step).astype(int)
        x, y = (
            self._cells(n, s, past) for n, s, past in zip(array.shape[::-1], step, self._past, strict=True)
        )
        self._x, self._y = np.meshgrid(x, y)
        self._blur = calibration.spread / step[::-1]

    @staticmethod
    def _cells(taxels: int, step: float, past: int) -> Floats:
        count = taxels * _FINE + 2 * past
        return np.asarray((np.arange(count) - (count - 1) / 2) * step)

    def depth(self, p: Floats) -> Floats:
        """(rows, columns) [mm] for x0, y0 and d."""
        square = self._radius**2 - (self._x - p[0]) ** 2 - (self._y - p[1]) ** 2
        pressed = np.maximum(np.sqrt(np.maximum(square, 0.0)) - self._radius + p[2], 0.0)
        spread = gaussian_filter(pressed, self._blur, mode="constant")
        px, py = self._past
        rows, columns = self._shape
        inner = spread[py : py + rows * _FINE, px : px + columns * _FINE]
        return np.asarray(inner.reshape(rows, _FINE, columns, _FINE).mean(axis=(1, 3)))
