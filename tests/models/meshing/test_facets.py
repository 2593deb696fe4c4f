from math import pi, sqrt

import numpy as np
import pytest

from models.boundary import boundary
from models.csg import Cone, Cube, Cylinder, Polyhedron, Primitive, Prism, Sphere, Torus
from models.meshing.facets import facets
from models.solid import Solid

L_SHAPE = ((0.0, 0.0), (30.0, 0.0), (30.0, 8.0), (8.0, 8.0), (8.0, 20.0), (0.0, 20.0))
TETRAHEDRON = Polyhedron(
    ((1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)), ((0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2))
)
ALL: list[tuple[Primitive, float]] = [
    (Cube((10, 20, 30)), 6000),
    (Cylinder(10, 30), 3000 * pi),
    (Cone(10, 4, 30), 10 * pi * (100 + 40 + 16)),
    (Sphere(15), 4500 * pi),
    (Torus(20, 6), 2 * pi**2 * 20 * 36),
    (Torus(10, 9.5), 2 * pi**2 * 10 * 9.5**2),
    (Torus(10, 9.9999), 2 * pi**2 * 10 * 9.9999**2),
    (Prism(L_SHAPE, 5), 5 * (30 * 8 + 8 * 12)),
    (TETRAHEDRON, 8 / 3),
]


@pytest.mark.parametrize(("primitive", "volume"), ALL)
def test_volumes_are_those_of_the_exact_solids(primitive: Primitive, volume: float) -> None:
    assert Solid.from_csg(primitive, tolerance=0.05).volume == pytest.approx(volume, rel=1e-9)


@pytest.mark.parametrize("tolerance", [0.002, 0.02, 0.2])
@pytest.mark.parametrize("primitive", [p for p, _ in ALL])
def test_no_facet_departs_from_its_surface_by_more_than_the_tolerance(
    primitive: Primitive, tolerance: float
) -> None:
    made = facets(primitive, tolerance)
    corners = made.vertices[made.triangles]
    shares = np.random.default_rng(0).dirichlet([1, 1, 1], 4)
    for weights in (*shares, [1, 0, 0], [0.5, 0.5, 0], [0, 0.5, 0.5], [0.5, 0, 0.5]):
        points = np.einsum("k,tkx->tx", weights, corners)
        assert np.abs(primitive.signed_distance(points)).max() <= tolerance * (1 + 1e-9)


@pytest.mark.parametrize("radius", [0.5, 4.2, 35.0, 60.0, 137.0])
def test_corners_of_a_circle_are_within_the_tolerance_of_it_and_no_finer_than_they_need(
    radius: float,
) -> None:
    for tolerance in (0.002, 0.05):
        made = facets(Cylinder(radius, 10), tolerance)
        bulge = np.linalg.norm(made.vertices[:, :2], axis=1).max() - radius
        assert 0 < bulge <= tolerance
        assert len(made.vertices) == 64 or bulge > 0.5 * tolerance


def test_through_its_corners_a_coarse_cone_opens_wider_by_a_tenth_of_a_degree_at_most() -> None:
    made = facets(Cone(1, 0.2, 0.8), 0.05)
    radii, heights = np.linalg.norm(made.vertices[:, :2], axis=1), made.vertices[:, 2]
    opened = np.arctan(np.ptp(radii) / np.ptp(heights))
    assert opened == pytest.approx(pi / 4, abs=np.deg2rad(0.1))


@pytest.mark.parametrize("primitive", [p for p, _ in ALL])
def test_every_triangle_faces_as_its_surface_does(primitive: Primitive) -> None:
    made = facets(primitive, 0.02)
    a, b, c = np.moveaxis(made.vertices[made.triangles], 1, 0)
    facing = np.cross(b - a, c - a)
    for i, surface in enumerate(made.surfaces):
        mine = made.surface == i
        assert (np.einsum("ij,ij->i", facing[mine], surface.normals(((a + b + c) / 3)[mine])) > 0).all()


def test_a_polyhedron_given_inside_out_is_the_same_solid() -> None:
    turned = Polyhedron(TETRAHEDRON.points, tuple(face[::-1] for face in TETRAHEDRON.faces))
    assert turned == TETRAHEDRON


def test_a_polyhedron_drops_points_that_no_face_uses() -> None:
    more = Polyhedron(
        ((50, 50, 50), *TETRAHEDRON.points), tuple(tuple(i + 1 for i in f) for f in TETRAHEDRON.faces)
    )
    assert more == TETRAHEDRON


def test_a_polyhedron_has_one_face_where_its_polygons_lie_on_one_plane() -> None:
    corners = tuple((x, y, z) for x in (0.0, 4.0) for y in (0.0, 5.0) for z in (0.0, 6.0))
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    triangles = tuple(t for a, b, c, d in quads for t in ((a, b, c), (a, c, d)))
    brep = boundary(Solid.from_csg(Polyhedron(corners, triangles)))
    assert (len(brep.faces), len(brep.edges), len(brep.vertices)) == (6, 12, 8)


def test_a_prism_of_six_sides_has_the_edges_that_a_hexagon_has() -> None:
    brep = boundary(
        Solid.from_csg(Prism(tuple((10 * np.cos(k * pi / 3), 10 * np.sin(k * pi / 3)) for k in range(6)), 8))
    )
    assert (len(brep.faces), len(brep.edges), len(brep.vertices), brep.check()) == (8, 18, 12, ())
    assert sorted(round(edge.dihedral_deg) for edge in brep.edges) == [90] * 12 + [120] * 6


def test_an_inside_corner_of_a_prism_is_concave() -> None:
    edges = boundary(Solid.from_csg(Prism(L_SHAPE, 5))).edges
    assert [edge.length for edge in edges if edge.kind == "concave"] == [5]


def test_the_boundary_of_a_whole_torus_is_one_face_with_a_handle() -> None:
    brep = boundary(Solid.from_csg(Torus(20, 6)))
    assert [(face.kind, face.handles, face.loops) for face in brep.faces] == [("torus", 1, ())]
    assert (brep.genus, brep.check()) == (1, ())
    assert brep.faces[0].area == pytest.approx(4 * pi**2 * 120, rel=1e-3)


@pytest.mark.parametrize("minor", [0.5, 6.0, 19.9, 19.999999])
def test_the_corners_of_a_torus_lie_on_one_torus_and_clear_of_its_axis(minor: float) -> None:
    corners = facets(Torus(20, minor), 0.05).vertices
    rho = np.hypot(corners[:, 0], corners[:, 1])
    across = np.hypot(rho - (rho.min() + rho.max()) / 2, corners[:, 2])
    assert rho.min() > 0
    assert np.ptp(across) < 1e-9


def test_a_groove_cut_by_a_torus_is_a_concave_face_between_two_rims() -> None:
    groove = next(
        f for f in boundary(Solid.from_csg(Cylinder(30, 20) - Torus(30, 5))).faces if f.kind == "torus"
    )
    assert (groove.convex, groove.handles, len(groove.loops)) == (False, 0, 2)


def test_half_a_torus_has_two_round_ends_and_no_handle() -> None:
    brep = boundary(Solid.from_csg(Torus(20, 6) & Cube((99, 99, 99)).at(49.5, 0, 0)))
    assert sorted(face.kind for face in brep.faces) == ["plane", "plane", "torus"]
    assert [face.handles for face in brep.faces] == [0, 0, 0]
    assert [edge.length for edge in brep.edges] == pytest.approx([12 * pi, 12 * pi], rel=1e-4)
    assert brep.check() == ()


def test_distance_of_a_tetrahedron_is_that_of_its_planes_inside() -> None:
    assert TETRAHEDRON.signed_distance(np.zeros((1, 3))) == pytest.approx([-1 / sqrt(3)])
