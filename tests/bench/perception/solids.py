"""What is pressed: each solid's touched face is z = 0 of its frame, material below; made once, kept.

Round ones are faceted in proportion to their radius, so that one a little larger has
the same facets and differences between the two are of size alone.
"""

from functools import lru_cache

import numpy as np

from models.csg import Csg, Cube, Cylinder, Prism, Torus
from models.solid import Solid
from primitives.arrays import Ints

FAR = 150.0  # [mm] to edges that are not meant to be seen
THICK = 30.0  # [mm]
ROUND = 4e-5  # of the radius, between a facet and a circle
TURNED = 2e-6  # of the radius, between a facet and a bar on its side: 1 um at R 500
RINGS = 40  # of facets on a ball: less than 0.5 um from it
CAP_DEPTH = 1.5  # [mm] of a ball that is made
Outline = tuple[tuple[float, float], ...]


def _solid(tree: Csg, tolerance: float = 0.002) -> Solid:
    return Solid.from_csg(tree, tolerance)


def _plate(outline: Outline) -> Csg:
    return Prism(outline, THICK).at(0, 0, -THICK / 2)


@lru_cache
def flat() -> Solid:
    """A face without an end."""
    return _solid(_plate(((-FAR, -FAR), (FAR, -FAR), (FAR, FAR), (-FAR, FAR))))


@lru_cache
def edge(dihedral: float) -> Solid:
    """A straight edge along x, material at y > 0; `dihedral` [deg] between the two faces."""
    run = THICK / np.tan(np.radians(180.0 - dihedral)) if dihedral != 90.0 else 0.0
    section = ((0.0, 0.0), (-run, -THICK), (FAR, -THICK), (FAR, 0.0))
    return _solid(Prism(section, 2 * FAR).placed(_SECTION_ACROSS_X))


_SECTION_ACROSS_X = np.array([[0.0, 0, 1, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 0, 1]])


@lru_cache(maxsize=64)
def corner(opening: float) -> Solid:
    """Two edges from the origin: along x, and at `opening` [rad] from it; material between them."""
    c, s = FAR * np.cos(opening), FAR * np.sin(opening)
    return _solid(_plate(((0.0, 0.0), (FAR, 0.0), (FAR + c, s), (c, s))))


@lru_cache(maxsize=64)
def wall(width: float, taper: float = 0.0) -> Solid:
    """Material between y = -width/2 and width/2, wider by `taper` [rad] times x; its first edge stays."""
    left, right = width / 2 - FAR * np.tan(taper), width / 2 + FAR * np.tan(taper)
    return _solid(_plate(((-FAR, -width / 2), (FAR, -width / 2), (FAR, right), (-FAR, left))))


@lru_cache(maxsize=64)
def slot(width: float, taper: float = 0.0) -> Solid:
    """A gap between y = -width/2 and width/2, wider by `taper` [rad] times x; its first edge stays."""
    left, right = width / 2 - FAR * np.tan(taper), width / 2 + FAR * np.tan(taper)
    below = _plate(((-FAR, -FAR), (FAR, -FAR), (FAR, -width / 2), (-FAR, -width / 2)))
    return _solid(below | _plate(((-FAR, left), (FAR, right), (FAR, FAR), (-FAR, FAR))))


@lru_cache(maxsize=64)
def bar_end(width: float, first: float = np.pi / 2, second: float = np.pi / 2) -> Solid:
    """Three edges with corners at (0, -width/2) and (0, width/2), material at x > 0 between.

    `first` and `second` [rad] are the angles of material in the two corners.
    """
    low = (FAR * np.sin(first), -width / 2 + FAR * np.cos(first))
    high = (FAR * np.sin(second), width / 2 - FAR * np.cos(second))
    return _solid(_plate(((0.0, -width / 2), low, high, (0.0, width / 2))))


@lru_cache(maxsize=64)
def chamfered(width: float, opening: float = np.pi / 2, cut: float = np.pi / 4) -> Solid:
    """A corner at the origin, its second edge at `opening` [rad] from the first, cut off.

    Three edges, the middle one `width` [mm] long and at `cut` [rad] to the first.
    """
    a, b = chamfer_ends(width, opening, cut)
    c, s = FAR * np.cos(opening), FAR * np.sin(opening)
    return _solid(_plate(((a, 0.0), (FAR, 0.0), (FAR + c, s), (c, s), b)))


def chamfer_ends(width: float, opening: float, cut: float) -> tuple[float, tuple[float, float]]:
    """Where the cut begins, x on the first edge, and ends, (x, y) on the second (the law of sines)."""
    a = width * np.sin(opening + cut) / np.sin(opening)
    b = width * np.sin(cut) / np.sin(opening)
    return float(a), (float(b * np.cos(opening)), float(b * np.sin(opening)))


@lru_cache(maxsize=96)
def disc(radius: float) -> Solid:
    """A boss whose rim passes the origin, its center at y = radius."""
    return _solid(Cylinder(radius, THICK).at(0, radius, -THICK / 2), ROUND * radius)


@lru_cache(maxsize=96)
def hole(radius: float) -> Solid:
    """A hole in a plate, its rim and center as a boss's."""
    far = 2 * FAR + 2 * radius
    plate = Cube((far, far, THICK)).at(0, radius, -THICK / 2)
    return _solid(plate - Cylinder(radius, 3 * THICK).at(0, radius, 0), ROUND * radius)


@lru_cache(maxsize=64)
def ball(radius: float) -> Solid:
    """A spherical cap that rises to z = 0 and reaches `CAP_DEPTH` down, on a stem."""
    reach = min(0.95 * radius, np.sqrt(2 * radius * CAP_DEPTH) + 2.0)
    rings = [np.arange(6 * k) * 2 * np.pi / max(1, 6 * k) for k in range(1, RINGS + 1)]
    rho = np.concatenate([[0.0], *[np.full(6 * k, reach * k / RINGS) for k in range(1, RINGS + 1)]])
    phi = np.concatenate([[0.0], *rings])
    top = np.stack([rho * np.cos(phi), rho * np.sin(phi), np.sqrt(radius**2 - rho**2) - radius], axis=1)
    cap = _rings_joined(RINGS)
    rim = np.arange(len(top) - 6 * RINGS, len(top))
    foot = np.concatenate([top[rim, :2], np.full((len(rim), 1), -radius - THICK)], axis=1)
    down = len(top) + np.arange(len(rim))
    right, right_down = np.roll(rim, -1), np.roll(down, -1)
    side = np.concatenate([np.stack([rim, down, right], 1), np.stack([right, down, right_down], 1)])
    center = len(top) + len(rim)
    bottom = np.stack([right_down, down, np.full(len(rim), center)], 1)
    points = np.concatenate([top, foot, [[0.0, 0.0, -radius - THICK]]])
    return Solid.from_mesh(points, np.concatenate([cap, side, bottom]))


def _rings_joined(rings: int) -> Ints:
    """Triangles between rings of 6, 12, 18... points round a middle one, counterclockwise."""
    out = []
    for k in range(1, rings + 1):
        inner, outer = 1 + 3 * (k - 1) * (k - 2), 1 + 3 * k * (k - 1)
        for sector in range(6):
            for j in range(k):
                a = outer + sector * k + j
                b = outer + (sector * k + j + 1) % (6 * k)
                near = 0 if k == 1 else inner + (sector * (k - 1) + j) % (6 * (k - 1))
                out.append((near, a, b))
                if j < k - 1:
                    out.append((near, b, inner + (sector * (k - 1) + j + 1) % (6 * (k - 1))))
    return np.array(out)


@lru_cache(maxsize=64)
def bar(radius: float) -> Solid:
    """A cylinder along x that rises to z = 0."""
    return _solid(Cylinder(radius, 2 * FAR).turned("y", np.pi / 2).at(0, 0, -radius), TURNED * radius)


@lru_cache(maxsize=64)
def ring(radius: float, tube: float, around: float) -> Solid:
    """A ring whose tube runs along x at the origin and rises to z = 0 there; it bends towards greater y.

    What lies uppermost is `around` [rad] from the ring's crest, towards its outside.
    """
    tree = Torus(radius, tube).at(0, radius, 0).turned("x", -around).at(0, 0, -tube)
    return _solid(tree, 1e-4 * tube)
