"""Where holes come out of faces of which nobody saw the rim there."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.planning.inferring.far_ends import (
    WHERE_TO_LOOK,
    far_ends,
    narrowed_ends,
    narrower_ends,
    shut,
)
from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.round_rims import RoundRim
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, ranked_face

Z = np.eye(3)[2]
GRID = np.stack(np.meshgrid(np.arange(-20.0, 21.0, 1.0), np.arange(-20.0, 21.0, 1.0)), axis=-1).reshape(-1, 2)
RIM = RoundRim(np.array([5.0, 0.0, 10.0]), Z, 4.0, 0.02, 0, True)


def under(hole_at=(5.0, 0.0), height=0.0, up=-1.0):
    """The face behind, felt but for a hole at a place, of which it is known that it is not there."""
    kept = np.linalg.norm(GRID - hole_at, axis=1) > 4.0
    points = np.column_stack([GRID[kept], np.full(kept.sum(), height)])
    free = np.column_stack([GRID[~kept], np.full((~kept).sum(), height - 0.5 * up)])
    normals = np.tile(up * Z, (len(points), 1))
    face, felt = ranked_face(3, Contacts.of(points, normals), MergeOptions()), SurfaceMap()
    felt.add(points, normals)
    return KnownFace.of(face, face.fit, felt, free, 5.0)


def test_a_hole_comes_out_where_the_face_behind_it_is_missing():
    (end,) = far_ends([RIM], [under(), under(height=-15.0)])
    assert np.allclose(end.center, [5.0, 0.0, 0.0], atol=0.05)
    assert end.axis @ Z < -0.999
    assert end.radius == RIM.radius
    assert not end.measured


def test_it_is_blind_where_that_face_was_touched_or_looks_the_same_way_or_nobody_looked_at_the_rim():
    assert far_ends([RIM], [under((-12.0, 0.0))]) == []
    assert far_ends([RIM], [under(up=1.0)]) == []
    assert far_ends([replace(RIM, measured=False)], [under()]) == []
    full = under((90.0, 0.0))
    assert far_ends([RIM], [replace(full, free=np.array([[5.0, 0.0, 0.5]] * 4))]) == []


def test_its_other_rim_is_worth_a_look_where_nobody_was_and_not_where_the_face_goes_on():
    unknown = replace(under(), free=np.empty((0, 3)))
    assert far_ends([RIM], [unknown]) == []
    (end,) = far_ends([RIM], [unknown], WHERE_TO_LOOK)
    assert np.allclose(end.center, [5.0, 0.0, 0.0], atol=0.05)
    assert far_ends([RIM], [under((-12.0, 0.0))], WHERE_TO_LOOK) == []


def test_a_wide_rim_may_come_out_narrower_where_the_face_behind_was_touched_across_it():
    wide, touched = replace(RIM, radius=9.0), replace(under(), free=np.empty((0, 3)))
    (end,) = narrower_ends([wide], [touched])
    assert np.allclose(end.center, [5.0, 0.0, 0.0], atol=0.05)
    assert end.axis @ Z < -0.999
    assert end.radius == pytest.approx(4.0, abs=0.5)
    assert not end.measured
    assert far_ends([wide], [touched], WHERE_TO_LOOK) == []
    assert narrower_ends([replace(RIM, radius=3.0)], [under((90.0, 0.0))]) == []  # too narrow for a ledge
    assert narrower_ends([RIM], [under()]) == []  # as wide there


def test_a_ring_s_outer_circle_holds_on_the_other_side_only_where_that_face_was_not_felt_past_it():
    unknown = replace(under(), free=np.empty((0, 3)))
    (ring,) = far_ends([replace(RIM, outer=40.0)], [unknown], WHERE_TO_LOOK)
    (flange,) = far_ends([replace(RIM, outer=12.0)], [unknown], WHERE_TO_LOOK)
    assert ring.outer == 40.0
    assert flange.outer == np.inf


def test_a_hole_is_shut_by_the_first_face_touched_across_it():
    across = under((90.0, 0.0))
    assert shut(RIM, [under((90.0, 0.0), height=-15.0), across]) == pytest.approx(10.0)
    assert shut(RIM, [under()]) == np.inf
    assert shut(RIM, [under((90.0, 0.0), up=1.0)]) == np.inf


def test_a_hole_that_an_array_passed_comes_out_narrower_where_the_face_behind_was_felt_all_round():
    wide, touched = replace(RIM, radius=9.0), replace(under(), free=np.empty((0, 3)))
    passed = np.array([[5.0, 0.5, z] for z in (6.0, -6.0)])
    (end,) = narrowed_ends([wide], [touched], passed)
    assert np.allclose(end.center, [5.0, 0.0, 0.0], atol=0.05)
    assert end.radius == pytest.approx(4.0, abs=0.6)
    assert not end.measured
    assert narrowed_ends([wide], [touched], np.empty((0, 3))) == []
    assert narrowed_ends([RIM], [touched], passed) == []


def test_a_pads_overhang_on_one_side_of_a_mouth_narrows_no_hole():
    wide, passed = replace(RIM, radius=9.0), np.array([[5.0, 0.5, -6.0]])
    one_side = under((2.0, 0.0))
    cells = one_side.cells[one_side.cells[:, 0] > 7.0]
    assert narrowed_ends([wide], [replace(one_side, cells=cells)], passed) == []
