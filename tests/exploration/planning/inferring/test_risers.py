"""A plate with a pocket whose walls nobody felt, and an island in it, as the skin would have felt them."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.planning.inferring.patch import Patch
from exploration.planning.inferring.risers import RiserConfig, _ring, _Wall, risers
from exploration.planning.open.known_face import KnownFace
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from primitives.patch_graph import Face

FLOOR, TOP = -11.0, 0.0
SIDE, ISLAND = (30.0, 25.0), 9.0


def flat(number, points, normal, free=()):
    """A face that was touched at points, with a contact each."""
    contacts = Contacts.of(
        points, np.tile(normal, (len(points), 1)), sigma=0.01, normal_sigma=0.01, touch=number
    )
    found = fit("plane", contacts)
    side = 1.0 if found.convex else -1.0
    return KnownFace(Face(number, found, contacts), found, side, points, np.array(free).reshape(-1, 3))


def places(height, inside, step=2.0, reach=40.0):
    """Places on a grid at a height where `inside` says so."""
    grid = np.arange(-reach, reach + step, step)
    x, y = (g.ravel() for g in np.meshgrid(grid, grid))
    keep = inside(x, y)
    return np.column_stack([x[keep], y[keep], np.full(int(keep.sum()), height)])


def in_pocket(x, y, less=0.0):
    return (np.abs(x) < SIDE[0] - less) & (np.abs(y) < SIDE[1] - less)


def plate(*more, island=lambda x, y: np.hypot(x, y) < ISLAND):
    """Top, floor and an outer side; the floor was felt no nearer than 4 mm to its walls."""
    top = places(TOP, lambda x, y: ~in_pocket(x, y) | island(x, y))
    missing = places(TOP - 0.6, lambda x, y: in_pocket(x, y, 2.0) & ~island(x, y))
    floor = places(FLOOR, lambda x, y: in_pocket(x, y, 4.0) & (np.hypot(x, y) > 14.0))
    outer = places(40.0, lambda x, y: np.abs(y) < 5.0)[:, [2, 0, 1]]
    up = [0.0, 0.0, 1.0]
    return [flat(0, top, up, missing), flat(1, floor, up), flat(2, outer, [1.0, 0.0, 0.0]), *more]


def test_a_face_that_lies_over_another_says_nothing_of_walls_at_its_ends():
    """The inner side of one wall of a box looks as the outer side of the opposite one, far over it."""
    inner = flat(0, places(0.0, lambda x, y: (np.abs(x) < 20.0) & (np.abs(y) < 4.0)), [0.0, 0.0, 1.0])
    outer = flat(1, places(60.0, lambda x, y: (np.abs(x) < 36.0) & (np.abs(y) < 12.0)), [0.0, 0.0, 1.0])
    side = flat(2, places(40.0, lambda x, y: np.abs(y) < 5.0)[:, [2, 0, 1]], [1.0, 0.0, 0.0])
    assert risers([inner, outer, side]) == []
    assert risers([inner, outer, side], config=RiserConfig(beside=-1.0)) != []


def test_walls_of_a_pocket_stand_where_its_floor_ends_and_the_face_above_begins():
    walls = [r.contacts for r in risers(plate()) if r.kind == "plane"]
    stands = {tuple(np.round(c.normals[0]).astype(int)): float(c.points[0] @ -c.normals[0]) for c in walls}
    assert set(stands) == {(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0)}
    for (x, _, _), at in stands.items():
        assert abs(at - SIDE[0 if x else 1]) < 2.1
    for wall in walls:
        assert wall.points[:, 2].min() > FLOOR
        assert wall.points[:, 2].max() < TOP
        assert wall.sigma.min() >= 0.5


def test_an_island_without_corners_is_round():
    (ring,) = (r.contacts for r in risers(plate()) if r.kind == "cylinder")
    assert np.abs(np.hypot(*ring.points[:, :2].T) - ISLAND).max() < 2.0
    assert (ring.points[:, :2] * ring.normals[:, :2]).sum(axis=1).min() > 0.0


def test_it_is_round_yet_where_a_stroke_was_stopped_by_one_side_of_it():
    wall = np.array([[ISLAND, y, z] for y in (-4.0, 0.0, 4.0) for z in (-8.0, -3.0)])
    (ring,) = (r.contacts for r in risers(plate(flat(5, wall, [1.0, 0.0, 0.0]))) if r.kind == "cylinder")
    assert np.abs(np.hypot(*ring.points[:, :2].T) - ISLAND).max() < 2.0


def test_an_island_with_corners_has_four_walls():
    square = plate(island=lambda x, y: (np.abs(x) < ISLAND) & (np.abs(y) < ISLAND))
    found = risers(square)
    assert {r.kind for r in found} == {"plane"}
    assert len(found) == 8


def test_a_floor_that_was_only_inferred_does_not_tell_where_it_ends():
    top, floor, *rest = plate()
    told = floor.face.contacts
    guessed = replace(told, touch=np.full(len(told), NOT_FELT))
    known = [top, replace(floor, face=replace(floor.face, contacts=guessed)), *rest]
    assert len(risers(known)) < len(risers([top, floor, *rest]))


def test_a_wall_that_is_known_is_not_inferred_again():
    x = SIDE[0]
    points = np.array([[x, y, z] for y in np.arange(-10.0, 11.0, 2.0) for z in (-8.0, -4.0)])
    found = risers(plate(flat(3, points, [-1.0, 0.0, 0.0])))
    assert not [r for r in found if r.kind == "plane" and r.contacts.normals[0, 0] < -0.5]
    assert len([r for r in found if r.kind == "plane"]) == 3


def test_a_wall_that_is_known_stands_behind_where_blur_lets_the_face_above_begin():
    up, side = [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]
    top = flat(0, places(TOP, lambda x, y: x > -3.0), up, places(TOP - 0.6, lambda x, y: x < -4.5))
    floor = flat(1, places(FLOOR, lambda x, y: x < -6.0), up)
    outer = flat(2, places(40.0, lambda x, y: np.abs(y) < 5.0)[:, [0, 2, 1]], side)
    wall = np.array([[0.0, y, z] for y in np.arange(-10.0, 11.0, 2.0) for z in (-8.0, -4.0)])
    assert any(r.contacts.normals[0, 0] < -0.9 for r in risers([top, floor, outer]))
    assert risers([top, floor, outer, flat(3, wall, [-1.0, 0.0, 0.0])]) == []


@pytest.mark.parametrize("reach", [4.0])
def test_where_the_floor_runs_out_to_the_side_there_is_no_wall(reach):
    step = [
        flat(0, places(TOP, lambda x, y: x < 0.0), [0.0, 0.0, 1.0], places(TOP - 0.6, lambda x, y: x > 2.0)),
        flat(1, places(FLOOR, lambda x, y: x > reach), [0.0, 0.0, 1.0]),
        flat(2, places(40.0, lambda x, y: np.abs(y) < 5.0)[:, [2, 0, 1]], [1.0, 0.0, 0.0]),
    ]
    found = risers(step)
    assert found
    for riser in found:
        assert np.abs(riser.contacts.normals[:, 0]).min() > 0.99
        assert abs(float(riser.contacts.points[0, 0]) - 1.0) < 1.5


def test_a_row_of_places_with_walls_as_far_all_round_is_no_round_island():
    cells = np.array([[x, 0.0, 0.0] for x in np.arange(-8.0, 9.0, 2.0)])
    patch = Patch(flat(0, places(TOP, lambda x, y: x < 0.0), [0.0, 0.0, 1.0]), cells, np.eye(3)[2])
    ways = (np.eye(3)[0], -np.eye(3)[0], np.eye(3)[1], -np.eye(3)[1])
    assert _ring(patch, [_Wall(way, 9.0, 0.5, FLOOR) for way in ways], RiserConfig()) is None


def test_a_floor_in_a_round_hole_has_no_straight_walls():
    """Its wall was made out from the rim; where the face above begins does not move it."""
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    ways = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(24)])
    places_ = np.concatenate([40.0 * ways + [0.0, 0.0, z] for z in (-9.0, -2.0)])
    contacts = Contacts.of(places_, np.tile(-ways, (2, 1)), sigma=0.01, normal_sigma=0.01, touch=9)
    found = fit("cylinder", contacts)
    round_wall = KnownFace(Face(9, found, contacts), found, -1.0, places_, np.empty((0, 3)))
    known = plate(island=lambda x, y: np.zeros_like(x, dtype=bool))
    assert len(risers(known)) == 4
    assert risers([*known, round_wall]) == []


def test_no_wall_stands_between_the_foot_and_the_top_of_a_pyramid_where_its_sides_do():
    """They are crossed half way between where the top ends and where the foot begins, far from either."""
    top, low, inner, outer = 30.0, 0.0, 12.0, 30.0
    square = places(top, lambda x, y: np.maximum(np.abs(x), np.abs(y)) < inner)
    missing = places(top - 0.6, lambda x, y: np.abs(np.maximum(np.abs(x), np.abs(y)) - inner - 2.0) < 2.0)
    foot = places(low, lambda x, y: np.maximum(np.abs(x), np.abs(y)) > outer + 1.0, reach=44.0)
    slope = np.hypot(top, outer - inner)
    sides = []
    for k, (x, y) in enumerate(((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))):
        normal = np.array([top * x, top * y, outer - inner]) / slope
        along, up = np.array([-y, x, 0.0]), np.cross(normal, [-y, x, 0.0])
        middle = np.array([x, y, 0.0]) * 0.5 * (inner + outer) + [0.0, 0.0, 0.5 * top]
        points = np.array([middle + a * along + b * up for a in (-8, 0, 8) for b in (-12, -6, 0, 6, 12)])
        sides.append(flat(3 + k, points, normal))
    faces = [flat(0, square, [0.0, 0.0, 1.0], missing), flat(1, foot, [0.0, 0.0, 1.0])]
    faces.append(flat(2, places(60.0, lambda x, y: np.abs(y) < 5.0)[:, [2, 0, 1]], [1.0, 0.0, 0.0]))
    assert risers(faces) != []
    assert risers([*faces, *sides]) == []


def test_no_wall_goes_down_from_a_pocket_in_a_raised_block_to_what_lies_round_that():
    """The block ends again just past the pocket's rim, so that this is not made out."""
    up, square = [0.0, 0.0, 1.0], lambda x, y: np.maximum(np.abs(x), np.abs(y))
    floor = flat(1, places(-5.0, lambda x, y: square(x, y) < 6.0), up)
    gone = places(
        -0.6, lambda x, y: ((square(x, y) > 15.0) & (square(x, y) < 24.0)) | (square(x, y) < 13.0), 1.0
    )
    block = flat(0, places(0.0, lambda x, y: square(x, y) == 14.0), up, gone)
    low = flat(3, places(-10.0, lambda x, y: square(x, y) > 25.0), up)
    side = flat(2, places(40.0, lambda x, y: np.abs(y) < 5.0)[:, [2, 0, 1]], [1.0, 0.0, 0.0])
    found = [riser.contacts for riser in risers([floor, block, low, side])]
    assert not any((wall.points[:, 2].max() < -5.0) and np.abs(wall.points).max() < 16.0 for wall in found)
