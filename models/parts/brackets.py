"""Built-in parts bent or welded from plate: brackets, clevises, bolting plates."""

from math import pi

from models.csg import Csg, Cube, Cylinder, Prism


def bracket_one_hole() -> Csg:
    """The angle bracket, but with no hole in its upright leg."""
    legs = Cube((60, 40, 8)).at(0, 0, 4) | Cube((8, 40, 50)).at(-26, 0, 25)
    return legs - Cylinder(5, 30, name="foot hole").at(14, 0, 4)


def gusset_bracket() -> Csg:
    """A wide angle bracket, its legs held by a rib."""
    legs = Cube((70, 60, 8)).at(0, 0, 4) | Cube((8, 60, 70)).at(-31, 0, 35)
    rib = Prism(((-30, 4), (25, 4), (-30, 60)), 8, name="rib").turned("x", pi / 2)
    return (legs | rib) - Cylinder(4, 30).at(15, 18, 4) - Cylinder(4, 30).at(15, -18, 4)


def clevis() -> Csg:
    """A fork with a hole for its pin."""
    fork = Prism(((-30, 0), (30, 0), (30, 70), (18, 70), (18, 15), (-18, 15), (-18, 70), (-30, 70)), 40)
    return fork.turned("x", pi / 2) - _along_x(8, 90, "pin hole").at(0, 0, 50)


def z_bracket() -> Csg:
    """An offset bracket with a hole in each flange."""
    section = ((-45, 0), (5, 0), (5, 34), (45, 34), (45, 40), (-1, 40), (-1, 6), (-45, 6))
    bar = Prism(section, 35, name="z section").turned("x", pi / 2)
    return bar - Cylinder(4.5, 20).at(-26, 0, 3) - Cylinder(4.5, 20).at(26, 0, 37)


def t_plate() -> Csg:
    """A joining plate in the shape of a T with five holes."""
    outline = ((-60, 10), (-60, 40), (60, 40), (60, 10), (15, 10), (15, -60), (-15, -60), (-15, 10))
    part: Csg = Prism(outline, 6)
    for x, y in ((-45, 25), (0, 25), (45, 25), (0, -15), (0, -45)):
        part = part - Cylinder(5, 20).at(x, y, 0)
    return part


def bolt_plate() -> Csg:
    """A square plate with four equal holes."""
    return _bolt_plate(6, 6, 6, 6)


def bolt_plate_one_wider() -> Csg:
    """The square plate, but with one of its four holes wider."""
    return _bolt_plate(6, 6, 6, 7.5)


def slotted_plate() -> Csg:
    """A plate that two slots let slide."""
    part: Csg = Cube((110, 60, 8))
    for y in (-16, 16):
        part = part - _slot(50, 5, 30, "slot").at(0, y, 0)
    return part


def link() -> Csg:
    """A flat link with round ends and a hole in each."""
    bar = Cube((80, 36, 10)) | Cylinder(18, 10).at(-40, 0, 0) | Cylinder(18, 10).at(40, 0, 0)
    return bar - Cylinder(10, 30).at(-40, 0, 0) - Cylinder(7, 30).at(40, 0, 0)


def lug() -> Csg:
    """A lug with a round end on a foot with two holes."""
    tongue = Cube((40, 14, 40)).at(0, 0, 28) | Cylinder(20, 14, name="end").turned("x", pi / 2).at(0, 0, 48)
    part: Csg = Cube((100, 40, 10)).at(0, 0, 5) | tongue
    part = part - Cylinder(9, 30, name="eye").turned("x", pi / 2).at(0, 0, 48)
    return part - Cylinder(5, 30).at(-36, 0, 5) - Cylinder(5, 30).at(36, 0, 5)


def _bolt_plate(*radii: float) -> Csg:
    part: Csg = Cube((80, 80, 10))
    for radius, (x, y) in zip(radii, ((-28, -28), (28, -28), (-28, 28), (28, 28)), strict=True):
        part = part - Cylinder(radius, 30).at(x, y, 0)
    return part


def _slot(length: float, radius: float, depth: float, name: str) -> Csg:
    """A slot with round ends, `length` between their centers, along x."""
    ends = Cylinder(radius, depth).at(-length / 2, 0, 0) | Cylinder(radius, depth).at(length / 2, 0, 0)
    return (Cube((length, 2 * radius, depth)) | ends).named(name)


def _along_x(radius: float, length: float, name: str = "") -> Csg:
    return Cylinder(radius, length, name=name).turned("y", pi / 2)
