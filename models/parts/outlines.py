"""Outlines that several parts share, as corners in x and y."""

from math import cos, pi, sin

Outline = tuple[tuple[float, float], ...]


def hexagon(across_flats: float) -> Outline:
    """A regular hexagon with two flats across x [mm]."""
    radius = across_flats / 3**0.5
    return tuple(_polar(radius, k * pi / 3) for k in range(6))


def gear(teeth: int, root: float, tip: float) -> Outline:
    """Straight-sided teeth between a root and a tip radius [mm], half as wide at the tip as at the root."""
    step = 2 * pi / teeth
    tooth = ((root, -0.25), (tip, -0.125), (tip, 0.125), (root, 0.25))
    return tuple(_polar(r, (k + s) * step) for k in range(teeth) for r, s in tooth)


def _polar(radius: float, angle: float) -> tuple[float, float]:
    return round(radius * cos(angle), 9) + 0.0, round(radius * sin(angle), 9) + 0.0
