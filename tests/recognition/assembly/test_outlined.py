"""Bodies held to the outlines of their plates."""

import numpy as np

from models.csg import Cube
from models.solid import Solid
from primitives.plate import Plate
from primitives.pose import pose, rotation_exp
from recognition.assembly.made import Body
from recognition.assembly.outlined import outlined
from recognition.assembly.piece import Piece

WORLD = pose(rotation_exp([0.3, -0.5, 0.2]), [40.0, -7.0, 12.0])
NOTHING = np.empty((0, 3))


def box(wide, deep, x=0.0, y=0.0):
    half = 0.5 * np.array([wide, deep])
    return np.array([x, y]) + half * [[-1, -1], [1, -1], [1, 1], [-1, 1]]


def body(wide=60.0, deep=40.0, tall=10.0):
    piece = Piece("cube", "add", Cube((wide, deep, tall)), WORLD, None, ((None, None),) * 3)
    return Body((piece,), Solid.from_csg(piece.placed), 0.01)


def plate(there, missing, thick=10.0):
    return Plate(WORLD, thick, tuple(there), tuple(missing))


def world(*places):
    return np.array(places) @ WORLD[:3, :3].T + WORLD[:3, 3]


NOTCH = box(12.0, 8.0, 26.0, 0.0)  # from x = 20 to past the side at 30


def test_a_notch_that_neither_side_has_is_taken_away():
    made = outlined(body(), [plate([], [NOTCH])], None, NOTHING)
    assert abs(made.solid.volume - (24000.0 - 10.0 * 8.0 * 10.0)) < 1.0
    assert [piece.operation for piece in made.pieces] == ["add", "subtract"]


def test_not_where_contacts_lie_between_the_two_sides_as_of_a_web():
    web = world(*([x, y, 0.0] for x in (22.0, 25.0, 28.0) for y in (-2.5, 0.0, 2.5)))
    assert outlined(body(), [plate([], [NOTCH])], None, web).solid.volume == body().solid.volume
    on_the_sides = web + 5.0 * WORLD[:3, 2]
    assert outlined(body(), [plate([], [NOTCH])], None, on_the_sides).solid.volume < body().solid.volume


def test_an_outline_that_lies_a_little_off_changes_nothing():
    frame = [box(80, 60), box(59.2, 39.2)]
    assert outlined(body(), [plate([box(61, 41)], frame)], None, NOTHING).solid.volume == body().solid.volume


def test_an_ear_that_both_sides_have_is_added_unless_an_array_passed_through_it():
    ear = box(14.0, 10.0, 36.0, 5.0)
    told = plate(
        [box(60, 40), ear], []
    )  # what overlaps is in both, and in neither then: the body has it anyway
    made = outlined(body(), [told], None, NOTHING)
    assert abs(made.solid.volume - (24000.0 + 13.0 * 10.0 * 10.0)) < 1.0
    passed = world(*([x, y, z] for x in (33.0, 37.0, 41.0) for y in (2.0, 6.0) for z in (-2.0, 2.0)))
    assert outlined(body(), [told], passed, NOTHING).solid.volume == body().solid.volume


def test_a_groove_between_the_two_sides_is_not_filled():
    whole = body()
    groove = Piece("cube", "subtract", Cube((60.0, 10.0, 4.0)), WORLD @ pose(translation=[0, 18, 0]), None,
                   ((None, None),) * 3)  # fmt: skip
    grooved = whole.less(groove)
    assert outlined(grooved, [plate([box(60, 40)], [])], None, NOTHING).solid.volume == grooved.solid.volume


def test_a_ring_that_neither_side_has_goes_in_pieces_without_holes():
    round_it = [box(90, 70), box(40, 30)]
    made = outlined(body(), [plate([box(40, 30)], round_it)], None, NOTHING)
    assert abs(made.solid.volume - 12000.0) < 1.0
    assert all(piece.kind == "prism" for piece in made.pieces[1:])


def test_a_round_notch_is_taken_away_as_a_cylinder():
    turn = np.linspace(0.0, 2.0 * np.pi, 73)[:-1]
    rim = np.array([30.0, 0.0]) + 9.0 * np.column_stack([np.cos(turn), np.sin(turn)])
    made = outlined(body(), [plate([], [rim])], None, NOTHING)
    (piece,) = made.pieces[1:]
    assert piece.kind == "cylinder"
    assert abs(piece.solid.radius - 9.0) < 0.05
    assert abs(made.solid.volume - (24000.0 - 0.5 * np.pi * 81.0 * 10.0)) < 30.0


def lying(there, missing, thick):
    """Seen from above alone, its upper side level with the body's, so many mm over the table."""
    return Plate(
        WORLD @ pose(translation=[0, 0, 5.0 - 0.5 * thick]), thick, tuple(there), tuple(missing), True
    )


def test_on_a_table_a_lobe_goes_down_as_far_as_the_body_beside_it():
    lobe = box(34.0, 20.0, 24.0, 0.0)  # from x = 7 to 41, of which 11 mm are missing of the body
    on_it, over_it = (
        outlined(body(), [lying([box(60, 40), lobe], [], t)], None, NOTHING) for t in (10.0, 20.0)
    )
    for made in (on_it, over_it):
        assert made.solid.volume > 24000.0
        low = ((made.solid.vertices - WORLD[:3, 3]) @ WORLD[:3, 2]).min()
        assert low > -7.1
    assert abs(on_it.solid.volume - (24000.0 + 11.0 * 20.0 * 10.0)) < 1.0
