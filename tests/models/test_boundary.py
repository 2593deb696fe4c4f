from collections import Counter
from math import pi

import networkx as nx
import numpy as np
import pytest

from models import parts
from models.boundaries.extents import anchored, rectangle
from models.boundary import boundary
from models.brep import Brep, Edge
from models.csg import Cone, Csg, Cube, Cylinder, Sphere
from models.formats import openscad
from models.solid import Solid
from primitives.shapes import Plane


def _brep(tree: Csg) -> Brep:
    return boundary(Solid.from_csg(tree))


@pytest.mark.parametrize("name", parts.names())
def test_the_boundary_of_every_part_is_sound(name: str) -> None:
    solid = Solid.from_csg(parts.build(name), tolerance=0.02)
    brep = boundary(solid)
    assert brep.check() == ()
    assert brep.genus == solid.genus
    assert sum(face.area for face in brep.faces) == pytest.approx(solid.area, rel=1e-9)


@pytest.mark.parametrize(
    ("name", "counts"),
    [
        ("block", (6, 12, 8)),
        ("cylinder", (3, 2, 0)),
        ("cone", (2, 1, 0)),
        ("sphere", (1, 0, 0)),
        ("d_shaft", (4, 6, 4)),
        ("lens", (2, 1, 0)),
        ("dice", (7, 6, 0)),
        ("stepped_block", (8, 18, 12)),
        ("plate_with_hole", (7, 14, 8)),
        ("pipe", (4, 4, 0)),
    ],
)
def test_faces_edges_and_vertices_are_counted_as_a_person_would(
    name: str, counts: tuple[int, int, int]
) -> None:
    brep = _brep(parts.build(name))
    assert (len(brep.faces), len(brep.edges), len(brep.vertices)) == counts


def test_cylinder_has_exact_extents_area_and_rims() -> None:
    side, *ends = _brep(Cylinder(15, 40).at(3, 2, 1)).faces
    assert side.extent == pytest.approx((40, 30 * pi), abs=1e-3)
    assert side.area == pytest.approx(30 * pi * 40, rel=1e-4)
    np.testing.assert_allclose(side.as_json()["parameters"]["origin_mm"], [3, 2, 1], atol=1e-9)
    for end in ends:
        assert end.extent == pytest.approx((30, 30), abs=1e-3)
    for edge in _brep(Cylinder(15, 40)).edges:
        assert (edge.kind, edge.curve) == ("convex", "circle")
        assert edge.length == pytest.approx(30 * pi, abs=1e-4)
        assert edge.dihedral_deg == pytest.approx(90, abs=1e-6)


def test_frustum_and_cone_extents_count_from_the_apex() -> None:
    assert _brep(Cone(20, 10, 30)).faces[0].extent == pytest.approx((30, 60), abs=1e-6)
    assert _brep(Cone(20, 0, 30)).faces[0].extent == pytest.approx((0, 30), abs=1e-6)


def test_sphere_extents_are_rim_and_height() -> None:
    assert _brep(Sphere(20)).faces[0].extent == pytest.approx((0, 40))
    cap = next(f for f in _brep(Sphere(25) & Cube((80, 80, 80)).at(0, 0, 55)).faces if f.kind == "sphere")
    assert cap.extent == pytest.approx((40, 10), abs=1e-3)


def test_an_arc_of_a_cylinder_has_the_arc_as_extent() -> None:
    side = _brep(Cylinder(20, 30) & Cube((20, 99, 99)).at(20, 0, 0)).faces[0]
    assert side.extent == pytest.approx((30, 20 * 2 * pi / 3), abs=1e-3)


def test_inside_corners_are_concave_and_hold_270_degrees() -> None:
    edges = _brep(parts.build("stepped_block")).edges
    concave = [edge for edge in edges if edge.kind == "concave"]
    assert [edge.dihedral_deg for edge in concave] == pytest.approx([270])
    assert all(edge.dihedral_deg == pytest.approx(90) for edge in edges if edge.kind == "convex")


def test_a_hole_is_concave_and_its_rims_are_convex() -> None:
    brep = _brep(parts.build("plate_with_hole"))
    hole = next(face for face in brep.faces if face.kind == "cylinder")
    assert not hole.convex
    assert all(edge.kind == "convex" for edge in brep.edges if hole.id in edge.faces)


def test_a_dome_that_is_tangent_to_its_cylinder_joins_smoothly() -> None:
    brep = _brep(Cylinder(15, 30).at(0, 0, -15) | Sphere(15))
    edge = next(e for e in brep.edges if {brep.faces[f].kind for f in e.faces} == {"cylinder", "sphere"})
    assert edge.kind == "smooth"
    assert edge.dihedral_deg == pytest.approx(180, abs=1)
    assert brep.check() == ()


def test_flush_cubes_share_their_faces() -> None:
    brep = _brep(Cube((10, 10, 10)) | Cube((10, 10, 10)).at(10, 0, 0))
    assert len(brep.faces) == 6
    assert sorted(face.extent for face in brep.faces)[-1] == pytest.approx((20, 10))


def test_edges_lie_on_both_their_surfaces() -> None:
    brep = _brep(parts.build("cross_pipe"))
    for edge in brep.edges:
        for face in edge.faces:
            shape = brep.faces[face].shape
            assert shape is not None
            assert np.abs(shape.signed_distance(edge.points)).max() < 1e-6


def test_a_cavity_is_a_second_shell() -> None:
    brep = _brep(Cube((40, 40, 40)) - Sphere(10))
    assert (brep.shells, brep.genus, brep.check()) == (2, 0, ())


def test_graphs_tell_parts_apart_and_poses_not() -> None:
    def same(a: nx.Graph, b: nx.Graph) -> bool:
        return nx.is_isomorphic(a, b, node_match=lambda p, q: p["shape"] == q["shape"])

    block = _brep(Cube((60, 40, 12))).graph()
    assert same(block, _brep(Cube((60, 40, 12)).turned((1, 2, 3), 0.7).at(4, 5, 6)).graph())
    assert not same(block, _brep(parts.build("stepped_block")).graph())


def test_check_names_what_is_wrong() -> None:
    brep = _brep(Cube((10, 10, 10)))
    assert "Euler" in Brep(brep.faces, brep.edges, brep.vertices, genus=1).check()[0]
    assert Brep(brep.faces[1:], brep.edges, brep.vertices).check()


def test_json_carries_the_fields_of_the_summary() -> None:
    stored = _brep(parts.build("d_shaft")).as_json()
    assert {"id", "shape", "status", "convex", "parameters", "sigma", "extent_mm", "area_mm2"} <= set(
        stored["faces"][0]
    )
    assert {"id", "faces", "kind", "curve", "length_mm", "dihedral_deg", "status"} <= set(stored["edges"][0])
    assert stored["faces"][0]["parameters"]["radius_mm"] == 18


def test_least_rectangle_does_not_depend_on_the_turn() -> None:
    corners = np.array([[0.0, 0, 0], [7, 0, 0], [7, 3, 0], [0, 3, 0]])
    for turn in np.linspace(0, 3, 7):
        c, s = np.cos(turn), np.sin(turn)
        turned = corners @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        assert rectangle(turned, np.array([0.0, 0, 1])) == pytest.approx((7, 3))


def test_an_unlabeled_block_has_the_boundary_of_its_tree() -> None:
    tree = parts.build("stepped_block")
    solid = Solid.from_csg(tree)
    bare = boundary(Solid.from_mesh(solid.vertices, solid.triangles))
    assert bare.check() == ()
    extents = [np.array(sorted(face.extent for face in brep.faces)) for brep in (bare, _brep(tree))]
    np.testing.assert_allclose(*extents, atol=1e-6)


def test_a_right_triangle_has_its_longest_side_for_length_however_it_is_turned() -> None:
    corners = np.array([[0.0, 0, 0], [30, 0, 0], [0, 40, 0]])
    for turn in np.linspace(0, 6, 9):
        c, s = np.cos(turn), np.sin(turn)
        turned = corners @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        assert rectangle(turned, np.array([0.0, 0, 1])) == pytest.approx((50, 24))


def test_noise_does_not_choose_among_a_triangles_rectangles() -> None:
    triangle = np.array([[-30.0, 0.0, 0.0], [30.0, 0.0, 0.0], [0.0, 62.65, 0.0]])
    rng = np.random.default_rng(5)
    for _ in range(40):
        felt = triangle + np.column_stack([rng.normal(0.0, 0.005, (3, 2)), np.zeros(3)])
        assert rectangle(felt, np.array([0.0, 0, 1])) == pytest.approx((69.46, 54.11), abs=0.05)


def test_a_rounded_block_has_four_faces_at_each_corner() -> None:
    tree = openscad.read_text("minkowski() { cube([20, 12, 8]); sphere(r = 2); }").tree
    brep = boundary(Solid.from_csg(tree, 0.01))
    assert brep.check() == ()
    assert (len(brep.faces), len(brep.edges), len(brep.vertices)) == (26, 48, 24)
    assert Counter(sorted_kinds(brep, edge) for edge in brep.edges) == {
        ("cylinder", "plane"): 24,
        ("cylinder", "sphere"): 24,
    }


def sorted_kinds(brep: Brep, edge: Edge) -> tuple[str, ...]:
    return tuple(sorted(brep.faces[face].kind for face in edge.faces))


def test_a_face_of_which_nothing_but_a_sliver_is_left_is_anchored_on_it():
    corners = np.array([[[0.0, 0.0, 5.0], [4.0, 0.0, 5.0], [2.0, 0.0, 5.0]]])
    shape, extent = anchored(Plane([0.0, 0.0, 5.0], [0.0, 0.0, 1.0]), corners, np.empty((0, 3)))
    assert np.allclose(shape.origin, [2.0, 0.0, 5.0])
    assert extent == (0.0, 0.0)
