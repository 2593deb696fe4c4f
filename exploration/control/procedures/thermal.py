"""Thermal: rest on the surface and watch the skin's temperature settle (Dario's subroutine).

In contact the layer follows T(t) = T_object + (T_start - T_object) exp(-t / tau), which is fitted by least squares
(our derivation).

Property class: surface (temperature).
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from exploration.control.procedures.hardness import NotPressed
from exploration.devices.guard import Guard
from primitives.arrays import Floats

SERVES = "surface: temperature"
WITHOUT = "this array has no thermal layer, so it feels no temperature; choose one with [thermal] in its file"


@dataclass(frozen=True)
class Temperature:
    """What the object's surface settles to."""

    celsius: float
    sigma: float
    time_constant: float  # [s]


def thermal(guard: Guard, seconds: float = 2.0) -> Temperature | NotPressed:
    """From a contact; the pad stands still for `seconds`."""
    times, read = [], []
    for _ in range(max(8, round(seconds / guard.period))):
        seen = guard.hold()
        if seen.frame.temperature is None:
            return NotPressed(WITHOUT)
        times.append(seen.time)
        read.append(seen.frame.temperature)
    t, felt = np.array(times) - times[0], np.array(read)
    begin = np.array([float(felt[-1]), float(felt[0] - felt[-1]), np.log(seconds / 5.0)])

    def off(p: Floats) -> Floats:
        """Of the readings from the curve; without a difference tau is held near a fifth of the rest, faintly."""
        curve = p[0] + p[1] * np.exp(-t / np.exp(p[2])) - felt
        return np.append(curve, 1e-2 * (p[2] - begin[2]))

    fit = least_squares(off, begin)
    slopes = np.asarray(fit.jac, dtype=float)
    information: Floats = slopes.T @ slopes
    variance = float(np.mean(off(fit.x) ** 2)) * float(np.linalg.pinv(information)[0, 0])
    return Temperature(float(fit.x[0]), float(np.sqrt(variance)), float(np.exp(fit.x[2])))
