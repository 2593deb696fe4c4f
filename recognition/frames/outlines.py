"""Where a felt line or arc passes, and how sure: what every drawing of a frame needs.

A line's point at s along its direction moves across it by d rho + s d alpha, so its variance there is
C_rho rho + 2 s C_alpha rho + s^2 C_alpha alpha: the band is narrowest near what was seen.
"""

import numpy as np

from exploration.sensing.frame import TaxelArray
from exploration.sensing.lines.arc import Arc
from exploration.sensing.lines.line import Line, clipped
from primitives.arrays import Floats

BAND = 2.0  # [sigma]


def line_band(line: Line, array: TaxelArray, steps: int = 24) -> tuple[Floats, Floats]:
    """(n, 2) points [mm] of the line across the pad, and (n,) its sigma across there [mm]."""
    width, height = array.size
    low, high = clipped(line.angle, line.offset, (width / 2, height / 2))
    s = np.linspace(low, high, steps)
    variance = line.covariance[1, 1] + 2 * s * line.covariance[0, 1] + s**2 * line.covariance[0, 0]
    return line.offset * line.normal + s[:, None] * line.direction, np.sqrt(np.maximum(variance, 0.0))


def seen_part(line: Line, array: TaxelArray) -> Floats:
    """(2, 2) [mm] ends of what was seen, within the pad."""
    half = np.array(array.size) / 2
    return np.clip(np.stack([line.start, line.end]), -half, half)


def circle(arc: Arc, shift: float = 0.0, steps: int = 180) -> Floats:
    """(n, 2) points [mm] of the whole circle, of a radius `shift` greater."""
    turn = np.linspace(0.0, 2 * np.pi, steps)
    return arc.center + max(arc.radius + shift, 0.0) * np.stack([np.cos(turn), np.sin(turn)], axis=1)
