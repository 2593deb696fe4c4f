from math import pi

import numpy as np
import pytest

from models import parts
from models.csg import Cone, Csg, Cube, Cylinder, Polyhedron, Prism, Sphere
from models.formats import openscad
from models.normal.rounding import rounded
from models.solid import Solid, iou
from primitives.errors import PalpateError
from primitives.pose import pose, rotation_exp


def jittered(name: str, sigma: float) -> Csg:
    """A part at a pose known to sigma, as measured."""
    return parts.build(name).placed(
        pose(rotation_exp([0.3, -1.2, 0.7]), [12.34567891, -3.3333333, 0.00012345])
    )


def test_lengths_keep_the_decimal_that_sigma_supports() -> None:
    tree = Cube((40.01234, 19.98765, 9.5)).at(1.23456, 0.0004, -7.77777)
    assert rounded(tree, 0.02) == Cube((40.01, 19.98, 9.5)).at(1.235, 0, -7.78)
    assert rounded(tree, 0.3) == Cube((40.0, 20.0, 9.5)).at(1.2, 0, -7.75)
    assert rounded(Sphere(7.777), 20) == Sphere(10)


def test_what_is_less_than_its_sigma_does_not_vanish() -> None:
    assert (
        rounded(Cone(0.004, 0.0, 5.0), 0.02) == rounded(Cone(0.0, 0.004, 5.0), 0.02) == Cylinder(0.004, 5.0)
    )
    assert rounded(Sphere(0.0123), 1.0) == Sphere(0.01)


def test_a_turn_within_its_uncertainty_of_the_axes_is_square() -> None:
    tree = Cube((40, 20, 10)).placed(pose(rotation_exp([0, 2e-4, pi / 2 + 3e-4]), [5, 0, 0]))
    assert rounded(tree, 0.05) == Cube((40, 20, 10)).placed(
        pose([[0, -1, 0], [1, 0, 0], [0, 0, 1]], [5, 0, 0])
    )
    assert rounded(tree, 0.001) != rounded(tree, 0.05)


def test_a_roll_that_nothing_shows_is_not_written() -> None:
    assert rounded(Cylinder(5, 20, name="pin").turned("z", 0.777), 0.01) == Cylinder(5, 20, name="pin")


def test_names_and_structure_stay() -> None:
    tree = (Cube((10.04, 10, 10), name="base") - Cylinder(2.01, 30, name="hole").at(1.01, 0, 0)).named("part")
    assert repr(rounded(tree, 0.1)) == repr(
        (Cube((10.0, 10, 10), name="base") - Cylinder(2.0, 30, name="hole").at(1.0, 0, 0)).named("part")
    )


def test_a_cone_within_sigma_of_a_cylinder_is_one() -> None:
    assert rounded(Cone(10.002, 9.998, 30), 0.01) == Cylinder(10, 30)


def test_corners_that_rounding_would_break_stay() -> None:
    thin = Prism(((0, 0), (10, 0.001), (10, 0.004)), 5)
    assert rounded(thin, 0.1) == thin
    flat = Polyhedron(
        ((0, 0, 0), (9, 0, 0), (0, 8, 0), (0, 0, 0.01)), ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
    )
    assert rounded(flat, 0.1) == flat


@pytest.mark.parametrize("name", ["bracket", "flange", "wedge", "hex_bolt", "domed_peg", "o_ring"])
def test_a_rounded_part_departs_by_its_uncertainty(name: str) -> None:
    tree = jittered(name, 0.01)
    exact, short = Solid.from_csg(tree), Solid.from_csg(rounded(tree, 0.01))
    assert np.abs(exact.signed_distance(short.vertices)).max() < 0.05
    assert iou(exact, short) > 0.995


def test_rounded_numbers_are_short_in_the_file() -> None:
    text = openscad.text(rounded(Cube((40.012345678, 20, 10)).at(1.23456789, 0, 0), 0.01))
    assert "40.01, 20, 10" in text
    assert ", 1.235]" in text


@pytest.mark.parametrize("sigma", [0.0, -1.0, float("nan")])
def test_an_uncertainty_is_positive(sigma: float) -> None:
    with pytest.raises(PalpateError, match="positive"):
        rounded(Sphere(1), sigma)
