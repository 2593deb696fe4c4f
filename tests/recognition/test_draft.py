"""A draft is the surface of what the faces so far make."""

import numpy as np

from exploration.planning.moves.drafted import SPACING
from exploration.planning.touching.findings import Findings
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, PatchGraph, ranked_face
from recognition.draft import draft

BOX = np.array([[-100.0] * 3, [100.0] * 3])
HALF = np.array([30.0, 20.0, 10.0])


def sides(count):
    """Faces of a block, so many of its six."""
    faces = []
    for number in range(count):
        axis, sign = divmod(number, 2)[0], 1.0 - 2.0 * (number % 2)
        u, v = (k for k in range(3) if k != axis)
        a, b = np.meshgrid(*(np.linspace(-0.8, 0.8, 6) * HALF[k] for k in (u, v)))
        points = np.zeros((36, 3))
        points[:, axis], points[:, u], points[:, v] = sign * HALF[axis], a.ravel(), b.ravel()
        normals = np.tile(sign * np.eye(3)[axis], (36, 1))
        contacts = Contacts.of(points, normals, sigma=0.01, normal_sigma=0.005, touch=number)
        faces.append(ranked_face(number, contacts, MergeOptions()))
    return Findings(graph=PatchGraph(tuple(faces)))


def test_the_places_lie_on_the_body_and_are_as_many_as_its_surface_asks_for():
    found = draft(sides(6), BOX)
    away = np.abs(np.abs(found.points) - HALF).min(axis=1)
    assert away.max() < 0.01
    assert (np.einsum("ij,ij->i", found.points, found.normals) > 0.0).all()
    area = 8.0 * (HALF[0] * HALF[1] + HALF[1] * HALF[2] + HALF[0] * HALF[2])
    assert abs(len(found.points) - area / SPACING**2) < 0.05 * area / SPACING**2


def test_faces_that_make_no_body_have_no_surface():
    assert len(draft(Findings(), BOX).points) == 0
