"""What was felt where a body has nothing stands for a limb."""

import numpy as np
import pytest

from models.csg import Cube, Cylinder
from models.solid import Solid
from primitives.shapes import Cylinder as RoundWall
from primitives.shapes import Plane
from recognition.assembly.limbs import with_limbs
from recognition.assembly.made import Body, Known
from recognition.assembly.piece import Piece

FACET = 0.01
BLOCK = Cube((60.0, 40.0, 20.0))
EAR = Cube((24.0, 20.0, 8.0)).at(40.0, 0.0, -6.0)  # from inside the block to x = 52, level with its bottom
TOP, BOTTOM = Plane([0, 0, 10.0], [0, 0, 1.0]), Plane([0, 0, -10.0], [0, 0, -1.0])
LEDGE, SIDE = Plane([0, 0, -2.0], [0, 0, 1.0]), Plane([30.0, 0, 0], [1.0, 0, 0])


def body(tree=BLOCK):
    return Body((Piece("cube", "add", tree, np.eye(4), None, ()),), Solid.from_csg(tree, FACET), FACET)


def places(x, y, z, step=3.0):
    """A lattice between bounds along each axis."""
    axes = [np.arange(low, high + 1e-9, step) if high > low else np.array([low]) for low, high in (x, y, z)]
    return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 3)


def known(shapes, at, stray=None):
    return Known(shapes, at, [False] * len(shapes), np.empty((0, 3)) if stray is None else stray)


ON_TOP = places((-28, 28), (-18, 18), (10, 10))
ON_BOTTOM = places((-28, 50), (-9, 9), (-10, -10))  # across the block and the ear
ON_LEDGE = places((33, 50), (-9, 9), (-2, -2))
ON_END = places((52, 52), (-9, 9), (-8, -3))


def test_an_ear_of_which_no_face_closes_the_sides_is_added_between_the_faces_that_are_known():
    told = known(
        [TOP, BOTTOM, LEDGE, SIDE], [ON_TOP, ON_BOTTOM, ON_LEDGE, places((30, 30), (-18, 18), (0, 8))]
    )
    whole = with_limbs(body(), None, told)
    piece = whole.pieces[-1]
    assert piece.operation == "add"
    assert {end for pair in piece.ends for end in pair} >= {1, 2}
    truth = Solid.from_csg(BLOCK | EAR, FACET)
    assert whole.solid.shared_volume(truth) > 0.98 * max(truth.volume, whole.solid.volume)


def test_an_ear_that_was_felt_from_below_alone_is_as_thick_as_to_the_next_face_that_is_known():
    told = known([TOP, BOTTOM, LEDGE], [ON_TOP, ON_BOTTOM, places((-28, -20), (-9, 9), (-2, -2))])
    whole = with_limbs(body(), None, told)
    reached = whole.solid.vertices[whole.solid.vertices[:, 0] > 40.0]
    assert reached[:, 2].max() == pytest.approx(-2.0, abs=0.01)


def test_what_no_face_explains_tells_where_an_ear_ends():
    told = known([TOP, BOTTOM, LEDGE], [ON_TOP, ON_BOTTOM, ON_LEDGE], stray=ON_END)
    whole = with_limbs(body(), None, told)
    assert whole.solid.bounds[1, 0] == pytest.approx(52.0, abs=1.0)


def test_a_pin_is_a_bar_with_the_radius_of_its_wall():
    turn = np.linspace(0.0, 2.0 * np.pi, 13)[:-1]
    wall = np.concatenate(
        [np.column_stack([7 * np.cos(turn), 7 * np.sin(turn), np.full(12, z)]) for z in (15, 20, 25)]
    )
    beside = ON_TOP[np.hypot(*ON_TOP[:, :2].T) > 9.0]
    told = known([TOP, RoundWall([0, 0, 0.0], [0, 0, 1.0], 7.0)], [beside, wall])
    whole = with_limbs(body(), None, told)
    assert whole.pieces[-1].kind == "cylinder"
    assert whole.pieces[-1].body == 1
    truth = Solid.from_csg(BLOCK | Cylinder(7.0, 15.5).at(0, 0, 17.75), FACET)
    assert whole.solid.volume == pytest.approx(truth.volume, rel=0.01)


def test_nothing_is_added_where_an_array_passed_through():
    given = body()
    told = known([TOP, BOTTOM, LEDGE], [ON_TOP, ON_BOTTOM, ON_LEDGE])
    passed = places((32, 56), (-9, 9), (-9, -3), 2.0)
    assert with_limbs(given, passed, told) is given
    assert with_limbs(given, np.concatenate([passed, [[np.nan, 0.0, 0.0]]]), told) is given


def test_strays_by_themselves_and_what_hangs_in_the_air_far_off_are_no_limb():
    given = body()
    far = places((90, 99), (0, 9), (0, 0))
    assert with_limbs(given, None, known([TOP], [ON_TOP], stray=ON_END)) is given
    assert with_limbs(given, None, known([TOP, BOTTOM], [ON_TOP, far])) is given


def test_the_root_of_a_limb_does_not_come_out_of_a_thin_body_behind():
    plate, under = Cube((60.0, 40.0, 4.0)), Plane([0, 0, -2.0], [0, 0, -1.0])
    turn = np.linspace(0.0, 2.0 * np.pi, 13)[:-1]
    ring = np.column_stack([7.0 * np.cos(turn), 7.0 * np.sin(turn), np.zeros(12)])
    wall = np.concatenate([ring + z * np.eye(3)[2] for z in (5.0, 10.0, 15.0)])
    told = known(
        [under, RoundWall([0, 0, 0.0], [0, 0, 1.0], 7.0)], [places((-28, 28), (-18, 18), (-2, -2)), wall]
    )
    whole = with_limbs(body(plate), None, told)
    assert whole.solid.bounds[1, 2] == pytest.approx(15.5)
    assert whole.solid.bounds[0, 2] == pytest.approx(-2.0)


def test_no_box_or_bar_stands_for_what_neither_explains():
    """A thin rod aslant: the box round it is felt at two of its edges alone."""
    along = np.linspace(0.0, 1.0, 30)[:, None] * [30.0, 24.0, 30.0]
    given, told = (
        body(),
        known([TOP, SIDE], [np.concatenate([ON_TOP, along + np.array([0.0, -10.0, 13.0])]), ON_END[:0]]),
    )
    assert with_limbs(given, None, told) is given


def test_a_great_many_contacts_of_a_limb_are_no_more_work_than_their_places():
    dense = np.random.default_rng(0).uniform([32, -9, -10.0], [52, 9, -10.0], (60_000, 3))
    told = known([TOP, BOTTOM, LEDGE], [ON_TOP, np.concatenate([ON_BOTTOM, dense]), ON_LEDGE])
    whole = with_limbs(body(), None, told)
    assert whole.solid.bounds[1, 0] == pytest.approx(52.0, abs=1.0)


def test_a_limb_on_a_turned_body_of_which_its_end_alone_was_felt_is_round():
    flange = Cylinder(30.0, 20.0)
    base = Body((Piece("cylinder", "add", flange, np.eye(4), 0, ()),), Solid.from_csg(flange, FACET), FACET)
    turn = np.linspace(0.0, 2.0 * np.pi, 13)[:-1]
    rim = np.concatenate(
        [np.column_stack([30 * np.cos(turn), 30 * np.sin(turn), np.full(12, z)]) for z in (-5, 5)]
    )
    end = places((-7, 7), (-7, 7), (40, 40), 2.0) + np.array([0.4, -0.3, 0.0])
    shapes = [RoundWall([0, 0, 0.0], [0, 0, 1.0], 30.0), BOTTOM, Plane([0, 0, 40.0], [0, 0, 1.0])]
    under = places((-20, 20), (-20, 20), (-10, -10))
    whole = with_limbs(base, None, known(shapes, [rim, under, end]))
    piece = whole.pieces[-1]
    assert piece.kind == "cylinder"
    assert piece.world_from_piece[:2, 3] == pytest.approx(0.0, abs=1e-9)
    assert whole.solid.bounds[:, 2] == pytest.approx([-10.0, 40.0], abs=0.01)
