"""What lies in pieces is joined along a bar or a box of which an end was not felt."""

import numpy as np
import pytest

from models.csg import Cube, Cylinder, Sphere
from models.solid import Solid
from primitives import pose as se3
from recognition.assembly.joined import joined
from recognition.assembly.piece import Piece, tree_of

TURNED = se3.pose(se3.rotation_exp([0.3, 0.5, -0.2]), [5.0, -3.0, 8.0])
FELT, UNFELT = 1, 2
NOTHING = np.empty((0, 3))


def placed(solid, kind, at, ends):
    return Piece(kind, "add", solid, TURNED @ se3.pose(translation=at), None, ends)


def bar(above=UNFELT, gap=10.0):
    """From 20 mm below up to `gap` mm under a ball of radius 12."""
    return placed(Cylinder(5.0, 20.0), "cylinder", [0.0, 0.0, -12.0 - gap - 10.0], ((FELT, above),))


BALL = placed(Sphere(12.0), "sphere", [0.0, 0.0, 0.0], ())


def parts(pieces):
    return Solid.from_csg(tree_of(pieces)).parts


def kept(pieces, free=None, felt=NOTHING):
    """Whether all stay as they are."""
    whole = joined(pieces, {UNFELT}, free, felt, 0.01)
    return all(new is old for new, old in zip(whole, pieces, strict=True))


@pytest.mark.parametrize("above", [UNFELT, None])
def test_a_bar_goes_on_to_what_it_points_at_and_not_through_it(above):
    whole = joined([BALL, bar(above)], {UNFELT}, None, NOTHING, 0.01)
    assert parts(whole) == 1
    low, high = se3.transform_points(se3.inverse(TURNED), whole[1].world_from_piece[:3, 3][None])[0, 2] + (
        0.5 * np.array([-1.0, 1.0]) * whole[1].solid.height
    )
    assert low == pytest.approx(-42.0)
    assert -12.0 < high < 0.1
    assert whole[1].ends == ((FELT, None),)


def test_a_box_is_joined_along_the_side_that_nobody_felt():
    box = placed(
        Cube((20.0, 8.0, 6.0)), "cube", [-30.0, 0.0, 0.0], ((FELT, UNFELT), (FELT, FELT), (FELT, FELT))
    )
    whole = joined([BALL, box], {UNFELT}, None, NOTHING, 0.01)
    assert parts(whole) == 1
    assert whole[1].ends[0] == (FELT, None)
    assert whole[1].solid.size[1:] == (8.0, 6.0)


def test_nothing_is_joined_from_an_end_that_was_felt_or_through_what_was_passed_or_too_far():
    lone = (BALL, bar())
    assert kept((BALL, bar(FELT)))
    axis = np.linspace(-22.0, -12.0, 12)
    free = se3.transform_points(
        TURNED, np.array([[x, y, z] for x in (-3, 0, 3) for y in (-3, 0, 3) for z in axis])
    )
    assert kept(lone, free)
    assert kept(lone, None, free)  # another face is there
    assert not kept(lone)
    assert kept((BALL, bar(gap=40.0)))


def test_a_body_in_one_piece_stays_as_it_is():
    assert kept((BALL, bar(gap=-4.0)))
