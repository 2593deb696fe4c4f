"""Bodies that features are put on: each draws its sizes and gives its tree with the sites that are free on it."""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from typing import NamedTuple

import numpy as np

from models.csg import Cone, Csg, Cube, Cylinder, Prism, Sphere, Torus
from models.generation.sites import Site, facing
from models.generation.sizes import drill, stock, whole


class Base(NamedTuple):
    """A body on z = 0 and what is free on it."""

    tree: Csg
    sites: tuple[Site, ...]


Maker = Callable[[np.random.Generator, float, float], Base]


def block(rng: np.random.Generator, largest: float, least: float) -> Base:
    """A block, perhaps with one edge chamfered; features on top and on one side."""
    x, y, z = (stock(rng, 20.0, 0.6 * largest) for _ in range(3))
    kept = 0.25 * x if x >= 40 and rng.random() < 0.5 else 0.0
    kept = float(round(kept))
    tree: Csg = Cube((x, y, z)).at(0, 0, z / 2)
    cut = whole(rng, least, min(8.0, 0.15 * y, 0.3 * z)) if rng.random() < 0.4 else None
    if cut is not None:
        corner = Prism(((0, 1), (-cut - 1, 1), (1, -cut - 1), (1, 1)), x + 4, name="chamfer")
        tree = tree - corner.turned("x", pi / 2).turned("z", pi / 2).at(0, y / 2, z)
    room = y - 2 * (cut or 0.0)
    top = Site(facing(-kept / 2, 0, z), x - kept, room, z, True)
    sides = (
        [Site(facing(x / 2, 0, z / 2, "x"), room, z - 2 * (cut or 0.0), kept - least, False)] if kept else []
    )
    return Base(tree, (top, *sides))


def plate(rng: np.random.Generator, largest: float, least: float) -> Base:
    """A plate, perhaps with its corners cut."""
    x, y, z = stock(rng, 50.0, largest), stock(rng, 40.0, 0.7 * largest), stock(rng, 5.0, 15.0)
    cut = whole(rng, 2 * least, 0.2 * min(x, y)) if rng.random() < 0.4 else None
    if cut is None:
        return Base(Cube((x, y, z)).at(0, 0, z / 2), (Site(facing(0, 0, z), x, y, z, True),))
    a, b = x / 2, y / 2
    outline = ((a, -b), (a, b - cut), (a - cut, b), (cut - a, b), (-a, b - cut), (-a, -b))
    site = Site(facing(0, -cut / 2, z), x, y - cut, z, True)
    return Base(Prism(outline, z).at(0, 0, z / 2), (site,))


def cylinder(rng: np.random.Generator, largest: float, least: float) -> Base:
    """A round body, perhaps with a shoulder, a flat or a round groove."""
    radius, height = stock(rng, 10.0, 0.3 * largest), stock(rng, 20.0, 0.6 * largest)
    tree: Csg = Cylinder(radius, height).at(0, 0, height / 2)
    kind, up = int(rng.integers(4)), float(round(height / 3))
    if kind == 1:
        wide, rise = radius + float(rng.integers(3, 9)), max(float(round(height / 4)), 2 * least)
        tree = tree | Cylinder(wide, rise, name="shoulder").at(0, 0, rise / 2)
    elif kind == 2 and radius > 4 * least:
        tree = tree - Torus(radius, float(rng.integers(2, 5)), name="groove").at(0, 0, up)
    elif kind == 3 and radius > 4 * least:
        flat = Cube((2 * radius, 4 * radius, 0.4 * height + 2), name="flat")
        tree = tree - flat.at(1.75 * radius, 0, 0.8 * height + 1)
    free = round(radius * (1.0 if kind == 3 else 1.4))
    thickness = height if kind != 2 else 2 * up - 6.0
    return Base(tree, (Site(facing(0, 0, height), free, free, thickness, kind != 2),))


def flange(rng: np.random.Generator, largest: float, least: float) -> Base:
    """A disc with a bored hub and a circle of bolt holes."""
    hub = stock(rng, 10.0, 0.15 * largest)
    bolt = float(rng.choice([3.0, 4.0, 5.0, 6.0]))
    rim = hub + 2 * bolt + 4 * least + 1.0
    disc, height = stock(rng, 5.0, 15.0), stock(rng, 20.0, 0.3 * largest)
    part: Csg = Cylinder(rim, disc).at(0, 0, disc / 2) | Cylinder(hub, height, name="hub").at(
        0, 0, height / 2
    )
    bore = drill(rng, hub - 2 * least)
    if bore is not None:
        part = part - Cylinder(bore, height + 4, name="bore").at(0, 0, height / 2)
    count, out = int(rng.choice([2, 3, 4, 6])), (hub + rim) / 2
    for i in range(count):
        hole = Cylinder(bolt, disc + 4, name=f"bolt hole {i + 1}").at(out, 0, disc / 2)
        part = part - hole.turned("z", 2 * pi * i / count)
    return Base(part, ())


def l_bracket(rng: np.random.Generator, largest: float, least: float) -> Base:
    """Two plates at a right angle, perhaps with a rib; features on both."""
    x, y, z = (
        stock(rng, 40.0, 0.6 * largest),
        stock(rng, 30.0, 0.5 * largest),
        stock(rng, 30.0, 0.6 * largest),
    )
    t = stock(rng, 5.0, 12.0)
    tree: Csg = Cube((x, y, t)).at(0, 0, t / 2) | Cube((t, y, z)).at((t - x) / 2, 0, z / 2)
    foot = Site(facing(t / 2, 0, t), x - t, y, t, True)
    upright = Site(facing(t - x / 2, 0, (z + t) / 2, "x"), y, z - t, t, True, raised=False)
    if rng.random() < 0.4 and y >= 40:
        reach, rib = float(round(0.6 * (min(x, z) - t))), max(2 * least, 5.0)
        wall, corner = t - x / 2, t
        outline = (
            (wall - 1, corner - 1),
            (wall + reach, corner - 1),
            (wall + reach, corner),
            (wall, corner + reach),
            (wall - 1, corner + reach),
        )
        tree = tree | Prism(outline, rib, name="rib").turned("x", pi / 2)
        half = float((y - rib) // 2)
        foot, upright = (
            foot.part(0, (y - half) / 2, x - t, half),
            upright.part((half - y) / 2, 0, half, z - t),
        )
    return Base(tree, (foot, upright))


def t_bracket(rng: np.random.Generator, largest: float, least: float) -> Base:
    """A foot with a web on its middle; features on both sides of the web and on it."""
    x, y, z = (
        stock(rng, 60.0, 0.8 * largest),
        stock(rng, 30.0, 0.5 * largest),
        stock(rng, 30.0, 0.5 * largest),
    )
    t = stock(rng, 5.0, 12.0)
    tree = Cube((x, y, t)).at(0, 0, t / 2) | Cube((t, y, z), name="web").at(0, 0, z / 2)
    half = float((x - t) // 2)
    feet = [Site(facing(side * (t + half) / 2, 0, t), half, y, t, True) for side in (-1, 1)]
    return Base(tree, (*feet, Site(facing(t / 2, 0, (z + t) / 2, "x"), y, z - t, t, True, raised=False)))


def channel(rng: np.random.Generator, largest: float, least: float) -> Base:
    """A U; features on its floor and on one wall."""
    x, y, z = (
        stock(rng, 40.0, 0.5 * largest),
        stock(rng, 40.0, 0.6 * largest),
        stock(rng, 25.0, 0.4 * largest),
    )
    t = stock(rng, 5.0, 10.0)
    a = x / 2
    outline = ((-a, 0), (a, 0), (a, z), (a - t, z), (a - t, t), (t - a, t), (t - a, z), (-a, z))
    wall = Site(facing(a, 0, (z + t) / 2, "x"), y, z - t, t, True, raised=False)
    floor = Site(facing(0, 0, t), x - 2 * t, y, t, True)
    return Base(Prism(outline, y).turned("x", pi / 2), (floor, wall))


def cone(rng: np.random.Generator, largest: float, least: float) -> Base:
    """A frustum on a foot; features on its top."""
    low, height = stock(rng, 15.0, 0.25 * largest), stock(rng, 20.0, 0.4 * largest)
    high = max(10.0, float(round(low * rng.uniform(0.4, 0.8))))
    foot, rise = low + float(rng.integers(4, 15)), stock(rng, 5.0, 12.0)
    tree = Cylinder(foot, rise).at(0, 0, rise / 2) | Cone(low, high, height).at(0, 0, rise + height / 2)
    return Base(
        tree, (Site(facing(0, 0, rise + height), round(1.4 * high), round(1.4 * high), rise + height, True),)
    )


def ball_post(rng: np.random.Generator, largest: float, least: float) -> Base:
    """A post with a ball at its end, on a square foot; features on the foot."""
    side, t = stock(rng, 50.0, 0.5 * largest), stock(rng, 6.0, 15.0)
    radius, height = float(round(side / 6)), stock(rng, 20.0, 0.3 * largest)
    ball = float(round(1.25 * radius + 1))
    post = Cylinder(radius, height + t).at(0, 0, (height + t) / 2) | Sphere(ball).at(0, 0, height + t + 2)
    room = float((side / 2 - ball) // 1) - least
    sites = [Site(facing(end * (side - room) / 2, 0, t), room, side, t, True) for end in (-1, 1)]
    return Base(Cube((side, side, t)).at(0, 0, t / 2) | post, tuple(sites))


BASES: tuple[tuple[Maker, float], ...] = (
    (block, 3.0),
    (plate, 3.0),
    (cylinder, 2.0),
    (flange, 1.5),
    (l_bracket, 2.0),
    (t_bracket, 1.5),
    (channel, 1.0),
    (cone, 1.0),
    (ball_post, 1.0),
)
