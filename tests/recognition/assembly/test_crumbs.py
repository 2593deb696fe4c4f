"""Pieces apart from a body that nobody felt go; what was felt, or cannot be cut out alone, stays."""

import numpy as np
import pytest

from models.csg import Cube
from models.solid import Solid
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
    post = Cube((2.0, 2.0, 40.0)).at(19.0, 14.0, 20.0)  # passes through the box of a slanted splinter
    tilted = np.array(
        [[0.8, 0.0, 0.6, 19.0], [0.0, 1.0, 0.0, 11.0], [-0.6, 0.0, 0.8, 30.0], [0.0, 0.0, 0.0, 1.0]]
    )
    whole = body_of(BLOCK | post | Cube((1.0, 1.0, 12.0)).placed(tilted))
    assert whole.shells == 2
    beside = body_of(
        BLOCK | post | Cube((0.5, 6.0, 1.0)).placed(tilted) | Cube((0.5, 0.5, 9.0)).at(22.0, 11.0, 30.0)
    )
    for body in (whole, beside):
        made = without_crumbs(body, ON_BLOCK)
        assert made.solid.signed_distance(np.array([[19.0, 14.0, 30.0]]))[0] < -0.9
