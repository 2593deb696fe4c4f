"""Faces that only their own fine shape tells: rings, wide fillets, and bodies that no exact surface explains."""

from collections import Counter

import numpy as np
import pytest
import trimesh

from models.boundary import boundary
from models.csg import Cylinder, Torus
from models.solid import Solid


def bare(vertices, triangles) -> Solid:
    return Solid.from_mesh(np.asarray(vertices, dtype=np.float32).astype(float), triangles)


@pytest.mark.parametrize(("major", "minor"), [(25, 3), (12, 6)])
def test_a_groove_cut_by_a_ring_is_one_torus(major: float, minor: float) -> None:
    shaft = Cylinder(major, 70) - Torus(major, minor)
    solid = Solid.from_csg(shaft, 0.05)
    kinds = Counter(face.kind for face in boundary(bare(solid.vertices, solid.triangles)).faces)
    assert kinds == {"cylinder": 2, "plane": 2, "torus": 1}


@pytest.mark.parametrize("wide", [3.0, 6.0, 9.0])
def test_a_fillet_wider_than_half_its_rod_is_a_torus(wide: float) -> None:
    turn = np.linspace(0, np.pi / 2, 25)
    arc = np.column_stack([10 - wide + wide * np.cos(turn), 40 - wide + wide * np.sin(turn)])
    rod = trimesh.creation.revolve([(0, 0), (10, 0), *arc, (0, 40)], sections=90)
    faces = boundary(bare(rod.vertices, rod.faces)).faces
    assert Counter(face.kind for face in faces) == {"cylinder": 1, "plane": 2, "torus": 1}
    (fillet,) = [face.shape for face in faces if face.kind == "torus"]
    assert fillet.sizes == pytest.approx((10 - wide, wide), abs=1e-3)


def test_a_rod_with_a_round_end_ends_in_a_sphere() -> None:
    capsule = trimesh.creation.capsule(height=30, radius=10, count=(48, 48))
    kinds = Counter(face.kind for face in boundary(bare(capsule.vertices, capsule.faces)).faces)
    assert kinds == {"cylinder": 1, "sphere": 2}


@pytest.mark.long
def test_a_smooth_body_of_no_exact_shape_is_one_freeform_face() -> None:
    ball = trimesh.creation.icosphere(4)
    x, y, z = ball.vertices.T
    swell = 30 * (1 + 0.15 * np.sin(3 * x + 1) * np.cos(2 * y) + 0.1 * np.sin(5 * z))
    faces = boundary(bare(ball.vertices * swell[:, None], ball.faces)).faces
    assert [face.kind for face in faces] == ["freeform"]


@pytest.mark.parametrize("rings", [16, 96])
def test_a_ring_is_a_torus_however_fine_its_facets_are(rings: int) -> None:
    ring = trimesh.creation.torus(30.0, 8.0, major_sections=3 * rings, minor_sections=rings)
    faces = boundary(bare(ring.vertices, ring.faces)).faces
    assert [face.kind for face in faces] == ["torus"]
    assert faces[0].shape.sizes == pytest.approx((30.0, 8.0), abs=1e-3)


@pytest.mark.parametrize("finer", [3, 5])
def test_a_ball_is_a_sphere_however_fine_its_facets_are(finer: int) -> None:
    ball = trimesh.creation.icosphere(finer, 30.0)
    faces = boundary(bare(ball.vertices, ball.faces)).faces
    assert [face.kind for face in faces] == ["sphere"]
