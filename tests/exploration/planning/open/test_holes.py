"""Which rims are the two ends of one hole, straight, slanting and across round faces."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.planning.open.holes import holes_of
from exploration.planning.open.round_rims import RoundRim
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from primitives.patch_graph import MergeOptions, ranked_face

Z = np.eye(3)[2]
NOWHERE = np.empty((0, 3))


def rim(height, up=1.0, radius=6.0, x=0.0, measured=True):
    return RoundRim(np.array([x, 0.0, height]), up * Z, radius, 0.02, 0, measured)


def test_two_rims_that_look_away_from_each_other_are_one_hole():
    (hole,), left = holes_of([rim(5.0), rim(-5.0, -1.0)], NOWHERE)
    assert not left
    wall = hole.wall()
    found = fit("cylinder", wall)
    assert found
    assert not found.convex
    assert abs(found.shape.radius - 6.0) < 0.05
    assert (wall.touch == NOT_FELT).all()


def test_other_rims_are_left_unknown():
    lone = [rim(5.0)]
    facing = [rim(-5.0), rim(5.0, -1.0)]  # a gap between them, no material
    unlike = [rim(5.0), rim(-5.0, -1.0, radius=8.0)]
    beside = [rim(5.0), rim(-5.0, -1.0, x=2.0)]
    for rims in (lone, facing, unlike, beside):
        assert holes_of(rims, NOWHERE) == ([], rims)


def test_a_wide_ring_that_was_guessed_is_the_other_end_of_a_bore_and_a_counterbore_is_none():
    wide = [rim(5.0, radius=29.7), rim(-5.0, -1.0, radius=27.3, measured=False)]
    (hole,), left = holes_of(wide, NOWHERE)
    assert not left
    assert abs(hole.radius - 29.7) < 0.1
    stepped = [rim(5.0, radius=3.4), rim(-5.0, -1.0, radius=5.2, measured=False)]
    assert holes_of(stepped, NOWHERE)[0] == []


def test_a_rim_that_was_looked_at_speaks_for_a_guess_at_the_other_end_and_two_guesses_for_nothing():
    guess = rim(-5.0, -1.0, radius=5.2, x=0.7, measured=False)
    (hole,), left = holes_of([rim(5.0), guess], NOWHERE)
    assert not left
    assert abs(hole.radius - 6.0) < 0.05
    assert np.linalg.norm(hole.middle) < 0.05
    assert not holes_of([rim(5.0, measured=False), guess], NOWHERE)[0]


def test_of_lugs_in_a_row_the_nearest_rims_are_one_hole():
    rims = [rim(5.0), rim(-5.0, -1.0), rim(-25.0), rim(-35.0, -1.0)]
    holes, left = holes_of(rims, NOWHERE)
    assert not left
    assert [hole.depth for hole in holes] == [10.0, 10.0]


def test_a_hole_is_as_deep_as_an_array_went_in():
    went = np.column_stack([np.zeros((8, 2)), np.linspace(-7.0, 9.0, 8)])
    (hole,), left = holes_of([rim(5.0)], went)
    assert not left
    assert abs(hole.depth - 12.0) < 1e-9


def test_contacts_in_the_mouth_of_a_hole_are_no_places_of_its_face():
    (hole,), _ = holes_of([rim(5.0), rim(-5.0, -1.0)], NOWHERE)
    points = np.array([[0.0, 0.0, 5.0], [4.0, 1.0, 5.0], [9.0, 0.0, 5.0], [-9.0, 9.0, 5.0], [0.0, 12.0, 5.0]])
    face = ranked_face(0, Contacts.of(points, np.tile(Z, (5, 1))), MergeOptions())
    kept = hole.off(face)
    assert len(kept.contacts) == len(kept.fit.inliers) == 3
    assert kept.fit.shape is face.fit.shape


def test_who_was_behind_a_face_touched_across_a_hole_did_not_go_through_it():
    went = np.column_stack([np.zeros((4, 2)), [4.0, 2.0, -3.5, -9.0]])
    (through,), _ = holes_of([rim(5.0)], went)
    assert through.depth == 14.0
    (hole,), _ = holes_of([rim(5.0)], went, lambda _: 8.0)
    assert hole.depth == 3.0


def ends(lean, radius=5.0):
    """A hole along z from a flat face up to one that leans by so much [rad], whose rim passes for a circle."""
    below = RoundRim(np.array([3.0, 2.0, 0.0]), -Z, radius, 0.02, 0, True)
    axis = np.array([np.sin(lean), 0.0, np.cos(lean)])
    above = RoundRim(np.array([3.2, 2.0, 30.0]), axis, radius * (0.5 + 0.5 / np.cos(lean)), 0.02, 1, True)
    return below, above


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("lean", [0.25, 0.5, 0.8])
def test_the_narrower_of_two_rims_tells_how_a_slanting_hole_runs(lean, order):
    (hole,), left = holes_of(ends(lean)[::order], NOWHERE)
    assert not left
    assert np.allclose(hole.axis, -Z)
    assert hole.radius == 5.0
    assert abs(hole.depth - 30.0) < 0.1


def mouth(angle, height, up=0.0, radius=5.0):
    """A hole's mouth in the side of a round body, that looks up a little."""
    way = np.array([np.cos(angle), np.sin(angle), 0.0])
    axis = np.cos(up) * way + np.sin(up) * Z
    return RoundRim(20.0 * way + height * Z, axis, radius, 0.3, 0, True, bent=True)


def test_two_mouths_in_a_cones_side_are_one_hole_and_those_of_three_screws_are_none():
    (hole,), left = holes_of([mouth(0.0, 7.0, 0.25), mouth(np.pi, 7.0, 0.25, 5.3)], NOWHERE)
    assert not left
    assert abs(hole.axis @ Z) < 1e-9
    assert abs(hole.depth - 40.0) < 1e-9
    assert np.allclose(hole.middle, 7.0 * Z)
    three = [mouth(angle, 7.0) for angle in (0.0, 2.0 * np.pi / 3.0, 4.0 * np.pi / 3.0)]
    assert holes_of(three, NOWHERE) == ([], three)
    assert holes_of([mouth(0.0, 7.0), mouth(np.pi, 7.0, radius=7.0)], NOWHERE)[0] == []


def test_two_rims_that_lean_are_no_hole_where_they_do_not_meet_or_the_other_is_too_wide():
    below, above = ends(0.5)
    beside = replace(above, center=above.center + np.array([4.0, 0.0, 0.0]))
    wide = replace(above, radius=7.0)
    narrow = replace(above, radius=4.0)
    for other in (beside, wide, narrow, replace(above, measured=False)):
        holes, left = holes_of([below, other], NOWHERE)
        assert not holes
        assert [rim.face for rim in left] == [0, 1]
