"""Rounded corners of plates, from where both sides were felt last between two walls."""

import numpy as np
import pytest

from exploration.planning.inferring.rounded_corners import rounded_corners
from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.open.known_face import KnownFace
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from primitives.patch_graph import MergeOptions, ranked_face
from primitives.shapes import Plane

THICK, STEP = 6.0, 0.9  # [mm], of places that strokes have felt again and again
UP = np.array([0.0, 0.0, 1.0])


def flat(points, normal, number):
    """A face and all that is known of it."""
    normals = np.tile(normal, (len(points), 1))
    face, felt = ranked_face(number, Contacts.of(points, normals, 0.01), MergeOptions()), SurfaceMap()
    felt.add(points, normals)
    return KnownFace.of(face, face.fit, felt, np.empty((0, 3)), 5.0)


def plate(radius, turn, rng, felt=lambda xy: np.ones(len(xy), bool)):
    """A large plate's corner, its walls along two lines that meet at the origin, rounded or sharp.

    Its sides were felt where `felt` says, a taxel's place here and there missing; the walls up to the rounding.
    """
    ways = [np.array([np.sin(0.5 * turn * s), np.cos(0.5 * turn)]) for s in (-1.0, 1.0)]
    inset = radius / np.cos(0.5 * turn)
    x, y = np.meshgrid(np.arange(-70.0, 70.0, STEP), np.arange(-60.0, 5.0, STEP))
    xy = np.column_stack([x.ravel(), y.ravel()]) + rng.uniform(-0.5, 0.5, (x.size, 2))
    inside = np.max([xy @ way for way in ways], axis=0) < 0.0
    away = xy + np.array([0.0, inset])
    wedge = np.arctan2(np.abs(away[:, 0]), away[:, 1]) < 0.5 * turn
    inside &= ~wedge | (np.linalg.norm(away, axis=1) < radius)
    xy = xy[inside & felt(xy)]
    top, bottom = (np.column_stack([xy, np.full(len(xy), z)]) for z in (0.5 * THICK, -0.5 * THICK))
    walls = []
    for number, way in enumerate(ways):
        along = np.array([-way[1], way[0]]) * (1.0 if way[0] < 0.0 else -1.0)
        t = np.arange(radius * np.tan(0.5 * turn) + 2.0, 45.0, 2.5)
        at = -t[:, None] * along * np.sign(along[1])
        points = np.concatenate([np.column_stack([at, np.full(len(at), z)]) for z in (-1.5, 0.0, 1.5)])
        walls.append(flat(points, np.array([*way, 0.0]), 2 + number))
    return [flat(top, UP, 0), flat(bottom, -UP, 1), *walls]


@pytest.mark.parametrize("turn", [np.pi / 2, 2.1])
@pytest.mark.parametrize("radius", [11.0, 16.0])
def test_a_rounding_is_found_as_wide_as_it_is(radius, turn):
    known = plate(radius, turn, np.random.default_rng(1))
    ((lot, flat),) = rounded_corners(known, [own.face for own in known])
    assert not flat
    assert (lot.touch == NOT_FELT).all()
    found = fit("cylinder", lot)
    assert found
    assert found.convex
    assert abs(found.shape.radius - radius) < 0.15 * radius
    middle = found.shape.anchor - [0.0, 0.0, found.shape.anchor[2]]
    assert np.linalg.norm(middle - [0.0, -radius / np.cos(0.5 * turn), 0.0]) < 0.2 * radius


def test_a_sharp_corner_has_none_nor_has_one_that_nobody_felt_to_its_end():
    rng = np.random.default_rng(2)
    sharp = plate(0.0, np.pi / 2, rng)
    assert rounded_corners(sharp, [own.face for own in sharp]) == []
    unfelt = plate(0.0, np.pi / 2, rng, lambda xy: (xy[:, 1] < -25.0) | (np.abs(xy[:, 0]) > 12.0))
    assert rounded_corners(unfelt, [own.face for own in unfelt]) == []


def test_a_corner_that_a_round_face_is_known_of_is_left_to_it():
    known = plate(14.0, np.pi / 2, np.random.default_rng(3))
    ((lot, _),) = rounded_corners(known, [own.face for own in known])
    felt = ranked_face(9, Contacts.of(lot.points, lot.normals, 0.05), MergeOptions())
    assert not isinstance(felt.fit.shape, Plane)
    assert rounded_corners(known, [*(own.face for own in known), felt]) == []


def test_a_few_contacts_of_it_that_passed_for_a_flat_face_are_the_corners():
    known = plate(14.0, np.pi / 2, np.random.default_rng(3))
    faces = [own.face for own in known]
    angle = np.repeat([-0.1, 0.0, 0.1], 2)
    ways = np.column_stack([np.sin(angle), np.cos(angle), np.zeros(6)])
    points = [0.0, -14.0 * np.sqrt(2.0), 0.0] + 14.0 * ways + np.outer(np.tile([-1.5, 1.5], 3), UP)
    passed = ranked_face(
        9, Contacts.of(points, np.tile([0.0, 1.0, 0.0], (6, 1)), 0.02, touch=3), MergeOptions()
    )
    assert isinstance(passed.fit.shape, Plane)
    ((lot, flat),) = rounded_corners(known, [*faces, passed])
    assert flat == [9]
    assert int((lot.touch == 3).sum()) == 6


def test_a_short_wall_beside_a_corner_is_no_part_of_it():
    known = plate(20.0, np.pi / 2, np.random.default_rng(1))
    short = known[2].face
    near = np.argsort(np.linalg.norm(short.contacts.points, axis=1))[:9]
    cut = ranked_face(2, short.contacts.select(near), MergeOptions())
    ((_, flat),) = rounded_corners(known, [known[0].face, known[1].face, cut, known[3].face])
    assert flat == []
