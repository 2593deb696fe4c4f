"""Bodies held to the outlines of their plates."""

import numpy as np

from models.csg import Cube, Cylinder
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
    web = world(*([x, y, 0.0] for x in (23.0, 25.0, 27.0) for y in (-1.5, 1.5)))
    assert outlined(body(), [plate([], [NOTCH])], None, web).solid.volume == body().solid.volume
    on_the_sides = web + 5.0 * WORLD[:3, 2]
    assert outlined(body(), [plate([], [NOTCH])], None, on_the_sides).solid.volume < body().solid.volume


def test_a_post_on_the_rim_of_a_thick_plate_that_reaches_neither_side_is_left():
    """Neither side shows it; of a thin plate, or up to a side, such a place is a notch."""
    post = Piece("cube", "add", Cube((10.0, 30.0, 16.0)), WORLD @ pose(translation=[0.0, 30.0, 0.0]), None,
                 ((None, None),) * 3)  # fmt: skip
    for tall, stays in ((50.0, True), (16.0, False), (10.0, False)):
        whole = body(tall=tall).more(post)
        told = plate([box(60, 40)], [box(20.0, 12.0, 0.0, 27.0)], thick=tall)
        left = outlined(whole, [told], None, NOTHING).solid.volume
        assert (abs(left - whole.solid.volume) < 1.0) == stays


def test_a_notch_in_a_thick_plate_that_bulges_between_its_sides_goes_out_of_the_bulge():
    bulge = Piece("cube", "add", Cube((66.0, 40.0, 10.0)), WORLD, None, ((None, None),) * 3)
    whole = body(tall=20.0).more(bulge)
    made = outlined(whole, [plate([], [box(20.0, 12.0, 28.0)], thick=20.0)], None, NOTHING)
    assert abs(whole.solid.volume - made.solid.volume - 12.0 * (12.0 * 20.0 + 3.0 * 10.0)) < 1.0


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


def ring(wide, deep, by):
    """Rims of what lies round a face that ends so many mm inside a box."""
    return [box(wide + 20.0, deep + 20.0), box(wide - 2.0 * by, deep - 2.0 * by)]


def on_the_walls(wide, deep):
    x, y = 0.5 * wide, 0.5 * deep
    ends = [[s * x, t, 0.0] for s in (-1, 1) for t in (-12.0, 0.0, 12.0)]
    return world(*ends, *([t, s * y, 0.0] for s in (-1, 1) for t in (-20.0, 0.0, 20.0)))


def test_sides_that_bulge_or_are_chamfered_past_both_faces_stay_where_they_were_felt():
    told = plate([box(54, 34)], ring(60, 40, 3.0))
    assert outlined(body(), [told], None, on_the_walls(60, 40)).solid.volume == body().solid.volume
    assert outlined(body(), [told], None, NOTHING).solid.volume < body().solid.volume


def test_a_large_part_may_hold_no_more_strays_than_a_small_one():
    big, missing = body(120.0, 100.0), [box(140, 120), box(30, 30)]
    shelf = world(*([x, y, 0.0] for x in (-40.0, 40.0) for y in (-30.0, 0.0, 30.0)))
    assert outlined(big, [plate([box(30, 30)], missing)], None, shelf).solid.volume == big.solid.volume
    few = outlined(big, [plate([box(30, 30)], missing)], None, shelf[:1])
    assert few.solid.volume < 0.5 * big.solid.volume  # an island round it stays


def test_a_tube_of_thin_walls_is_not_filled_between_its_sides():
    tall = body(60.0, 40.0, 24.0)
    tube = tall.less(Piece("cube", "subtract", Cube((70.0, 36.0, 21.0)), WORLD, None, ((None, None),) * 3))
    assert outlined(tube, [plate([box(60, 40)], [], 24.0)], None, NOTHING).solid.volume == tube.solid.volume


def test_a_leg_that_was_always_by_itself_at_those_levels_is_not_cut_loose():
    bridge = body(80.0, 40.0, 30.0)
    under = Piece("cube", "subtract", Cube((40.0, 50.0, 20.0)), WORLD @ pose(translation=[0, 0, -8.0]), None,
                  ((None, None),) * 3)  # fmt: skip
    legs = bridge.less(under)
    low = Plate(WORLD @ pose(translation=[0, 0, -10.0]), 10.0, (), (box(8.0, 8.0, 38.0, 0.0),))
    felt = world(*([-30.0, y, -10.0] for y in (-10.0, 0.0, 10.0)))
    made = outlined(legs, [low], None, felt)
    assert 0.0 < legs.solid.volume - made.solid.volume < 8.0 * 6.0 * 31.0


def test_nothing_is_missing_where_the_sides_are():
    """Of a thin land a soft picture shows little, and outlines of what is and what is not may cross there."""
    land = [box(60.0, 40.0), box(54.0, 34.0)]
    made = outlined(body(), [plate(land, [box(56.0, 36.0)])], None, NOTHING)
    assert abs(made.solid.volume - (24000.0 - 54.0 * 34.0 * 10.0)) < 1.0


def test_corners_that_a_film_holds_together_are_cut_loose():
    """What is missing ends a hair inside the sides of a box, which are felt between, and before its corners."""
    turn = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    disc = 17.0 * np.column_stack([np.cos(turn), np.sin(turn)])
    half = np.array([[29.9, -13.0], [29.9, 13.0], [23.0, 19.9], [-23.0, 19.9]])
    seen = np.concatenate([half, -half])
    felt = world([0.0, 0.0, 5.0], [29.97, 0.0, 0.0], [0.0, -19.97, 0.0])
    made = outlined(body(), [plate([disc], [seen, disc])], None, felt)
    assert abs(made.solid.volume - np.pi * 289.0 * 10.0) < 60.0


def test_a_cut_goes_on_out_of_the_body_unless_something_was_felt_there():
    high = body(60.0, 40.0, 30.0)  # the plate is its middle 10 mm
    through = outlined(high, [plate([], [NOTCH])], None, NOTHING)
    assert abs(high.solid.volume - through.solid.volume - 10.0 * 8.0 * 30.0) < 1.0
    above = outlined(high, [plate([], [NOTCH])], None, world([25.0, 0.0, 15.0]))
    assert abs(high.solid.volume - above.solid.volume - 10.0 * 8.0 * 20.5) < 1.0


def test_of_cuts_of_which_one_tears_the_body_the_others_are_made():
    waist = box(10.0, 60.0)  # right across, with contacts on both halves
    felt = world(*([x, y, 0.0] for x in (-25.0, -15.0, 10.0, 15.0) for y in (-10.0, 10.0)))
    made = outlined(body(), [plate([], [waist, NOTCH])], None, felt)
    assert abs(made.solid.volume - (24000.0 - 10.0 * 8.0 * 10.0)) < 1.0


def test_a_round_end_is_not_added_over_a_bore():
    turn = np.linspace(0.0, 2.0 * np.pi, 73)[:-1]
    end = np.array([30.0, 0.0]) + 12.0 * np.column_stack([np.cos(turn), np.sin(turn)])
    bore = np.array([33.0, 0.0]) + 2.5 * np.column_stack([np.cos(turn), np.sin(turn)])
    made = outlined(body(), [plate([end, bore], [])], None, NOTHING)
    assert made.solid.volume > 24000.0 + 100.0
    assert made.solid.signed_distance(world([33.0, 0.0, 0.0]))[0] > 1.0


def test_a_narrow_hole_that_the_body_has_is_not_filled_though_the_outline_shows_none():
    hole = Piece("cylinder", "subtract", Cylinder(2.0, 20.0), WORLD, 0, ((None, None),))
    drilled = body().less(hole)
    assert outlined(drilled, [plate([box(60, 40)], [])], None, NOTHING).solid.volume == drilled.solid.volume
    wide = body().less(Piece("cylinder", "subtract", Cylinder(6.0, 20.0), WORLD, 0, ((None, None),)))
    assert outlined(wide, [plate([box(60, 40)], [])], None, NOTHING).solid.volume > wide.solid.volume + 900.0


def step(there, missing, thick, height):
    """So thick, its floor at a height over the middle of the body."""
    return Plate(
        WORLD @ pose(translation=[0.0, 0.0, height + 0.5 * thick]),
        thick,
        tuple(there),
        tuple(missing),
        step=True,
    )


def test_a_pocket_is_taken_away_down_to_its_floor_and_no_deeper():
    pocket = box(20.0, 12.0, 5.0, 0.0)
    made = outlined(body(), [step([box(60.0, 40.0), pocket], [pocket], 6.0, -1.0)], None, NOTHING)
    assert abs(made.solid.volume - (24000.0 - 20.0 * 12.0 * 6.0)) < 1.0
    assert made.solid.parts == 1


def test_what_a_body_lacks_over_a_floor_is_added_and_nothing_under_an_edge_that_it_has():
    boss, floor = box(14.0, 10.0, -5.0, 0.0), box(60.0, 40.0)
    made = outlined(body(), [step([boss], [floor, boss], 7.0, 5.0)], None, NOTHING)
    assert abs(made.solid.volume - (24000.0 + 14.0 * 10.0 * 7.0)) < 1.0
    bank, beside = box(30.0, 40.0, 15.0, 0.0), box(30.0, 40.0, -15.0, 0.0)
    made = outlined(body(), [step([bank], [beside], 7.0, 5.0)], None, NOTHING)
    assert abs(made.solid.volume - (24000.0 + 30.0 * 40.0 * 7.0)) < 1.0
    groove = Piece("cube", "subtract", Cube((40.0, 99.0, 4.0)), WORLD, None, ((None, None),) * 3)
    hollow = body().less(groove)
    banks = [box(20.0, 40.0, -20.0, 0.0), box(20.0, 40.0, 20.0, 0.0)]
    tops = world([-20.0, 0.0, 5.0], [20.0, 0.0, 5.0])
    made = outlined(hollow, [step(banks, [box(20.0, 40.0)], 7.0, -2.0)], None, tops)
    assert abs(made.solid.volume - (hollow.solid.volume - 20.0 * 40.0 * 3.0)) < 1.0
