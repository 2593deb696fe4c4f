"""Built-in parts with inside edges, steps and holes."""

from math import pi

from models.csg import Cone, Csg, Cube, Cylinder, Sphere


def bracket() -> Csg:
    """An angle bracket with a hole in each leg."""
    legs = Cube((60, 40, 8)).at(0, 0, 4) | Cube((8, 40, 50)).at(-26, 0, 25)
    return legs - Cylinder(5, 30, name="foot hole").at(14, 0, 4) - _along_x(6, 30).at(-26, 0, 32)


def plate_with_hole() -> Csg:
    """A plate with a round hole through it."""
    return Cube((80, 50, 10)) - Cylinder(12, 30, name="hole")


def stepped_block() -> Csg:
    """A block with one step."""
    return Cube((60, 40, 15)).at(0, 0, 7.5) | Cube((30, 40, 35)).at(-15, 0, 17.5)


def stepped_shaft() -> Csg:
    """A shaft of two diameters."""
    return Cylinder(20, 30).at(0, 0, 15) | Cylinder(12, 80).at(0, 0, 40)


def flange() -> Csg:
    """A round flange with a boss, a bore and four bolt holes."""
    body = Cylinder(40, 10).at(0, 0, 5) | Cylinder(20, 35).at(0, 0, 17.5)
    part = body - Cylinder(11, 90, name="bore")
    for i in range(4):
        part = part - Cylinder(4, 30, name=f"bolt hole {i + 1}").at(30, 0, 5).turned("z", i * pi / 2)
    return part


def pipe() -> Csg:
    """A short length of thick pipe."""
    return Cylinder(25, 50) - Cylinder(16, 70, name="bore")


def slotted_block() -> Csg:
    """A block with a slot across its top."""
    return Cube((60, 50, 30)) - Cube((16, 70, 30), name="slot").at(0, 0, 15)


def dish() -> Csg:
    """A disc with a spherical hollow."""
    return Cylinder(35, 20) - Sphere(45, name="hollow").at(0, 0, 42)


def countersunk_plate() -> Csg:
    """A plate with a countersunk hole."""
    plate = Cube((70, 50, 14)) - Cylinder(6, 40, name="hole")
    return plate - Cone(2, 18, 16, name="countersink").at(0, 0, 3)


def cross_pipe() -> Csg:
    """Two round bars that cross."""
    return Cylinder(16, 90) | _along_x(12, 90)


def _along_x(radius: float, length: float) -> Csg:
    return Cylinder(radius, length).turned("y", pi / 2)
