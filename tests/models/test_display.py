import numpy as np

from models import parts
from models.boundary import labeled_boundary
from models.display import display_mesh
from models.rays.triangle_tree import TriangleTree
from models.solid import Solid


def test_a_light_mesh_is_drawn_as_it_is() -> None:
    solid = Solid.from_csg(parts.build("bracket"))
    _, face = labeled_boundary(solid)
    vertices, triangles, of_face = display_mesh(solid, face)
    assert triangles is solid.body.triangles
    assert of_face is face
    assert vertices is solid.body.vertices


def test_a_heavy_mesh_becomes_light_and_keeps_its_faces_and_its_surface() -> None:
    solid = Solid.from_csg(parts.build("grommet"))
    brep, face = labeled_boundary(solid)
    vertices, triangles, of_face = display_mesh(solid, face, most=6000)
    assert len(triangles) <= 6000
    assert np.abs(solid.signed_distance(vertices)).max() < 1e-4
    away = TriangleTree(vertices, triangles).nearest(solid.body.vertices).distance
    assert away.max() < 0.3
    a, b, c = np.moveaxis(vertices[triangles], 1, 0)
    areas = np.bincount(of_face, np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2, len(brep.faces))
    np.testing.assert_allclose(areas, [f.area for f in brep.faces], rtol=0.015)
