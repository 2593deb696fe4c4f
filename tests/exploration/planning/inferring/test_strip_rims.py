"""Rims of faces too narrow to roll over, from where contact with them ended under a pad."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.control.sighting import Sighting
from exploration.planning.inferring.strip_rims import strip_rims
from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.open.known_face import KnownFace
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, ranked_face

X, Y, Z = np.eye(3)
TURN = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
OUT = np.column_stack([np.cos(TURN), np.sin(TURN), np.zeros(12)])
END = Sighting(4.0 * X + 30.0 * Z, Y, Z, X, 0.1, 6.0)  # where the side of a rod ends, seen from +x


def rod(top):
    """Of radius 4 about z, felt up to a height."""
    points = np.concatenate([4.0 * OUT + z * Z for z in np.arange(0.0, top, 1.0)])
    normals = np.tile(OUT, (len(points) // len(OUT), 1))
    face, felt = ranked_face(7, Contacts.of(points, normals, 0.02, 0.02), MergeOptions()), SurfaceMap()
    felt.add(points, normals)
    return KnownFace.of(face, face.fit, felt, np.empty((0, 3)), 5.0)


def test_where_contact_ended_is_a_rim_of_the_face_that_was_felt():
    assert strip_rims([END], [rod(30.0)]) == [(END, 7)]


@pytest.mark.parametrize(
    "end",
    [replace(END, point=END.point + 1.5 * X), replace(END, normal=-X), replace(END, normal=Z)],
    ids=["beside it", "looking in", "across it"],
)
def test_what_ended_elsewhere_is_no_rim_of_it(end):
    assert strip_rims([end], [rod(30.0)]) == []


def test_a_face_that_was_felt_farther_out_does_not_end_there():
    assert strip_rims([END], [rod(40.0)]) == []
