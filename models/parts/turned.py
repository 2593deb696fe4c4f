"""Built-in parts turned on a lathe, and what is screwed to them: bolts, rings, shafts, wheels."""

from math import pi

from models.csg import Cone, Csg, Cube, Cylinder, Prism, Sphere, Torus
from models.parts.outlines import gear, hexagon


def hex_bolt() -> Csg:
    """A bolt with a hexagonal head, without its thread."""
    return Prism(hexagon(30), 12, name="head").at(0, 0, 6) | Cylinder(10, 60, name="shank").at(0, 0, -29)


def hex_nut() -> Csg:
    """A hexagonal nut, chamfered on top, without its thread."""
    body = Prism(hexagon(36), 18) & Cone(50, 18.5, 31.5, name="chamfer").at(0, 0, -6.75)
    return body - Cylinder(10, 40, name="bore")


def socket_screw() -> Csg:
    """A screw with a round head and a hexagonal socket, without its thread."""
    screw = Cylinder(18, 20, name="head").at(0, 0, 10) | Cylinder(12, 60, name="shank").at(0, 0, -29)
    return screw - Prism(hexagon(17), 20, name="socket").at(0, 0, 20)


def keyed_shaft() -> Csg:
    """A shaft with a keyway at one end and a shoulder."""
    shaft = Cylinder(15, 100).at(0, 0, 50) | Cylinder(20, 30).at(0, 0, 15)
    return shaft - Cube((20, 8, 40), name="keyway").at(20, 0, 90)


def stepped_shaft_thick() -> Csg:
    """The shaft of two diameters, but with its thin end 2 mm thicker."""
    return Cylinder(20, 30).at(0, 0, 15) | Cylinder(13, 80).at(0, 0, 40)


def flange_three_holes() -> Csg:
    """The flange, but with one of its four bolt holes left out."""
    body = Cylinder(40, 10).at(0, 0, 5) | Cylinder(20, 35).at(0, 0, 17.5)
    part = body - Cylinder(11, 90, name="bore")
    for i in range(3):
        part = part - Cylinder(4, 30, name=f"bolt hole {i + 1}").at(30, 0, 5).turned("z", i * pi / 2)
    return part


def o_ring() -> Csg:
    """A plain ring of round section."""
    return Torus(35, 7)


def grommet() -> Csg:
    """A grommet: a bored disc with a round groove about it."""
    return Cylinder(25, 20) - Torus(25, 6, name="groove") - Cylinder(10, 40, name="bore")


def grooved_plug() -> Csg:
    """A plug with a head and a groove for an O-ring."""
    plug = Cylinder(28, 10).at(0, 0, 45) | Cylinder(20, 45).at(0, 0, 22.5)
    return plug - Torus(20, 3, name="groove").at(0, 0, 15)


def pulley() -> Csg:
    """A wheel with a round groove for a rope, a bore and a keyway."""
    wheel = Cylinder(45, 24) | Cylinder(18, 40)
    cut = wheel - Torus(46, 8, name="rope groove") - Cylinder(9, 60, name="bore")
    return cut - Cube((12, 6, 60), name="keyway").at(6, 0, 0)


def handwheel() -> Csg:
    """A round rim on three spokes and a bored hub."""
    wheel: Csg = Torus(55, 8, name="rim") | Cylinder(16, 30, name="hub")
    for i in range(3):
        wheel = wheel | Cylinder(5, 50, name=f"spoke {i + 1}").turned("y", pi / 2).at(30, 0, 0).turned(
            "z", i * 2 * pi / 3
        )
    return wheel - Cylinder(8, 60, name="bore")


def eyebolt() -> Csg:
    """A ring on a shank."""
    return Torus(22, 6, name="eye").turned("x", pi / 2) | Cylinder(5, 50, name="shank").at(0, 0, -47)


def domed_cap() -> Csg:
    """A hollow dome with a flat, bored top."""
    shell = Sphere(40, name="dome") - Sphere(34, name="hollow")
    return (shell & Cube((99, 99, 38)).at(0, 0, 19)) - Cylinder(8, 40, name="hole").at(0, 0, 40)


def funnel() -> Csg:
    """A hollow cone that ends in a short spout."""
    outside = Cone(12, 45, 50).at(0, 0, 25) | Cylinder(14, 35).at(0, 0, -12.5)
    return outside - Cone(6, 48, 60, name="cone").at(0, 0, 30) - Cylinder(8, 50, name="spout").at(0, 0, -15)


def knob() -> Csg:
    """A ball knob with a flat top on a bored stem."""
    ball = Sphere(24, name="ball") & Cube((60, 60, 60)).at(0, 0, -11)
    return (ball | Cylinder(11, 40, name="stem").at(0, 0, -35)) - Cylinder(5, 40, name="bore").at(0, 0, -45)


def spur_gear() -> Csg:
    """A gear of sixteen straight-sided teeth with a hub, a bore and a keyway."""
    wheel = Prism(gear(16, 34, 42), 14, name="teeth") | Cylinder(16, 26, name="hub").at(0, 0, 6)
    return wheel - Cylinder(8, 60, name="bore") - Cube((11, 5, 60), name="keyway").at(5.5, 0, 0)


def hollow_bushing() -> Csg:
    """A flanged bushing with a counterbore."""
    bushing = Cylinder(16, 40).at(0, 0, 20) | Cylinder(24, 6).at(0, 0, 3)
    return bushing - Cylinder(10, 90, name="bore") - Cylinder(13, 20, name="counterbore").at(0, 0, 35)


def filleted_post() -> Csg:
    """A post on a round foot, with a fillet where they meet."""
    post = Cylinder(34, 12).at(0, 0, 6) | Cylinder(14, 70).at(0, 0, 35)
    fillet = Cylinder(22, 8).at(0, 0, 16) - Torus(22, 8).at(0, 0, 20)
    return post | fillet.named("fillet")


def cap_nut() -> Csg:
    """A hexagonal nut closed by a dome, with a blind bore."""
    nut = Prism(hexagon(36), 16).at(0, 0, 8) | Cylinder(16, 10, name="neck").at(0, 0, 17)
    return (nut | Sphere(16, name="dome").at(0, 0, 22)) - Cylinder(9, 50, name="bore")
