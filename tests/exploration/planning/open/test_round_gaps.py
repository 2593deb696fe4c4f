"""Mouths of holes in round faces, of places touched and found free as a skin that spans a rim leaves them."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.planning.inferring.far_ends import far_ends, into_bores, shut
from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.open.holes import holes_of
from exploration.planning.open.known_face import KnownFace
from exploration.planning.open.round_gaps import RoundGapsConfig, round_gaps
from exploration.planning.open.round_rims import aside
from primitives.evidence import NOT_FELT, Contacts
from primitives.patch_graph import MergeOptions, ranked_face

X, Z = np.eye(3)[0], np.eye(3)[2]
AT = np.array([0.0, 0.0, 5.0])
NOWHERE = np.empty((0, 3))
SPANS = RoundGapsConfig().spans


def tube(radius, side=1.0, missing=lambda points: np.zeros(len(points), bool), step=1.9):
    """A round bar's side, or a bore's, along z, touched all round but where it is missing, and free there."""
    turn, height = np.meshgrid(np.arange(0.0, 2.0 * np.pi, step / radius), np.arange(-25.0, 25.0, step))
    normals = side * np.column_stack([np.cos(turn.ravel()), np.sin(turn.ravel()), np.zeros(turn.size)])
    points = side * radius * normals + height.reshape(-1, 1) * Z
    gone = missing(points)
    contacts = Contacts.of(points[~gone], normals[~gone], 0.01)
    face, felt = ranked_face(7, contacts, MergeOptions()), SurfaceMap()
    felt.add(contacts.points, contacts.normals)
    return KnownFace.of(face, face.fit, felt, points[gone] - 0.3 * normals[gone], 5.0)


def drilled(radius, axis=X):
    """Where skin finds a hole across a bar, which it spans for a little at its rim."""
    return lambda points: aside(points, AT, axis) < radius - SPANS


@pytest.mark.parametrize(("radius", "hole"), [(17.0, 5.5), (30.0, 8.0), (12.0, 5.0), (26.0, 4.0)])
def test_a_hole_across_a_bar_has_two_mouths_that_are_its_ends(radius, hole):
    found = round_gaps(tube(radius, missing=drilled(hole)))
    assert sorted(round(float(rim.axis @ X)) for rim in found) == [-1, 1]
    for rim in found:
        assert np.linalg.norm(rim.center - AT - radius * rim.axis) < 1.0
        assert abs(rim.radius - hole) < 0.7
    (through,), left = holes_of(found, NOWHERE)
    assert not left
    assert abs(through.depth - 2.0 * radius) < 0.5
    assert abs(through.radius - hole) < 0.5


def test_a_mouth_that_is_not_round_is_none_nor_is_a_bar_without_one():
    assert round_gaps(tube(17.0)) == []
    keyway = tube(17.0, missing=lambda points: (points[:, 0] > 0.0) & (np.abs(points[:, 1]) < 3.0))
    assert round_gaps(keyway) == []


def test_what_is_missing_at_the_end_of_a_bar_is_no_mouth():
    for high, mouths in ((10.0, 1), (20.5, 0)):
        missing = tube(
            17.0, missing=lambda points, at=high: np.linalg.norm(points - [17.0, 0.0, at], axis=1) < 4.5
        )
        assert len(round_gaps(missing)) == mouths


def test_the_bar_that_a_mouth_is_in_shuts_its_hole_on_the_far_side_if_it_was_touched_there():
    rng = np.random.default_rng(4)
    one = tube(25.0, missing=lambda points: drilled(6.0)(points) & (points[:, 0] > 0.0))
    (rim,) = round_gaps(one)
    for _ in range(20):
        moved = replace(rim, center=rim.center + rng.uniform(-1e-9, 1e-9, 3))
        assert abs(shut(moved, [one]) - 50.0) < 0.5
    both = tube(25.0, missing=drilled(6.0))
    assert [shut(mouth, [both]) for mouth in round_gaps(both)] == [np.inf, np.inf]


def test_a_hole_in_a_tubes_wall_comes_out_in_its_bore_where_that_is_missing():
    one = lambda points: drilled(6.0)(points) & (points[:, 0] > 0.0)  # noqa: E731
    (rim,) = round_gaps(tube(25.0, missing=one))
    bore = tube(15.0, -1.0, one)
    assert round_gaps(bore) == []  # its mouths are seen from outside
    (end,) = far_ends([rim], [bore])
    assert np.linalg.norm(end.center - AT - 15.0 * X) < 1.0
    assert shut(rim, [bore]) == np.inf
    whole = tube(15.0, -1.0)
    assert far_ends([rim], [whole]) == []
    assert abs(shut(rim, [whole]) - 10.0) < 0.5
    assert into_bores([rim], [whole.face]) == []


def test_a_hole_that_leads_into_a_bore_comes_out_there_though_nobody_felt_the_bore():
    (rim,) = round_gaps(tube(25.0, missing=lambda points: drilled(6.0)(points) & (points[:, 0] > 0.0)))
    bore = tube(15.0, -1.0).face
    unfelt = replace(bore, contacts=replace(bore.contacts, touch=np.full(len(bore.contacts), NOT_FELT)))
    (end,) = into_bores([rim], [unfelt])
    assert np.linalg.norm(end.center - AT - 15.0 * X) < 1.0
    (hole,), left = holes_of([rim, end], NOWHERE)
    assert not left
    assert abs(hole.depth - 10.0) < 1.0
    floor = np.column_stack([np.full(5, 22.0), np.linspace(-1.0, 1.0, 5), np.full(5, 5.0)])
    stopped = ranked_face(8, Contacts.of(floor, np.tile(X, (5, 1)), 0.01, touch=2), MergeOptions())
    assert into_bores([rim], [unfelt, stopped]) == []
    elsewhere = [
        replace(rim, center=rim.center + 60.0 * Z),
        replace(rim, center=rim.center + 8.0 * np.eye(3)[1]),
    ]
    assert into_bores(elsewhere, [unfelt]) == []
    assert into_bores([rim], [tube(15.0).face]) == []
