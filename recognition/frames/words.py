"""A felt frame in words: the lines of text that pictures and terminal share."""

from math import degrees, isfinite, sqrt

import numpy as np

from exploration.recordings.recording import Pad
from exploration.sensing.lines.arc import Arc
from exploration.sensing.lines.line import Line
from exploration.sensing.surfaces.local_surface import LocalSurface
from recognition.frames.felt import Felt

STRAIGHT = 1e-3  # [1/mm] below it no radius is told


def unit_of(pad: Pad) -> str:
    """The unit of length."""
    return "taxel" if pad.assumed_pitch else "mm"


def title(felt: Felt, pad: Pad) -> str:
    """Which frame."""
    when = f", {felt.time:.3f} s" if isfinite(felt.time) else ""
    return f"frame {felt.index}{when}, pad {felt.pad}: {pad.array.name}"


def verdict(felt: Felt) -> str:
    """What it is, and how sure."""
    if felt.unreadable:
        return f"nothing ({felt.unreadable})"
    return f"{felt.touch.kind} {100 * felt.touch.kinds[felt.touch.kind]:.0f} %"


def line_words(line: Line, unit: str) -> tuple[str, str, str]:
    """Angle, offset, length."""
    angle, offset = sqrt(float(line.covariance[0, 0])), sqrt(float(line.covariance[1, 1]))
    return (
        f"{degrees(line.angle):.1f} ± {degrees(angle):.1f}°",
        f"{line.offset:+.2f} ± {offset:.2f} {unit}",
        f"{line.length:.1f} {unit}",
    )


def arc_words(arc: Arc, unit: str) -> str:
    """Radius and center."""
    what = "disc" if arc.material_inside else "hole"
    x, y = arc.center
    return f"{what}, R {arc.radius:.2f} ± {arc.radius_sigma:.2f} {unit} about ({x:.1f}, {y:.1f})"


def curvature_words(felt: Felt, pad: Pad) -> str:
    """The radii of the two principal curvatures."""
    surface = felt.touch.surface
    if pad.spec is None:
        return "not known without gains"
    if not isinstance(surface, LocalSurface):
        return "none"
    if not surface.curved or np.abs(surface.curvature).max() < STRAIGHT:
        return "flat"
    return ", ".join(radius_words(float(value)) for value in surface.principal[0])


def force_words(felt: Felt, pad: Pad) -> str:
    """The force."""
    return "not known without gains" if pad.spec is None else f"{felt.touch.force:.2f} N"


def radius_words(curvature: float) -> str:
    """A curvature [1/mm] as its radius."""
    if abs(curvature) < STRAIGHT:
        return "straight"
    return f"R {abs(1 / curvature):.3g} mm{'' if curvature > 0 else ' hollow'}"
