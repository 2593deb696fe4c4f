"""A model's distance from the truth, and the order in which contacts come."""

import numpy as np
import pytest

from models.csg import Cube
from models.solid import Solid
from recognition.report.deviation import DeviationConfig, deviation, refined
from recognition.report.growth import felt_from
from recognition.report.run_report import ReportMesh


def drawn(solid):
    return ReportMesh(solid.vertices, solid.triangles, np.arange(len(solid.triangles)))


def area(mesh, face=None):
    chosen = mesh.triangles if face is None else mesh.triangles[mesh.face == face]
    a, b, c = (mesh.vertices[chosen[:, k]] for k in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2


@pytest.fixture(scope="module")
def plate():
    return Solid.from_csg(Cube((80.0, 40.0, 10.0)))


def test_a_pocket_that_the_model_lacks_shows_in_the_middle_of_its_face(plate):
    pocket = Solid.from_csg(Cube((80.0, 40.0, 10.0)) - Cube((20.0, 20.0, 8.0)).at(0.0, 0.0, 4.0))
    off = deviation(drawn(plate), pocket)
    above = np.abs(off.mesh.vertices - [0, 0, 5]).max(axis=1) < 3
    assert above.any()
    assert off.distance[above].min() > 3
    assert np.abs(off.distance[off.mesh.vertices[:, 0] > 39]).max() < 1e-9
    assert off.scale >= 5


@pytest.mark.parametrize("by", [-0.3, 0.3])
def test_the_sign_says_which_way(plate, by):
    grown = Solid.from_csg(Cube((80.0 + 2 * by, 40.0 + 2 * by, 10.0 + 2 * by)))
    off = deviation(drawn(grown), plate)
    assert (np.sign(off.distance) == np.sign(by)).all()


def test_halving_keeps_every_face_and_its_area(plate):
    mesh, fine = drawn(plate), refined(drawn(plate), DeviationConfig())
    assert len(fine.triangles) > 100 * len(mesh.triangles)
    for face in mesh.face:
        assert area(fine, face) == pytest.approx(area(mesh, face))
    assert len(refined(mesh, DeviationConfig(triangles=500)).triangles) <= 500


def test_a_contact_comes_with_the_first_pad_on_it():
    poses = np.tile(np.eye(4), (4, 1, 1))
    poses[:, 0, 3] = [0.0, 0.0, 30.0, 0.0]
    points = np.array([[0.0, 0, 0], [30, 0, 0], [29, 4, 0.5], [60, 0, 0]])
    assert felt_from(points, poses, np.arange(4) > 0, (20.0, 10.0)).tolist() == [1, 2, 2, 2]
