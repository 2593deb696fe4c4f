import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from models import parts
from models.boundary import boundary
from models.brep import Brep, Edge, Face
from models.comparison.canonical import Canonical, same_boundary
from models.comparison.isomorphism import same_topology
from models.comparison.signature import probes, signature
from models.csg import Cone, Csg, Cube, Cylinder, Sphere, Torus
from models.solid import Solid
from primitives.arrays import frozen
from primitives.pose import pose, random_rotation, transform_points

CHIRAL = Cube((60, 40, 20)) - Cube((20, 20, 20)).at(25, 15, 5) - Cylinder(4, 60).at(-20, -10, 0)


def brep_of(tree: Csg) -> Brep:
    return boundary(Solid.from_csg(tree))


def posed(seed: int) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return pose(random_rotation(rng), rng.uniform(-200, 200, 3))


def shuffled(brep: Brep, seed: int) -> Brep:
    """The same boundary with faces, edges and vertices numbered anew, and edges run the other way."""
    rng = np.random.default_rng(seed)
    face, edge, vertex = (rng.permutation(len(x)) for x in (brep.faces, brep.edges, brep.vertices))

    def turned(old: Edge) -> Edge:
        f, g = old.faces
        ends = None if old.vertices is None else tuple(int(vertex[v]) for v in old.vertices[::-1])
        points = frozen(old.points[::-1])
        number = int(edge[old.id])
        return Edge(
            number,
            (int(face[g]), int(face[f])),
            old.kind,
            old.curve,
            old.length,
            old.dihedral_deg,
            points,
            ends,
        )

    def renumbered(old: Face) -> Face:
        loops = tuple(tuple(int(edge[e]) for e in loop) for loop in old.loops)
        return Face(int(face[old.id]), old.shape, old.convex, old.area, old.extent, loops, old.handles)

    corners = np.empty_like(brep.vertices)
    corners[vertex] = brep.vertices
    return Brep(
        tuple(sorted(map(renumbered, brep.faces), key=lambda f: f.id)),
        tuple(sorted(map(turned, brep.edges), key=lambda e: e.id)),
        frozen(corners),
        brep.shells,
        brep.genus,
    )


def mirrored(brep: Brep) -> Brep:
    """The image in the plane x = 0."""
    flip = np.diag([-1.0, 1.0, 1.0])
    turned = shuffled(brep, 0)  # runs edges the other way, as a mirror does
    faces = [
        Face(
            f.id,
            f.shape and f.shape.with_parts(flip @ f.shape.anchor, flip @ f.shape.direction, f.shape.sizes),
            f.convex,
            f.area,
            f.extent,
            tuple(tuple(reversed(loop)) for loop in f.loops),
            f.handles,
        )
        for f in turned.faces
    ]
    edges = [
        Edge(e.id, e.faces, e.kind, e.curve, e.length, e.dihedral_deg, frozen(e.points @ flip), e.vertices)
        for e in turned.edges
    ]
    return Brep(tuple(faces), tuple(edges), frozen(turned.vertices @ flip), brep.shells, brep.genus)


FEW = (
    "block",
    "cube",
    "cylinder",
    "cone",
    "sphere",
    "d_shaft",
    "wedge",
    "octagon",
    "bracket",
    "plate_with_hole",
)


@pytest.fixture(scope="module")
def breps() -> dict[str, Brep]:
    return {
        name: brep_of(parts.build(name)) for name in (*FEW, "flange", "countersunk_plate", "slotted_block")
    }


@pytest.mark.slow
def test_many_parts_equal_themselves_and_no_other() -> None:
    every = {name: brep_of(parts.build(name)) for name in parts.names()[::6]}
    test_parts_equal_themselves_in_any_pose_and_order(every)
    test_no_part_equals_another(every)
    test_signatures_of_equal_boundaries_are_found_by_probing(every)


def test_parts_equal_themselves_in_any_pose_and_order(breps: dict[str, Brep]) -> None:
    for i, (name, brep) in enumerate(breps.items()):
        motion = posed(i)
        match = same_boundary(brep, shuffled(brep, i).moved(motion), 1e-3)
        assert match, (name, match)
        points = transform_points(match.b_from_a, brep.vertices)
        theirs = shuffled(brep, i).moved(motion).vertices[list(match.vertices)]
        np.testing.assert_allclose(points, theirs, atol=1e-3)


def test_no_part_equals_another(breps: dict[str, Brep]) -> None:
    names = list(breps)
    same = [(a, b) for i, a in enumerate(names) for b in names[:i] if same_boundary(breps[a], breps[b])]
    assert same == []


@settings(max_examples=6, deadline=None)
@given(seed=st.integers(0, 10_000), name=st.sampled_from(["bracket", "flange", "lens"]))
def test_the_motion_found_carries_faces_onto_faces(seed: int, name: str) -> None:
    tree = parts.build(name)
    a, b = brep_of(tree), brep_of(tree.placed(posed(seed)))
    match = same_boundary(a, b)
    assert match
    for face, other in zip(a.faces, match.faces, strict=True):
        assert face.shape is not None
        moved, wanted = face.shape.transformed(match.b_from_a), b.faces[other]
        assert wanted.kind == face.kind
        assert wanted.area == pytest.approx(face.area, rel=1e-3)
        rim = np.concatenate([b.edges[e].points for loop in wanted.loops for e in loop])
        assert np.abs(moved.signed_distance(rim)).max() < 1e-2


def test_how_a_solid_was_built_does_not_matter() -> None:
    whole = brep_of(Cube((40, 30, 20)) - Cylinder(5, 60))
    halves = Cube((20, 30, 20)).at(-10, 0, 0) | Cube((20, 30, 20)).at(10, 0, 0)
    assert same_boundary(whole, brep_of(halves - Cylinder(5, 90).turned("z", 1.0)))


def test_coarse_facets_of_the_same_tree_are_the_same_boundary() -> None:
    for name in ("flange", "slotted_block", "domed_peg", "countersunk_plate"):
        tree = parts.build(name)
        coarse = boundary(Solid.from_csg(tree, 0.05))
        assert same_boundary(brep_of(tree), coarse), name


@pytest.mark.parametrize(
    "other",
    [
        Cube((60, 40, 12)) - Cylinder(5.3, 30).at(10, 0, 0),
        Cube((60, 40, 12)) - Cylinder(5, 30).at(10.5, 0, 0),
        Cube((60, 40, 12)) - Cylinder(5, 30).at(10, 0, 0) - Cylinder(5, 30).at(-10, 0, 0),
        Cube((60.5, 40, 12)) - Cylinder(5, 30).at(10, 0, 0),
        Cube((60, 40, 12)) - Cylinder(5, 14).at(10, 0, 5),
        Cube((60, 40, 12)) | Cylinder(5, 30).at(10, 0, 0),
    ],
)
def test_one_hole_radius_or_length_makes_a_difference(other: Csg) -> None:
    found = same_boundary(brep_of(Cube((60, 40, 12)) - Cylinder(5, 30).at(10, 0, 0)), brep_of(other))
    assert not found
    assert found.reason


def test_a_cap_and_the_rest_of_its_ball_share_rim_but_not_boundary() -> None:
    ball, block = Sphere(20), Cube((80, 80, 80))
    assert not same_boundary(brep_of(ball & block.at(0, 0, 50)), brep_of(ball & block.at(0, 0, -30)))


def test_mirror_images_of_a_chiral_part_differ_and_say_so() -> None:
    brep = brep_of(CHIRAL)
    found = same_boundary(brep, mirrored(brep))
    assert not found
    assert found.reason == "mirror images"
    assert same_topology(brep, mirrored(brep))


@pytest.mark.parametrize("name", ["bracket", "flange", "cone", "slotted_block", "sphere"])
def test_mirror_images_of_an_achiral_part_are_the_same(name: str) -> None:
    brep = brep_of(parts.build(name))
    assert same_boundary(brep, mirrored(brep))


def test_whole_torus_and_sphere_match_without_any_edge() -> None:
    torus = brep_of(Torus(12, 3))
    assert same_boundary(torus, torus.moved(posed(3)))
    assert not same_boundary(torus, brep_of(Torus(12, 3.5)))
    hollow = brep_of(Sphere(30) - Sphere(20))
    assert same_boundary(hollow, hollow.moved(posed(4)))
    assert not same_boundary(hollow, brep_of(Sphere(30) - Sphere(20).at(0, 0, 5)))


def test_topology_ignores_sizes_and_names_what_is_put_together_otherwise() -> None:
    assert same_topology(brep_of(Cube((1, 2, 3))), brep_of(Cube((40, 40, 40))))
    assert not same_topology(brep_of(Cone(20, 10, 30)), brep_of(Cylinder(10, 30)))
    plate = Cube((90, 60, 10))
    through = plate - Cylinder(5, 40).at(20, 0, 0) - Cylinder(5, 40).at(-20, 0, 0)
    blind = plate - Cylinder(5, 10).at(20, 0, 5) - Cylinder(5, 10).at(-20, 0, 5)
    assert not same_topology(brep_of(through), brep_of(blind))


def test_many_equal_holes_are_matched_one_to_one() -> None:
    def plate(at: float) -> Csg:
        tree: Csg = Cube((100, 100, 8))
        for i in range(16):
            tree = tree - Cylinder(4, 20).at(
                -36 + 24 * (i % 4), -36 + 24 * (i // 4) + (at if i == 5 else 0), 0
            )
        return tree

    a, b = brep_of(plate(0)), brep_of(plate(0).placed(posed(8)))
    match, alike = same_boundary(a, b), same_topology(a, b)
    assert match
    assert alike
    assert sorted(match.faces) == sorted(alike.faces) == list(range(len(a.faces)))
    moved = brep_of(plate(1.0))
    assert not same_boundary(a, moved)
    assert same_topology(a, moved)


def test_signatures_of_equal_boundaries_are_found_by_probing(breps: dict[str, Brep]) -> None:
    for i, (name, brep) in enumerate(breps.items()):
        assert signature(shuffled(brep, i).moved(posed(i))) in probes(brep), name
    assert len({signature(brep) for brep in breps.values()}) > 0.9 * len(breps)


def test_canonical_boundaries_work_in_sets() -> None:
    bracket, block = brep_of(parts.build("bracket")), brep_of(parts.build("block"))
    assert len({Canonical(bracket), Canonical(bracket.moved(posed(1))), Canonical(block)}) == 2
    assert Canonical(block) != "block"
