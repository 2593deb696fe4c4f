"""How far lines lie from what is rounded: stated, for no single frame tells a rounding from more blur.

An edge between two perpendicular faces, rounded with radius r and pressed z0 deep, is felt to where the rounding
falls below the skin, a = sqrt(2 r z0 - z0^2) from where it begins (a = r for z0 > r).  The line lies where a
sharp edge would hold the same volume (our derivation: the blur's first moment),

    volume = r (z0 - r) + pi r^2 / 4          for z0 > r,
    volume = (r^2 asin(a/r) - a (r - z0)) / 2   otherwise,

so it lies r - volume/z0 inside the plane of the side face; 0.11, 0.39, 1.09, 1.88 and 3.53 mm for r of 0.5, 1, 2,
3 and 5 mm at 0.5 mm, right to 0.1 mm.

A cylinder of radius R on its side is felt over 2 sqrt(2 R z0 - z0^2), and indents the skin by a parabola, whose
variance is 3/5 of that of a wall as wide.  Where the blur hides which of the two it is, its two lines are
sqrt(3/5) of that width apart, evenly about the axis.
"""

from math import asin, pi, sqrt


def rounded_edge_shift(radius: float, depth: float) -> float:
    """[mm] by which the line of a rounded edge lies inside the plane of the side face."""
    if radius <= 0.0 or depth <= 0.0:
        return 0.0
    if depth > radius:
        return radius * radius * (1.0 - pi / 4.0) / depth
    a = sqrt(2.0 * radius * depth - depth * depth)
    volume = 0.5 * (radius * radius * asin(min(1.0, a / radius)) - a * (radius - depth))
    return radius - volume / depth


def cylinder_width(radius: float, depth: float) -> float:
    """[mm] between the two lines that a cylinder narrower than the pad is taken for."""
    return 2.0 * sqrt(0.6 * max(0.0, 2.0 * radius * depth - depth * depth))
