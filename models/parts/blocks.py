"""Built-in parts milled from a block: vees, slots, pockets, bearings and a hollow."""

from math import pi

from models.csg import Csg, Cube, Cylinder, Polyhedron, Prism, Sphere
from models.parts.outlines import hexagon


def v_block() -> Csg:
    """A block with a vee across its top and a relief slot under it."""
    vee = Prism(((-30, 30), (0, 0), (30, 30)), 99, name="vee").turned("x", pi / 2)
    return Cube((80, 60, 50)) - vee - Cube((6, 99, 12), name="relief").at(0, 0, 0)


def t_slot_block() -> Csg:
    """A block with a T-slot along it."""
    block = Cube((60, 90, 40))
    return block - Cube((14, 99, 30), name="neck").at(0, 0, 15) - Cube((28, 99, 12), name="tee").at(0, 0, 2)


def dovetail_block() -> Csg:
    """A block with a dovetail groove along it."""
    tail = Prism(((-24, 0), (24, 0), (14, 16), (-14, 16)), 99, name="dovetail").turned("x", pi / 2)
    return Cube((80, 60, 36)).at(0, 0, -3) - tail


def bearing_block() -> Csg:
    """A pillow block: a bored housing on a foot with two bolt holes."""
    foot = Cube((120, 40, 14)).at(0, 0, 7) | Cube((44, 40, 40)).at(0, 0, 20)
    housing = foot | _along_y(30, 40).at(0, 0, 45)
    part = housing - _along_y(18, 60, "bore").at(0, 0, 45)
    return part - Cylinder(6, 30).at(-47, 0, 7) - Cylinder(6, 30).at(47, 0, 7)


def bearing_block_wide_bore() -> Csg:
    """The pillow block, but with a bore 2 mm wider."""
    foot = Cube((120, 40, 14)).at(0, 0, 7) | Cube((44, 40, 40)).at(0, 0, 20)
    housing = foot | _along_y(30, 40).at(0, 0, 45)
    part = housing - _along_y(19, 60, "bore").at(0, 0, 45)
    return part - Cylinder(6, 30).at(-47, 0, 7) - Cylinder(6, 30).at(47, 0, 7)


def cavity_block() -> Csg:
    """A block with a round cavity behind a narrow opening."""
    return Cube((60, 60, 60)) - Sphere(20, name="cavity") - Cylinder(7, 40, name="opening").at(0, 0, 25)


def pocket_plate() -> Csg:
    """A plate with a square pocket, an island left in it, and a hole through that."""
    pocket = Cube((70, 50, 20), name="pocket").at(0, 0, 7) - Cylinder(14, 40, name="island")
    return Cube((90, 70, 16)) - pocket - Cylinder(6, 40, name="hole")


def stepped_wedge() -> Csg:
    """A ramp with two steps cut into it."""
    ramp = Prism(((-50, 0), (50, 0), (50, 12), (-50, 48)), 40).turned("x", pi / 2)
    return ramp - Cube((30, 99, 40)).at(40, 0, 35) - Cube((30, 99, 40)).at(12, 0, 47)


def pyramid_stand() -> Csg:
    """A pyramid cut off below its apex, on a square foot, with a blind hole."""
    low, high = ((-25, -25), (25, -25), (25, 25), (-25, 25)), ((-12, -12), (12, -12), (12, 12), (-12, 12))
    points = (*((x, y, 10.0) for x, y in low), *((x, y, 55.0) for x, y in high))
    sides = tuple((k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4) for k in range(4))
    body = Polyhedron(points, ((3, 2, 1, 0), (4, 5, 6, 7), *sides))
    return (Cube((70, 70, 10)).at(0, 0, 5) | body) - Cylinder(6, 40, name="blind hole").at(0, 0, 50)


def die_holder() -> Csg:
    """A round-cornered block with a hexagonal hole through it."""
    body = Cube((80, 80, 30)) & Cylinder(50, 60)
    return body - Prism(hexagon(36), 60, name="hexagon")


def _along_y(radius: float, length: float, name: str = "") -> Csg:
    return Cylinder(radius, length, name=name).turned("x", pi / 2)
