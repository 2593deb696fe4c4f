import numpy as np

from models.csg import Cube, Torus
from models.solid import Solid
from primitives import pose as se3
from recognition.report.drawn import drawn
from recognition.report.payload import PayloadLimits

POSE = se3.pose(se3.frame_along(np.array([1.0, 2.0, 2.0]), np.array([1.0, 0.0, 0.0])), [20.0, -5.0, 8.0])


def test_what_a_page_can_hold_is_drawn_as_it_is():
    solid = Solid.from_csg(Cube((10.0, 20.0, 30.0))).placed(POSE)
    face = np.arange(len(solid.triangles))
    mesh = drawn(solid, face)
    assert np.allclose(mesh.vertices, solid.vertices)
    assert np.array_equal(mesh.triangles, solid.triangles)
    assert np.array_equal(mesh.face, face)


def test_what_it_cannot_hold_is_drawn_coarser_on_the_same_surface():
    solid = Solid.from_csg(Torus(35.0, 7.0), 0.001).placed(POSE)
    limit = PayloadLimits().triangles
    assert len(solid.triangles) > limit
    mesh = drawn(solid, np.full(len(solid.triangles), 3))
    assert 1000 < len(mesh.triangles) <= limit
    assert np.abs(solid.signed_distance(mesh.vertices[mesh.triangles].mean(axis=1))).max() < 0.1
    assert np.array_equal(mesh.face, np.full(len(mesh.triangles), 3))
