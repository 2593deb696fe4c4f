import numpy as np
import pytest

from recognition.report.felt import felt_faces

TOP = {"id": 3, "shape": "plane", "parameters": {"origin_mm": [0, 0, 5], "axis": [0, 0, 1]}}
SIDE = {"id": 4, "shape": "cylinder", "parameters": {}}


def test_a_flat_face_is_drawn_as_far_as_contacts_reach_in_its_plane_and_facing_out():
    square = np.array([[0, 0, 5.1], [10, 0, 4.9], [10, 8, 5], [0, 8, 5], [5, 4, 5]], dtype=float)
    mesh = felt_faces([TOP, SIDE], np.concatenate([square, square + 50]), np.array([3] * 5 + [4] * 5))
    a, b, c = np.moveaxis(mesh.vertices[mesh.triangles], 1, 0)
    assert np.cross(b - a, c - a).sum(axis=0) / 2 == pytest.approx([0, 0, 80])
    assert mesh.vertices[:, 2] == pytest.approx(5)
    assert set(mesh.face.tolist()) == {3}


@pytest.mark.parametrize("points", [np.empty((0, 3)), np.outer(np.arange(4.0), [1, 1, 0])])
def test_contacts_that_span_no_area_draw_nothing(points):
    assert felt_faces([TOP], points, np.full(len(points), 3)) is None
