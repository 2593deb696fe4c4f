"""Walls that no array can face, from the rims at which two faces end."""

from dataclasses import replace

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.inferring.rim_walls import rim_walls
from exploration.planning.inferring.upright_walls import upright_walls
from primitives.evidence import NOT_FELT, Contacts
from primitives.patch_graph import MergeOptions, ranked_face

X, Y, Z = np.eye(3)


def flat(number, normal, at, slot=0.0):
    u, v = np.roll(normal, 1), np.roll(normal, 2)
    points = at + np.array([a * u + b * v for a in (-9.0, 0.0, 9.0) for b in (-9.0, 0.0, 9.0)])
    points = points[(np.abs(points[:, 0]) >= slot) | (points[:, 2] < 0.0)]  # nothing is felt in a slot
    return ranked_face(number, Contacts.of(points, np.tile(normal, (len(points), 1))), MergeOptions())


FACES = [flat(k, way, far * way, 8.5) for k, (way, far) in enumerate(((Z, 15), (Y, 25), (-Y, 25), (X, 30)))]


def rim(point, tangent, outward, normal):
    return Sighting(np.array(point), tangent, outward, normal, 0.05, 12.0)


TOP_LEFT = rim([-8.0, 0.0, 15.0], Y, X, Z), 0
NEAR_LEFT, FAR_LEFT = (rim([-8.1, 25.0, 8.0], Z, X, Y), 1), (rim([-8.0, -25.0, 8.0], Z, X, -Y), 2)
NEAR_FLOOR, FAR_FLOOR = (rim([0.0, 25.0, 0.0], X, Z, Y), 1), (rim([1.0, -25.0, 0.1], X, Z, -Y), 2)


def test_a_wall_of_a_slot_is_the_plane_of_its_rims_on_the_top_and_at_the_ends():
    (wall,) = rim_walls([TOP_LEFT, NEAR_LEFT, FAR_LEFT], FACES)
    assert (wall.touch == NOT_FELT).all()
    assert (wall.normals @ X > 0.999).all()
    assert np.abs(wall.points[:, 0] + 8.0).max() < 0.2


def test_its_floor_is_the_plane_of_the_rims_at_its_ends():
    (floor,) = rim_walls([NEAR_FLOOR, FAR_FLOOR], FACES)
    assert (floor.normals @ Z > 0.999).all()
    assert np.abs(floor.points[:, 2]).max() < 0.2


def test_rims_that_share_no_plane_or_look_to_each_other_are_of_no_wall():
    right = rim([8.0, -25.0, 8.0], Z, -X, -Y), 2
    apart = rim([-5.0, -25.0, 8.0], Z, X, -Y), 2
    assert rim_walls([TOP_LEFT, NEAR_FLOOR], FACES) == []
    assert rim_walls([NEAR_LEFT, right], FACES) == []
    assert rim_walls([NEAR_LEFT, apart], FACES) == []


def test_a_wall_that_runs_as_no_face_does_stands_upright_between_rims_of_parallel_faces():
    out = np.array([0.5, np.sqrt(0.75), 0.0])
    along = np.cross(out, Z)
    top = rim([5.0, 3.0, 15.0], along, out, Z), 0
    below = rim([5.0, 3.0, -15.0] + 4.0 * along, along, out, -Z), 4
    (wall,) = rim_walls([top, below], FACES)
    assert (wall.normals @ out > 0.999).all()
    assert np.abs((wall.points - [5.0, 3.0, 0.0]) @ out).max() < 1e-6
    leaning = rim([5.0, 3.0, -15.0] + 2.0 * out, along, out, -Z), 4
    assert rim_walls([top, leaning], FACES) == []


def test_upright_walls_join_a_known_floor_to_rims_that_look_to_each_other():
    top_right = rim([8.0, 3.0, 15.0], Y, -X, Z), 0
    walls = rim_walls([TOP_LEFT, top_right, NEAR_FLOOR, FAR_FLOOR], FACES)
    found = sorted(
        (float(w.normals[0] @ X), float(w.points[:, 0].mean()), float(w.points[:, 2].min())) for w in walls
    )
    assert len(found) == 3
    for (way, place, low), (asked, there) in zip(
        (found[0], found[2]), ((-1.0, 8.0), (1.0, -8.0)), strict=True
    ):
        assert abs(way - asked) < 1e-3
        assert abs(place - there) < 0.2
        assert 0.0 < low < 3.0
    assert len(rim_walls([TOP_LEFT, top_right], FACES)) == 0


def test_below_a_rim_of_its_own_a_wall_stands_upright_down_to_the_next_face():
    step = flat(4, Z, np.array([8.0, 0.0, 6.0]))
    tilted = rim([-8.0, 0.0, 15.0], Y, np.cos(0.02) * X + np.sin(0.02) * Y, Z), 0
    (wall,) = upright_walls([tilted], [*FACES, step])
    assert (wall.touch == NOT_FELT).all()
    assert (wall.normals @ X > 0.999999).all()  # as the object's other faces stand
    assert np.abs(wall.points[:, 0] + 8.0).max() < 0.2
    assert 6.0 < wall.points[:, 2].min() < 8.0


def test_a_wall_between_two_rims_is_told_beside_them_and_not_where_something_may_stand_on_it():
    ends = [rim([x, 0.0, 0.0], Y, Z, np.sign(x) * X) for x in (-18.0, 18.0)]
    sides = [flat(k, np.sign(end.point[0]) * X, end.point) for k, end in enumerate(ends)]
    (top,) = rim_walls([(end, k) for k, end in enumerate(ends)], sides)
    assert np.abs(top.normals - Z).max() < 1e-6
    assert (18.0 - np.abs(top.points[:, 0])).max() < 3.0


def test_an_edge_that_many_parts_of_a_pad_show_leaves_room_for_others():
    many = [rim([-8.0, 0.01 * k, 15.0], Y, X, Z) for k in range(30)]
    short = Sighting(np.array([9.0, 0.0, 15.0]), Y, -X, Z, 0.05, 5.0)
    walls = upright_walls([(many[0], 0)], FACES, [*((seen, 0) for seen in many), (short, 0)])
    assert len(walls) == 2


def test_a_piece_of_a_round_rim_seen_beside_others_makes_no_wall():
    way = np.array([0.8, 0.6, 0.0])
    piece = rim([9.0, 4.0, 15.0], np.cross(Z, way), way, Z), 0
    assert upright_walls([], FACES, [piece]) == []


def test_a_wall_that_runs_as_no_face_does_needs_another_that_looks_back_at_it():
    way = np.array([0.8, 0.6, 0.0])
    near = rim(15.0 * Z - 9.0 * way, np.cross(Z, way), way, Z), 0
    far = rim(15.0 * Z + 9.0 * way, np.cross(Z, way), -way, Z), 0
    assert upright_walls([near], FACES) == []
    assert len(upright_walls([near, far], FACES)) == 2


def test_a_rim_too_long_to_be_of_a_circle_makes_a_wall_whichever_way_it_runs_and_so_do_others_along_it():
    way = np.array([0.8, 0.6, 0.0])
    long = replace(rim(15.0 * Z - 9.0 * way, np.cross(Z, way), way, Z), length=28.0), 0
    seen = rim(15.0 * Z + 9.0 * way, np.cross(Z, way), -way, Z), 0
    assert [wall.normals[0].tolist() for wall in upright_walls([long], FACES)] == [way.tolist()]
    assert len(upright_walls([long], FACES, [seen])) == 2


def test_a_long_rim_that_runs_nearly_as_the_object_does_runs_as_it_does():
    way = np.array([np.cos(0.025), np.sin(0.025), 0.0])
    long = replace(rim(15.0 * Z - 9.0 * X, np.cross(Z, way), way, Z), length=28.0), 0
    (wall,) = upright_walls([long], FACES)
    assert wall.normals[0].tolist() == X.tolist()


def test_a_wall_is_upright_on_its_face_though_the_pad_leaned_that_saw_its_rim():
    lean = np.array([0.03, 0.0, 1.0]) / np.hypot(1.0, 0.03)
    seen = rim([-9.0, 0.0, 15.0], Y, np.cross(Y, lean), lean), 0
    floor = flat(9, Z, -25.0 * Z)
    (wall,) = upright_walls([seen], [*FACES, floor])
    assert np.ptp(wall.points[:, 2]) > 30.0
    assert np.abs(wall.points[:, 0] + 9.0).max() < 1e-9


def test_long_rims_that_bend_from_look_to_look_make_no_walls():
    turns = np.array([0.5, 0.75, 1.0])
    ways = np.column_stack([np.cos(turns), np.sin(turns), np.zeros(3)])
    rims = [(replace(rim(15.0 * Z + 100.0 * w, np.cross(Z, w), w, Z), length=25.0), 0) for w in ways]
    assert upright_walls(rims, FACES) == []
    assert len(upright_walls(rims[:1], FACES)) == 1


def test_an_edge_seen_of_a_round_face_makes_no_upright_wall():
    turn = np.linspace(0.0, 5.0, 20)
    normals = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(20)])
    points = 12.0 * normals + np.outer(np.linspace(-9.0, 9.0, 20), Z)
    barrel = ranked_face(7, Contacts.of(points, normals), MergeOptions())
    assert barrel.fit.kind == "cylinder"
    edge = rim([12.0, 0.0, 3.0], Z, Y, X)
    assert upright_walls([(edge, 7)], [*FACES, barrel]) == []
    assert len(upright_walls([(edge, 3)], FACES)) == 1


def test_narrow_letters_on_opposite_faces_are_no_slot_right_through():
    def letter(wide):
        sides = [(x, out) for x, out in ((-0.5 * wide, X), (0.5 * wide, -X))]
        near = [(rim([x, 25.0, 8.0], Z, out, Y), 1) for x, out in sides]
        return [*near, *((rim([x, -25.0, 8.0], Z, out, -Y), 2) for x, out in sides)]

    assert rim_walls(letter(4.0), FACES) == []
    assert len(rim_walls(letter(12.0), FACES)) == 2


def test_nor_are_those_of_which_one_rim_was_seen_and_the_face_was_felt_on_beyond_them():
    seen = [(rim([4.0, 25.0 * side, -3.0], Z, X, side * Y), k) for k, side in ((1, 1.0), (2, -1.0))]
    assert rim_walls(seen, FACES) == []  # contacts at x = 9


def test_a_wall_goes_down_to_the_object_s_back_but_in_a_gap_far_deeper_than_it_is_wide():
    back = flat(9, -Z, -45.0 * Z)
    seen = [rim([x, 0.0, 15.0], Y, out, Z) for x, out in ((-9.0, X), (-5.0, -X))]
    side, looks_back = (replace(one, length=25.0) for one in seen)
    (deep,) = upright_walls([(side, 0)], [back])
    assert np.ptp(deep.points[:, 2]) > 55.0
    shallow = upright_walls([(side, 0), (looks_back, 0)], [back])
    assert [float(np.ptp(wall.points[:, 2])) < 3.0 for wall in shallow] == [True, True]


def test_short_rims_tell_no_lean_that_the_object_does_not_have():
    """As of one taken from a picture near a corner: 4 degrees aslant, 10 and 5 mm long."""
    lean = np.array([np.cos(0.07), 0.0, np.sin(0.07)])
    near = Sighting(np.array([-8.0, 25.0, 8.0]), np.cross(Y, lean), lean, Y, 0.04, 10.0), 1
    far = Sighting(np.array([-8.0, -25.0, 8.0]), np.cross(-Y, lean), lean, -Y, 0.16, 5.0), 2
    (wall,) = rim_walls([near, far], FACES)
    assert (wall.normals @ X > 0.9999).all()
    (leaning,) = rim_walls([(replace(rim, length=12.0, sigma=0.02), own) for rim, own in (near, far)], FACES)
    assert (leaning.normals @ lean > 0.9999).all()
