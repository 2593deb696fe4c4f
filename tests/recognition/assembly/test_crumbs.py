"""Pieces apart from a body that nobody felt go; what was felt, or cannot be cut out alone, stays."""

import numpy as np
import pytest

from models.csg import Cube, Sphere
from models.solid import Solid
from primitives.pose import pose, rotation_exp
from recognition.assembly.crumbs import UNFELT, without_crumbs
from recognition.assembly.made import Body

BLOCK, SPLINTER = Cube((40.0, 30.0, 20.0)), Cube((4.0, 5.0, 6.0))
ON_BLOCK = np.array([[20.0, 3.0, 1.0], [-20.0, 2.0, 0.0], [0.0, 0.0, 10.0]])


def body_of(csg):
    return Body((), Solid.from_csg(csg), 0.01)


def test_a_splinter_that_nobody_felt_is_taken_away():
    made = without_crumbs(body_of(BLOCK | SPLINTER.at(35.0, 0.0, 0.0)), ON_BLOCK)
    assert made.shells == 1
    assert made.solid.volume == pytest.approx(40.0 * 30.0 * 20.0, rel=1e-6)
    assert [piece.why for piece in made.pieces] == [UNFELT]


def test_one_that_was_felt_stays_and_so_does_half_of_the_body():
    splinter = body_of(BLOCK | SPLINTER.at(35.0, 0.0, 0.0))
    assert without_crumbs(splinter, np.concatenate([ON_BLOCK, [[33.0, 0.0, 0.0]]])) is splinter
    halves = body_of(BLOCK | BLOCK.at(60.0, 0.0, 0.0))
    assert without_crumbs(halves, ON_BLOCK) is halves


def test_nothing_of_the_body_is_cut_with_it():
    post = Cube((2.0, 2.0, 40.0)).at(15.0, 10.0, 20.0)
    bar = Cube((16.0, 1.0, 4.0)).placed(pose(rotation_exp([0.0, 0.0, np.pi / 4]), [18.0, 7.0, 30.0]))
    body = body_of(BLOCK | post | bar)  # the post stands in the bar's box, and beside it
    assert body.shells == 2
    assert without_crumbs(body, ON_BLOCK) is body


def test_a_cavity_and_what_rounding_leaves_are_no_pieces():
    hollow = body_of(BLOCK - Sphere(4.0))
    assert without_crumbs(hollow, ON_BLOCK) is hollow
    dust = body_of(BLOCK | Cube((0.2, 0.2, 0.2)).at(20.5, 0.0, 0.0))
    assert without_crumbs(dust, ON_BLOCK) is dust
    splinter = body_of(BLOCK | SPLINTER.at(35.0, 0.0, 0.0))
    assert without_crumbs(splinter, np.empty((0, 3))) is splinter
