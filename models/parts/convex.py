"""Convex built-in parts: single primitives, and intersections of two."""

from math import pi

from models.csg import Cone, Csg, Cube, Cylinder, Prism, Sphere
from models.parts.outlines import hexagon


def block() -> Csg:
    """A flat rectangular block."""
    return Cube((60, 40, 12))


def cube() -> Csg:
    """A cube."""
    return Cube((40, 40, 40))


def brick() -> Csg:
    """A long brick."""
    return Cube((90, 45, 30))


def cylinder() -> Csg:
    """A short round bar."""
    return Cylinder(20, 40)


def rod() -> Csg:
    """A long round bar."""
    return Cylinder(12, 110)


def disc() -> Csg:
    """A thick disc."""
    return Cylinder(35, 15)


def frustum() -> Csg:
    """A cone cut off below its apex."""
    return Cone(25, 12, 35)


def cone() -> Csg:
    """A cone to the apex."""
    return Cone(25, 0, 50)


def sphere() -> Csg:
    """A ball."""
    return Sphere(25)


def d_shaft() -> Csg:
    """A round shaft with one flat: cylinder and cube."""
    return Cylinder(18, 60) & Cube((40, 40, 80)).at(-8, 0, 0)


def double_d() -> Csg:
    """A round shaft with two flats: cylinder and cube."""
    return Cylinder(22, 45) & Cube((60, 30, 60))


def domed_peg() -> Csg:
    """A peg with a domed top: cylinder and sphere."""
    return Cylinder(15, 60) & Sphere(35).at(0, 0, -12)


def domed_block() -> Csg:
    """A square block with a domed top: cube and sphere."""
    return Cube((40, 40, 40)) & Sphere(45).at(0, 0, -27)


def dice() -> Csg:
    """A cube with rounded corners: cube and sphere."""
    return Cube((40, 40, 40)) & Sphere(28)


def lens() -> Csg:
    """Two caps back to back: sphere and sphere."""
    return Sphere(40).at(0, 0, -24) & Sphere(40).at(0, 0, 24)


def wedge() -> Csg:
    """A ramp with a blunt nose: cube and turned cube."""
    return Cube((70, 40, 30)) & Cube((100, 60, 60)).at(0, 0, -28).turned("y", pi / 9)


def octagon() -> Csg:
    """An eight-sided prism: cube and turned cube."""
    return Cube((50, 50, 30)) & Cube((50, 50, 40)).turned("z", pi / 4)


def rounded_cone() -> Csg:
    """A cone with a spherical tip: cone and sphere."""
    return Cone(25, 0, 60) & Sphere(36).at(0, 0, -24)


def hex_bar() -> Csg:
    """A short hexagonal bar."""
    return Prism(hexagon(36), 60)


def triangle_bar() -> Csg:
    """A bar of triangular section."""
    return Prism(((0, 0), (50, 0), (15, 40)), 70)
