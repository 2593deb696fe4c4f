"""Round walls from the circle at which a flat face ends."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.control.sighting import Sighting
from exploration.planning.inferring.round_walls import round_walls
from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.open.known_face import KnownFace
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from primitives.patch_graph import MergeOptions, ranked_face

X, Y, Z = np.eye(3)
NOWHERE = np.empty((0, 3))
GRID = np.stack(np.meshgrid(np.arange(-24.0, 25.0, 2.0), np.arange(-24.0, 25.0, 2.0)), axis=-1).reshape(-1, 2)


def flat(number, inside, height=0.0, up=1.0, free=None):
    """A face felt where `inside` says so, and found free elsewhere."""
    kept = inside(GRID)
    points = np.column_stack([GRID[kept], np.full(kept.sum(), height)])
    normals = np.tile(up * Z, (len(points), 1))
    face, felt = ranked_face(number, Contacts.of(points, normals), MergeOptions()), SurfaceMap()
    felt.add(points, normals)
    places = np.column_stack([GRID[~kept], np.full((~kept).sum(), height - 0.5 * up)])
    return KnownFace.of(face, face.fit, felt, places if free is None else free, 5.0)


def disc(radius, bore=0.0):
    return lambda xy: (np.hypot(*xy.T) < radius) & (np.hypot(*xy.T) >= bore)


def edge(angle, radius, own=0):
    way = np.array([np.cos(angle), np.sin(angle), 0.0])
    return Sighting(radius * way, np.cross(Z, way), way, Z, 0.05, 12.0), own


TOP, FLOOR = flat(0, disc(14.0)), flat(1, disc(25.0), -10.0)
EDGES = [edge(angle, 14.6) for angle in (0.3, 1.0, 2.5, 4.0, 5.4)]


def walls(rims, known, ends=None, free=NOWHERE):
    return round_walls(rims, known, ends or [(NOWHERE, NOWHERE)] * len(known), free)


def test_edges_of_one_circle_are_the_end_of_a_round_wall_as_deep_as_the_next_face():
    (lot,) = walls(EDGES, [TOP, FLOOR])
    found = fit("cylinder", lot)
    assert found
    assert found.convex
    assert found.shape.radius == pytest.approx(14.6, abs=0.01)
    assert (lot.touch == NOT_FELT).all()
    assert lot.points[:, 2].min() == pytest.approx(-9.5)


def test_the_middles_of_a_hexagon_s_sides_are_no_circle_nor_are_edges_on_one_side():
    sides = [edge(k * np.pi / 3.0, 14.6) for k in range(6)]
    assert walls(sides, [TOP, FLOOR]) == []
    assert walls([edge(angle, 14.6) for angle in (0.1, 0.5, 1.1, 1.7)], [TOP, FLOOR]) == []


def test_edges_of_letters_in_a_face_that_goes_on_past_their_circle_are_no_end_of_a_wall():
    around = flat(0, lambda xy: (np.hypot(*xy.T) < 13.0) | (np.hypot(*xy.T) > 17.0))
    assert len(walls(EDGES, [TOP, FLOOR])) == 1
    assert walls(EDGES, [around, FLOOR]) == []


def test_the_end_of_a_cylinder_that_was_felt_is_no_other_wall():
    """Corners of facets lie farther out than most of what was felt of it."""
    turn, down = (lot.ravel() for lot in np.meshgrid(np.arange(0.0, 6.2, 0.2), np.arange(-9.0, 0.0, 2.0)))
    ways = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])

    def wall(radius):
        points = radius * ways + np.outer(down, Z)
        face, felt = ranked_face(5, Contacts.of(points, ways), MergeOptions()), SurfaceMap()
        felt.add(points, ways)
        return KnownFace.of(face, face.fit, felt, NOWHERE, 5.0)

    assert walls(EDGES, [TOP, FLOOR, wall(14.1)]) == []
    assert len(walls(EDGES, [TOP, FLOOR, wall(12.0)])) == 1


def test_where_an_array_was_behind_it_there_is_no_wall_and_below_its_land_a_groove():
    turn = np.linspace(0.0, 6.0, 20)
    ring = 12.0 * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(20)])
    assert walls(EDGES, [TOP, FLOOR], free=ring - 2.0 * Z) == []
    (lot,) = walls(EDGES, [TOP, flat(2, disc(14.0), -20.0, -1.0)], free=ring - 10.0 * Z)
    assert lot.points[:, 2].min() > -5.0


def test_two_ends_of_one_wall_are_equally_round():
    below = flat(2, disc(14.0), -20.0, -1.0)
    other = [replace(rim, point=rim.point * (15.4 / 14.6) - 20.0 * Z, normal=-Z) for rim, _ in EDGES]
    lots = walls([*EDGES, *((rim, 2) for rim in other)], [TOP, below])
    assert len(lots) == 2
    assert np.allclose([np.hypot(*lot.points[:, :2].T).max() for lot in lots], 14.6, atol=0.01)


def test_a_hub_s_outline_serves_where_no_edge_was_made_out_and_nothing_explains_it():
    hub = flat(0, disc(14.0, 5.0))
    (lot,) = walls([], [hub, FLOOR], [hub.rim, (NOWHERE, NOWHERE)])
    assert fit("cylinder", lot).shape.radius == pytest.approx(14.0, abs=2.0)
    at, out = hub.rim
    some = at[:, 0] > 0.0
    assert walls([], [hub, FLOOR], [(at[some], out[some]), (NOWHERE, NOWHERE)]) == []
    square = flat(0, lambda xy: np.abs(xy).max(axis=1) < 13.0)
    assert walls([], [square, FLOOR], [square.rim, (NOWHERE, NOWHERE)]) == []


def test_a_disc_with_a_notch_is_round_where_it_is_not_cut_and_a_gear_s_tips_are_no_wall():
    def notched(xy):
        return disc(22.0)(xy) & ~((xy[:, 0] > 10.0) & (np.abs(xy[:, 1]) < 8.0))

    def gear(xy):
        teeth = np.cos(8.0 * np.arctan2(xy[:, 1], xy[:, 0])) > 0.2
        return disc(16.0)(xy) | disc(23.0)(xy) & teeth

    plate = flat(0, notched)
    in_the_notch = np.array([[20.0, 2.0 * k, -1.0] for k in range(-3, 4)])
    (lot,) = walls([], [plate, FLOOR], [plate.rim, (NOWHERE, NOWHERE)], free=in_the_notch)
    assert fit("cylinder", lot).shape.radius == pytest.approx(22.0, abs=1.5)
    wheel = flat(0, gear)
    assert walls([], [wheel, FLOOR], [wheel.rim, (NOWHERE, NOWHERE)]) == []
    turn = np.linspace(0.0, 6.2, 60)
    groove = 18.0 * np.column_stack([np.cos(turn), np.sin(turn), np.zeros(60)]) - Z
    assert walls([], [plate, FLOOR], [plate.rim, (NOWHERE, NOWHERE)], free=groove) == []


def test_the_wall_of_a_sheet_is_no_higher_than_the_sheet():
    sheet = [flat(0, disc(14.0)), flat(1, disc(14.0), -1.0, -1.0)]
    lots = walls(EDGES, sheet)
    assert lots
    assert all(lot.points[:, 2].min() > -1.0 for lot in lots)


def test_a_wall_is_as_deep_as_the_face_below_its_edge_though_its_middle_is_bored():
    ring = [flat(0, disc(24.0, 18.0)), flat(1, disc(24.0, 18.0), -1.0, -1.0)]
    rims = [edge(angle, 24.0) for angle in (0.3, 1.0, 2.5, 4.0, 5.4)]
    lots = walls(rims, ring)
    assert lots
    assert all(lot.points[:, 2].min() > -1.0 for lot in lots)


def test_each_of_a_face_s_pieces_that_lie_apart_may_be_round():
    shifts = (np.array([-13.0, -4.0, 0.0]), np.array([13.0, 5.0, 0.0]))
    feet = flat(0, lambda xy: np.any([np.hypot(*(xy - shift[:2]).T) < 9.0 for shift in shifts], axis=0))
    rims = [
        (replace(rim, point=rim.point + shift), own)
        for shift in shifts
        for rim, own in (edge(angle, 9.5) for angle in (0.3, 1.0, 2.5, 4.0, 5.4))
    ]
    found = [fit("cylinder", lot) for lot in walls(rims, [feet, FLOOR])]
    assert [each.shape.radius for each in found] == pytest.approx([9.5, 9.5], abs=0.01)
    for each, shift in zip(found, shifts, strict=True):
        assert np.abs(each.shape.signed_distance(shift[None]))[0] == pytest.approx(9.5, abs=0.01)


def test_a_face_without_touched_places_makes_none():
    bare = replace(TOP, cells=NOWHERE)
    assert walls([], [bare]) == []
