"""Features for a site: each draws its sizes and gives what to add and what to cut, or nothing where none fits.

All are in the site's frame, and leave `least` mm to the site's rim and below a blind bottom; what cuts stands
`_OUT` mm out of the face, what is added reaches `_IN` mm into it.
"""

from __future__ import annotations

from collections.abc import Callable
from math import cos, pi, sin
from typing import NamedTuple

import numpy as np

from models.csg import Cone, Csg, Cube, Cylinder, Prism, Sphere, Torus
from models.generation.sites import Site
from models.generation.sizes import drill, whole

_OUT = 1.0  # [mm]
_IN = 1.0  # [mm]


class Feature(NamedTuple):
    """What to add first and to cut then."""

    adds: Csg | None
    cuts: Csg | None


Maker = Callable[[np.random.Generator, Site, float], Feature | None]


def hole(rng: np.random.Generator, site: Site, least: float) -> Feature | None:
    """Round, through or blind."""
    radius, depth = drill(rng, site.room / 2 - least), _depth(rng, site, least)
    if radius is None or depth is None:
        return None
    return Feature(None, _bore(radius, depth).named("hole"))


def counterbore(rng: np.random.Generator, site: Site, least: float) -> Feature | None:
    """A through hole, wider at its top."""
    wide = drill(rng, site.room / 2 - least)
    narrow = None if wide is None else drill(rng, wide - least)
    depth = whole(rng, least, site.thickness - least)
    if not site.through or wide is None or narrow is None or depth is None:
        return None
    return Feature(None, (_bore(wide, depth) | _bore(narrow, site.thickness + _OUT)).named("counterbore"))


def countersink(rng: np.random.Generator, site: Site, least: float) -> Feature | None:
    """A through hole with a 90 degree cone at its top."""
    wide = drill(rng, site.room / 2 - least)
    narrow = None if wide is None else drill(rng, wide - least)
    if not site.through or wide is None or narrow is None or wide - narrow > site.thickness - least:
        return None
    deep = wide - narrow + min(narrow, 1.0)
    sink = Cone(wide - deep, wide + _OUT, deep + _OUT) if wide > deep else Cone(0, wide + _OUT, deep + _OUT)
    return Feature(
        None, (sink.at(0, 0, (_OUT - deep) / 2) | _bore(narrow, site.thickness + _OUT)).named("countersink")
    )


def slot(rng: np.random.Generator, site: Site, least: float) -> Feature | None:
    """A groove with round ends, through or blind."""
    long, across = max(site.width, site.length), site.room
    radius, depth = drill(rng, min(across / 2 - least, long / 4)), _depth(rng, site, least)
    if radius is None or depth is None or radius < least / 2:
        return None
    span = whole(rng, max(least, radius), long - 2 * radius - 2 * least)
    if span is None:
        return None
    ends = [_bore(radius, depth).at(x, 0, 0) for x in (-span / 2, span / 2)]
    cut = Cube((span, 2 * radius, depth + _OUT)).at(0, 0, (_OUT - depth) / 2) | ends[0] | ends[1]
    return Feature(None, _along(cut, site).named("slot"))


def pocket(rng: np.random.Generator, site: Site, least: float) -> Feature | None:
    """Rectangular and blind."""
    width, length = (whole(rng, 2 * least, side - 2 * least) for side in (site.width, site.length))
    depth = whole(rng, least, min(site.thickness - least, 30.0))
    if width is None or length is None or depth is None:
        return None
    return Feature(None, Cube((width, length, depth + _OUT), name="pocket").at(0, 0, (_OUT - depth) / 2))


def boss(rng: np.random.Generator, site: Site, least: float) -> Feature | None:
    """Round or tapered, perhaps with a blind hole."""
    radius = drill(rng, site.room / 2 - least)
    height = whole(rng, 2 * least, 25.0)
    if not site.raised or radius is None or height is None or radius < least:
        return None
    tapered = radius >= 2 * least and rng.random() < 0.3
    body: Csg = Cone(radius, radius - least, height) if tapered else Cylinder(radius, height + _IN)
    body = body.at(0, 0, height / 2 if tapered else (height - _IN) / 2).named("boss")
    inner = drill(rng, radius - 2 * least) if rng.random() < 0.5 else None
    cut = None if inner is None else _bore(inner, height - least).at(0, 0, height).named("boss hole")
    return Feature(body, cut)


def block(rng: np.random.Generator, site: Site, least: float) -> Feature | None:
    """A raised rectangle."""
    width, length = (whole(rng, 2 * least, side - 2 * least) for side in (site.width, site.length))
    height = whole(rng, least, 20.0)
    if not site.raised or width is None or length is None or height is None:
        return None
    return Feature(Cube((width, length, height + _IN), name="pad").at(0, 0, (height - _IN) / 2), None)


def dome(rng: np.random.Generator, site: Site, least: float) -> Feature | None:
    """A cap of a ball, standing out or sunk in."""
    radius = drill(rng, site.room / 2 - least)
    if radius is None or radius < 2 * least:
        return None
    height = whole(rng, least, radius * 0.8)
    if height is None:
        return None
    ball = (radius**2 + height**2) / (2 * height)
    sunk = rng.random() < 0.4 and height <= site.thickness - least
    if sunk:
        clip = Cylinder(radius + 1, height + 2 * _OUT).at(0, 0, -height / 2)
        return Feature(None, (Sphere(ball).at(0, 0, ball - height) & clip).named("hollow"))
    if not site.raised:
        return None
    cap = Sphere(ball) & Cylinder(radius + 1, height + _IN + 1).at(
        0, 0, ball - height + (height - _IN + 1) / 2
    )
    inside = ball > radius + _IN and height + _IN < ball
    return Feature(cap.at(0, 0, height - ball).named("dome"), None) if inside else None


def hexagon(rng: np.random.Generator, site: Site, least: float) -> Feature | None:
    """A hexagonal boss or socket."""
    radius = drill(rng, site.room / 2 - least)
    depth = whole(rng, least, min(site.thickness - least, 20.0))
    if radius is None or depth is None or radius < 2 * least:
        return None
    outline = tuple(
        (round(radius * cos(k * pi / 3), 9), round(radius * sin(k * pi / 3), 9)) for k in range(6)
    )
    if not site.raised or rng.random() < 0.5:
        return Feature(None, Prism(outline, depth + _OUT, name="hexagon").at(0, 0, (_OUT - depth) / 2))
    return Feature(Prism(outline, depth + _IN, name="hexagon").at(0, 0, (depth - _IN) / 2), None)


def ring_groove(rng: np.random.Generator, site: Site, least: float) -> Feature | None:
    """A groove of half-round section that runs in a circle."""
    tube = whole(rng, least / 2, min(5.0, site.thickness - least, site.room / 8))
    major = None if tube is None else drill(rng, site.room / 2 - least - tube)
    if tube is None or major is None or major < tube + least:
        return None
    return Feature(None, Torus(major, tube, name="groove"))


def pattern(rng: np.random.Generator, site: Site, least: float) -> Feature | None:
    """Two to six of the same hole in rows and columns."""
    columns, rows = (int(np.clip(rng.integers(1, 4), 1, side // 10)) for side in (site.width, site.length))
    if columns * rows < 2:
        return None
    cells = site.cells(columns, rows)
    first = (hole, counterbore, countersink, hexagon)[int(rng.integers(4))](rng, cells[0], least)
    if not first or first.cuts is None:
        return None
    shifts = [(c.part_from_site - site.part_from_site)[:3, 3] @ site.part_from_site[:3, :3] for c in cells]
    copies = [first.cuts.at(*(float(s) for s in np.round(shift, 9))) for shift in shifts]
    cut: Csg = copies[0]
    for copy in copies[1:]:
        cut = cut | copy
    return Feature(None, cut)


FEATURES: tuple[tuple[Maker, float], ...] = (
    (hole, 4.0),
    (pattern, 2.5),
    (boss, 2.0),
    (pocket, 1.5),
    (slot, 1.5),
    (counterbore, 1.5),
    (countersink, 1.0),
    (block, 1.0),
    (dome, 1.0),
    (hexagon, 1.0),
    (ring_groove, 0.7),
)


def _bore(radius: float, depth: float) -> Csg:
    return Cylinder(radius, depth + _OUT).at(0, 0, (_OUT - depth) / 2)


def _depth(rng: np.random.Generator, site: Site, least: float) -> float | None:
    if site.through and rng.random() < 0.6:
        return site.thickness + _OUT
    return whole(rng, least, min(site.thickness - least, 40.0))


def _along(tree: Csg, site: Site) -> Csg:
    return tree if site.width >= site.length else tree.turned("z", pi / 2)
