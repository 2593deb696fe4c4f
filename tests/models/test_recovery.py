from collections import Counter
from math import pi

import networkx as nx
import numpy as np
import pytest
import trimesh

from models.boundary import boundary
from models.brep import Brep
from models.csg import Cone, Csg, Cube, Cylinder, Sphere
from models.explained import freeform_area_fraction, unassigned_area_fraction
from models.solid import Solid
from primitives.arrays import Floats
from primitives.pose import pose, random_rotation, transform_points

FACETS = 0.05  # [mm] between the meshes here and their surfaces


def _bare(tree: Csg, noise: float = 0.0, tolerance: float = FACETS) -> Solid:
    """The mesh of a tree without its labels, in single precision as an STL keeps it."""
    solid = Solid.from_csg(tree, tolerance)
    shaken = solid.vertices + noise * np.random.default_rng(0).standard_normal(solid.vertices.shape)
    return Solid.from_mesh(shaken.astype(np.float32).astype(float), solid.triangles)


def _incidence(brep: Brep) -> str:
    """A code of which faces meet in which edges: equal for isomorphic boundaries."""
    graph = nx.Graph()
    for face in brep.faces:
        graph.add_node(("face", face.id), label=f"{face.kind} {face.convex}")
    for edge in brep.edges:
        graph.add_node(("edge", edge.id), label=edge.kind)
        graph.add_edges_from((("edge", edge.id), ("face", face)) for face in edge.faces)
    code: str = nx.weisfeiler_lehman_graph_hash(graph, node_attr="label", iterations=5)
    return code


def _kinds(solid: Solid) -> Counter[str]:
    return Counter(face.kind for face in boundary(solid).faces)


def _strip(profile: Floats, depth: float) -> Solid:
    """The prism over a closed polygon (n, 2), star-shaped about its middle."""
    n = len(profile)
    rings = [np.column_stack([profile, np.full(n, z)]) for z in (0.0, depth)]
    middle = profile.mean(axis=0)
    vertices = np.concatenate([*rings, [[*middle, 0.0], [*middle, depth]]])
    i, j = np.arange(n), np.roll(np.arange(n), -1)
    triangles = np.concatenate(
        [
            np.stack([i, j, j + n], axis=1),
            np.stack([i, j + n, i + n], axis=1),
            np.stack([j, i, np.full(n, 2 * n)], axis=1),
            np.stack([i + n, j + n, np.full(n, 2 * n + 1)], axis=1),
        ]
    )
    return Solid.from_mesh(vertices, triangles)


TREES = {
    "rod": Cylinder(12, 60),
    "frustum": Cone(25, 12, 35),
    "cone to its apex": Cone(25, 0, 50),
    "ball": Sphere(20),
    "shaft with a flat": Cylinder(18, 60) & Cube((40, 40, 80)).at(-8, 0, 0),
    "plate with a hole": Cube((80, 50, 10)) - Cylinder(12, 30),
    "countersunk plate": Cube((70, 50, 14)) - Cylinder(6, 40) - Cone(2, 18, 16).at(0, 0, 3),
    "crossed bars, every chord cut": Cylinder(16, 90) | Cylinder(12, 90).turned("y", pi / 2),
    "tangent dome": Cylinder(15, 30).at(0, 0, -15) | Sphere(15),
    "cavity": Cube((40, 40, 40)) - Sphere(12),
}


@pytest.mark.parametrize("name", TREES)
def test_a_bare_mesh_has_the_faces_and_adjacency_of_its_tree(name: str) -> None:
    tree = TREES[name]
    found = boundary(_bare(tree))
    assert found.check() == ()
    assert _incidence(found) == _incidence(boundary(Solid.from_csg(tree, FACETS)))
    assert unassigned_area_fraction(_bare(tree)) == 0


@pytest.mark.parametrize("name", ["frustum", "plate with a hole", "countersunk plate"])
def test_parameters_are_within_the_facets_tolerance(name: str) -> None:
    wanted = {(f.kind, f.convex): f.shape for f in boundary(Solid.from_csg(TREES[name])).faces if f.shape}
    for face in boundary(_bare(TREES[name])).faces:
        assert face.shape is not None
        if face.kind == "plane":
            continue
        truth = wanted[face.kind, face.convex]
        size = np.subtract(face.shape.sizes, truth.sizes)
        assert abs(size).max() < (np.deg2rad(0.1) if face.kind == "cone" else FACETS)
        if face.kind != "sphere":
            turned = np.linalg.norm(np.cross(face.shape.direction, truth.direction))
            assert turned < np.deg2rad(0.1)


def test_recovery_does_not_depend_on_the_pose() -> None:
    solid = _bare(TREES["countersunk plate"])
    rng = np.random.default_rng(3)
    moved = transform_points(pose(random_rotation(rng), rng.uniform(-50, 50, 3)), solid.vertices)
    turned = boundary(Solid.from_mesh(moved, solid.triangles))
    assert _incidence(turned) == _incidence(boundary(solid))
    areas = [sorted(face.area for face in brep.faces) for brep in (turned, boundary(solid))]
    np.testing.assert_allclose(*areas, rtol=1e-6)


def test_a_scaled_mesh_has_the_same_faces() -> None:
    solid = _bare(TREES["shaft with a flat"])
    for factor in (0.1, 10.0):
        scaled = Solid.from_mesh(factor * solid.vertices, solid.triangles)
        assert _incidence(boundary(scaled)) == _incidence(boundary(solid))


def test_six_written_digits_are_enough() -> None:
    solid = Solid.from_csg(TREES["plate with a hole"].at(31.4159, 0, 0), FACETS)
    written = np.vectorize(lambda x: float(f"{x:.6g}"))(solid.vertices)
    assert _kinds(Solid.from_mesh(written, solid.triangles)) == {"plane": 6, "cylinder": 1}


@pytest.mark.parametrize(
    ("sides", "kinds"), [(6, {"plane": 8}), (8, {"plane": 10}), (12, {"cylinder": 1, "plane": 2})]
)
def test_few_sides_are_flats_and_twelve_are_round(sides: int, kinds: dict[str, int]) -> None:
    turn = 2 * pi / sides * np.arange(sides)
    assert _kinds(_strip(10 * np.stack([np.cos(turn), np.sin(turn)], axis=1), 20)) == kinds


def test_a_large_flat_beside_a_fillet_stays_flat() -> None:
    turn = np.linspace(0, pi / 2, 7)
    arc = 4 * np.stack([np.cos(turn), np.sin(turn)], axis=1) + [26, 16]
    brep = boundary(_strip(np.concatenate([arc, [[-30, 20], [-30, -20], [30, -20]]]), 15))
    fillet = next(face for face in brep.faces if face.kind == "cylinder")
    assert Counter(face.kind for face in brep.faces) == {"plane": 6, "cylinder": 1}
    assert fillet.extent == pytest.approx((15, 2 * pi), rel=1e-4)
    assert Counter(edge.kind for edge in brep.edges if fillet.id in edge.faces) == {"smooth": 2, "convex": 2}


def test_a_smooth_surface_of_no_shape_is_one_freeform_face() -> None:
    x = np.linspace(-30, 30, 41)
    top = np.column_stack([x, 12 + 6 * np.cos(x / 11) + 2 * np.sin(x / 5)])[::-1]
    solid = _strip(np.concatenate([top, [[-30, -10], [30, -10]]]), 25)
    brep = boundary(solid)
    assert Counter(face.kind for face in brep.faces) == {"plane": 5, "freeform": 1}
    assert brep.check() == ()
    free = next(face for face in brep.faces if face.shape is None)
    assert freeform_area_fraction(solid) == pytest.approx(free.area / solid.area)
    assert unassigned_area_fraction(solid) == 0


def test_a_body_is_recovered_once() -> None:
    solid = _bare(TREES["rod"])
    assert boundary(solid) is boundary(solid.placed(pose(None, (1, 2, 3))))


def test_a_ring_that_rounding_raised_at_one_rim_is_a_plane():
    tube = trimesh.creation.annulus(10.0, 25.0, 40.0, sections=28)
    vertices = np.array(tube.vertices)
    rim = (vertices[:, 2] > 0.0) & (np.linalg.norm(vertices[:, :2], axis=1) < 15.0)
    vertices[rim, 2] += 1.6e-3
    assert _kinds(Solid.from_mesh(vertices, tube.faces)) == {"plane": 2, "cylinder": 2}
