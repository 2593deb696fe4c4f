"""What touch says of a cell: what was felt there, before what was only inferred."""

import numpy as np
import pytest

from primitives.shapes import Plane
from recognition.assembly.arrangement import arrange

TOP, WALL = Plane([0.0, 0.0, 0.0], [0.0, 0.0, 1.0]), Plane([0.0, 0.0, 0.0], [1.0, 0.0, 0.0])
ROOM = np.array([[-20.0, -20.0, -20.0], [20.0, 20.0, 20.0]])
HEARD = 40


def votes_under_the_top(felt):
    """For solid and for free, where `felt` contacts of the top lie before a wall that is inferred to end it."""
    spread = np.linspace(-10.0, 10.0, HEARD)
    top = np.column_stack([np.full(felt, 8.0), spread[:felt], np.zeros(felt)])
    wall = np.column_stack([np.zeros(HEARD), spread, np.full(HEARD, -5.0)])
    points = np.concatenate([top, wall])
    normals = np.concatenate([np.tile(TOP.normal, (felt, 1)), np.tile(WALL.normal, (HEARD, 1))])
    heard = np.arange(len(points)) >= felt
    inferred = np.array([False, True])
    found = arrange([TOP, WALL], points, normals, np.empty((0, 3)), ROOM, inferred=inferred, heard=heard)
    cell = np.flatnonzero((found.outside == [False, True]).all(axis=1))[0]
    return found.solid_votes[cell], found.free_votes[cell]


@pytest.mark.parametrize("felt", [3, 10])
def test_what_was_felt_is_not_outvoted_by_what_was_inferred(felt):
    assert votes_under_the_top(felt) == (felt, 2.0)


@pytest.mark.parametrize("felt", [0, 2])
def test_a_stray_contact_or_two_do_not_outvote_it(felt):
    assert votes_under_the_top(felt) == (felt, HEARD)


def test_contacts_of_a_surface_are_counted_by_the_side_that_they_look_to():
    """Ten on the top of a slab look out of it; of six on its wall four look in, and two along it."""
    top = np.column_stack([np.linspace(1.0, 8.0, 10), np.full(10, 5.0), np.full(10, float(TOP.origin[2]))])
    wall = np.column_stack([np.full(6, float(WALL.origin[0])), np.linspace(1.0, 8.0, 6), np.full(6, 1.0)])
    looks = [np.tile(TOP.normal, (10, 1)), np.tile(-WALL.normal, (4, 1)), np.tile(TOP.normal, (2, 1))]
    points, normals = np.concatenate([top, wall]), np.concatenate(looks)
    found = arrange([TOP, WALL], points, normals, np.empty((0, 3)), ROOM)
    assert found.facing.tolist() == [[10.0, 0.0], [0.0, 4.0]]


@pytest.mark.parametrize(("lies", "share"), [(True, 0.6 + 0.1 * 0.4), (False, 1.0)])
def test_no_contact_is_expected_nearer_to_a_face_that_nobody_felt_than_any_came(lies, share):
    """Of a wall 10 mm high over a table, whose lower 4 mm no array came to; unless the lower face was felt."""
    low = Plane([0.0, 0.0, -10.0], [0.0, 0.0, -1.0])
    y, z = np.meshgrid(np.linspace(-18.0, 18.0, 8), np.linspace(-6.0, 0.0, 5))
    points = np.column_stack([np.zeros(y.size), y.ravel(), z.ravel()])
    inferred = np.array([False, False, lies])
    nowhere, normals = np.empty((0, 3)), np.tile(WALL.normal, (len(points), 1))
    found = arrange([TOP, WALL, low], points, normals, nowhere, ROOM, inferred=inferred)
    under = ~found.outside[:, [0, 2]].any(axis=1)
    own = under[found.pairs].all(axis=1)
    assert own.sum() == 1
    assert found.area[own][0] == pytest.approx(share * 400.0, rel=0.05)
