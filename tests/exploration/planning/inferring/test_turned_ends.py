"""Flat ends of cylinders, from where they were felt last."""

import numpy as np
import pytest

from exploration.planning.inferring.turned_ends import felt_ends
from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.open.known_face import KnownFace
from primitives.evidence import NOT_FELT, Contacts
from primitives.patch_graph import MergeOptions, ranked_face

Z = np.eye(3)[2]
TURN = np.linspace(0.0, 2.0 * np.pi, 72, endpoint=False)
RING = np.column_stack([np.cos(TURN), np.sin(TURN), np.zeros(72)])


def barrel(top, heights=(1.4, 3.4, 5.4)):
    """Of radius 23, felt up to a height and found missing above `top`, each at every turn."""
    points = np.concatenate([23.0 * RING + z * Z for z in heights])
    normals = np.tile(RING, (len(heights), 1))
    face, felt = ranked_face(0, Contacts.of(points, normals, 0.02, 0.02), MergeOptions()), SurfaceMap()
    assert face.fit.kind == "cylinder"
    felt.add(points, normals)
    free = 22.6 * RING + top[:, None] * Z
    return KnownFace.of(face, face.fit, felt, free, 5.0)


def test_a_flange_ends_half_way_between_where_it_was_felt_and_where_it_was_missing():
    own = barrel(np.full(72, 7.0))
    (end,) = felt_ends([own], [own.rim])
    assert end.points[:, 2] == pytest.approx(6.2, abs=0.2)
    assert (end.normals @ Z > 0.99).all()
    assert (end.touch == NOT_FELT).all()
    assert np.hypot(*end.points[:, :2].T).max() < 23.0


def test_an_end_that_slants_or_was_found_at_one_side_or_felt_beyond_is_none():
    slant = barrel(6.9 + 1.5 * np.cos(TURN), heights=(1.4, 3.4, 5.4))
    assert felt_ends([slant], [tuple(part[slant.rim[0][:, 0] > 15.0] for part in slant.rim)]) == []
    beyond = barrel(np.full(72, 7.0), heights=(1.4, 3.4, 5.4, 11.4, 13.4, 15.4))
    at, out = beyond.rim
    low = at[:, 2] < 7.0
    assert felt_ends([beyond], [(at[low], out[low])]) == []
    nowhere = np.empty((0, 3))
    assert felt_ends([beyond], [(nowhere, nowhere)]) == []
