"""What a patch graph is reconstructed to, and what of it counts as measured."""

from dataclasses import replace

import numpy as np
import pytest

from models.boundary import labeled_boundary
from models.csg import Cube, Cylinder, Prism, Sphere
from models.solid import Solid, iou
from primitives.evidence import NOT_FELT, Contacts, EdgeTrace
from primitives.fit import fit
from primitives.patch_graph import PatchGraph
from primitives.pose import pose, random_rotation
from recognition import best_body
from recognition.assembly import Assembly
from recognition.assembly.piece import Piece
from recognition.assembly.regularities import regularize
from recognition.open_sides import open_ended
from recognition.reconstruct import reconstruct

BOX = np.array([[-150.0, -150, -150], [150, 150, 150]])


def graph_of(tree, per_face=80, skip=()):
    """A graph with contacts spread over each face of a solid, but those in `skip`; and its boundary."""
    solid = Solid.from_csg(tree, 0.01)
    brep, of_triangle = labeled_boundary(solid)
    rng, graph = np.random.default_rng(0), PatchGraph()
    for face in brep.faces:
        corners = solid.vertices[solid.triangles[of_triangle == face.id]]
        area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        chosen = corners[rng.choice(len(corners), per_face, p=area / area.sum())]
        points = np.einsum("nk,nkj->nj", rng.dirichlet([1, 1, 1], per_face), chosen)
        normals = face.shape.normals(points) * (1 if face.convex else -1)
        points = points - face.shape.signed_distance(points)[:, None] * face.shape.normals(points)
        if face.id not in skip:
            graph, _ = graph.add_stroke(Contacts.of(points, normals, 0.01, 0.01))
    return graph, brep


@pytest.mark.parametrize("seed", [0, 2, 3])
def test_sides_that_nobody_felt_end_with_the_contacts_at_any_attitude(seed):
    world = pose(random_rotation(np.random.default_rng(seed)))
    disc, lip = Cylinder(30.0, 8.0).at(0, 25, 0), Cube((56, 6, 20)).at(0, -22, 6)  # the disc is 60 mm wide
    part = (Cube((56.0, 50.0, 8.0)) | disc | lip).placed(world)
    brep = labeled_boundary(Solid.from_csg(part, 0.01))[0]
    across = [f.id for f in brep.faces if f.kind == "plane" and abs(f.shape.direction @ world[:3, 0]) > 0.9]
    made = reconstruct(graph_of(part, skip=across)[0], [], BOX)
    reached = made.assembly.solid.vertices @ world[:3, 0]
    assert np.ptp(reached) == pytest.approx(60.0, abs=1.0)


def test_a_body_that_ends_stays_where_to_end_it_sooner_closes_nothing(monkeypatch):
    """Ends at 15 mm past all contacts close it, those at 4 mm do not: the body that was cut off is kept."""
    graph, _ = graph_of(Cube((60.0, 40.0, 20.0)), skip=[5])
    long, short = (Cube((60.0, 40.0, high)).at(0, 0, 0.5 * high - 10.0) for high in (90.0, 26.0))

    def assembled(felt, box, **besides):
        tree = short if len(felt) == 6 and len(asked) == 2 else long
        asked.append(len(felt))
        piece = Piece("cube", "add", tree, np.eye(4), None, ((0, 1), (2, 3), (4, None)))
        return Assembly((), regularize(()), (0,) * len(felt), (piece,), tree, Solid.from_csg(tree), ())

    asked = []
    monkeypatch.setattr(best_body, "assemble", assembled)
    felt = [best_body.FeltFace(face.fit, face.contacts) for face in graph.faces]
    asked.append(0)
    body = best_body.best_body(felt, BOX, None, 15.0)
    assert body.assembly.solid.bounds[1, 2] == pytest.approx(16.0)
    assert body.ends


@pytest.mark.parametrize(
    ("kind", "ends", "is_open"),
    [
        ("cube", ((0, 1), (2, 3), (4, 5)), False),
        ("cube", ((0, 1), (None, 3), (4, 5)), True),
        ("prism", ((None, None), (None, None), (0, 1)), False),  # its outline is made of faces all round
        ("prism", ((None, None), (None, None), (0, None)), True),
        ("cylinder", ((0, None),), True),
        ("sphere", (), False),
    ],
)
def test_a_body_is_open_ended_where_what_is_added_has_a_side_without_a_face(kind, ends, is_open):
    solid = Cube((10.0, 10.0, 10.0))
    piece = Piece(kind, "add", solid, np.eye(4), None, ends)
    away = Piece("cube", "subtract", solid, np.eye(4), None, ((None, None),) * 3)
    made = Assembly((), regularize(()), (), (piece, away), solid, Solid.from_csg(solid), ())
    assert open_ended(made) is is_open


def test_edges_are_measured_where_both_faces_were_touched_beside_them():
    graph, _ = graph_of(Cube((20, 16, 12)))
    made = reconstruct(graph, [], BOX)
    assert made.assembly
    assert [edge["status"] for edge in made.edges] == ["measured"] * 12
    assert set(np.unique(made.face_of_contact)) == set(range(6))


def test_an_edge_far_from_every_contact_is_inferred_until_it_is_traced():
    graph, _ = graph_of(Cube((120, 120, 120)), per_face=6)
    made = reconstruct(graph, [], BOX)
    assert made.assembly
    assert "inferred" in {edge["status"] for edge in made.edges}
    edge = next(
        e for e, row in zip(made.boundary.brep.edges, made.edges, strict=True) if row["status"] == "inferred"
    )
    points = np.linspace(edge.points[0], edge.points[-1], 30)
    still = np.zeros_like(points)
    trace = EdgeTrace(points, still, still, np.full(30, 0.1), False, 0, 0)
    assert reconstruct(graph, [trace], BOX).edges[edge.id]["status"] == "measured"


def test_of_two_faces_on_one_cylinder_only_the_touched_one_is_measured():
    shaft = Cylinder(20, 30) & Cube((60, 24, 60))
    _, brep = graph_of(shaft)
    round_faces = [face.id for face in brep.faces if face.kind == "cylinder"]
    assert len(round_faces) == 2
    graph, _ = graph_of(shaft, skip=round_faces[1:])
    made = reconstruct(graph, [], BOX)
    assert made.assembly
    states = sorted(face["status"] for face in made.faces if face["shape"] == "cylinder")
    assert states == ["inferred", "measured"]


def test_an_open_boundary_has_faces_without_extent_and_a_reason():
    graph, _ = graph_of(Cube((20, 16, 12)), skip=range(1, 6))
    made = reconstruct(graph, [], BOX)
    assert not made.assembly
    assert not made.closed
    assert [face["extent_mm"] for face in made.faces] == [None]
    assert made.warnings[0].startswith("no closed body: ")
    assert set(np.unique(made.face_of_contact)) == {0}


@pytest.mark.parametrize("missing", [(0,), (0, 3), (2, 4, 5)])
def test_a_body_is_cut_off_where_contact_ended_and_nothing_closes_it(missing):
    cube = Cube((40, 32, 24))
    graph, _ = graph_of(cube, skip=missing, per_face=200)
    made = reconstruct(graph, [], BOX)
    assert made.assembly
    assert not made.closed
    assert iou(made.assembly.solid, Solid.from_csg(cube, 0.01)) > 0.9
    assert sorted(face["status"] for face in made.faces).count("inferred") == len(missing)
    assert sum("cut off where contact ended" in warning for warning in made.warnings) == len(missing)


def test_a_body_is_not_cut_off_by_an_end_that_lies_inside_another_limb():
    rng = np.random.default_rng(0)
    flat = np.column_stack([rng.uniform(-8.0, 8.0, (12, 2)), np.zeros(12)])
    lots = [
        Contacts.of(flat + np.array([0.0, 0.0, z]), np.tile([0.0, 0.0, z - 30.0], (12, 1)))
        for z in (0.0, 70.0)
    ]
    ends = tuple(best_body.FeltFace(fit("plane", lot), lot) for lot in lots)
    tree = Sphere(24.0) | Cylinder(8.0, 70.0).at(0, 0, 35)
    fits = tuple(end.fit for end in ends)
    made = Assembly(fits, regularize(fits), (0, 1), (), tree, Solid.from_csg(tree), ())
    assert best_body.Body(made, (), ends).cut == (ends[1],)


def test_a_round_body_is_cut_off_along_its_axis_alone():
    rod = Cylinder(10, 60)
    _, brep = graph_of(rod)
    graph, _ = graph_of(rod, skip=[face.id for face in brep.faces if face.kind == "plane"], per_face=200)
    made = reconstruct(graph, [], BOX)
    assert [row["kind"] for row in made.primitives] == ["cylinder"]
    assert len(made.faces) == 3


def test_a_post_of_which_the_end_was_never_felt_reaches_as_far_as_contact_did():
    post = Cube((70, 70, 12)) | Cylinder(10, 40).at(0, 0, 20)
    _, brep = graph_of(post)
    end = min((f for f in brep.faces if f.kind == "plane" and f.area < 400.0), key=lambda f: f.area)
    graph, _ = graph_of(post, skip=[end.id], per_face=60)
    few = []
    for face in graph.faces:
        low = np.flatnonzero(face.contacts.points[:, 2] < 24.0)
        few.append(
            face if face.fit.kind == "plane" else replace(face, contacts=face.contacts.select(low[:12]))
        )
    made = reconstruct(PatchGraph(tuple(few)), [], BOX)
    assert made.assembly.solid.bounds[1, 2] > 18.0
    assert "cylinder" in [row["kind"] for row in made.primitives]


def test_a_knob_that_was_felt_in_few_places_stays_beside_a_plate_that_was_felt_all_over():
    knob = Cube((70, 70, 12)) | Sphere(14).at(0, 0, 12)
    graph, _ = graph_of(knob, per_face=400)
    few = [
        f if f.fit.kind == "plane" else replace(f, contacts=f.contacts.select(np.arange(9)))
        for f in graph.faces
    ]
    made = reconstruct(PatchGraph(tuple(few)), [], BOX)
    assert iou(made.assembly.solid, Solid.from_csg(knob, 0.01)) > 0.97


def test_what_nobody_touched_of_a_body_is_told():
    graph, _ = graph_of(Cube((80, 60, 60)), per_face=200)
    assert reconstruct(graph, [], BOX).warnings == ()
    seen = [replace(f, contacts=f.contacts.select(f.contacts.points[:, 0] < 10.0)) for f in graph.faces]
    end = int(np.argmin([len(f.contacts) for f in seen]))
    stopped = replace(graph.faces[end].contacts, touch=np.full(200, NOT_FELT))
    seen[end] = replace(graph.faces[end], contacts=stopped)
    inferred, past = reconstruct(PatchGraph(tuple(seen)), [], BOX).warnings
    assert inferred.startswith("14% of the surface is inferred, not touched: face ")
    assert past.startswith("the body reaches 30 mm past all that was touched")


def test_a_model_in_pieces_is_told():
    two = Cube((20, 20, 20)).at(-30, 0, 0) | Cube((20, 24, 16)).at(30, 0, 0)
    graph, _ = graph_of(two)
    made = reconstruct(graph, [], BOX)
    assert iou(made.assembly.solid, Solid.from_csg(two, 0.01)) > 0.98
    assert made.warnings == ("the model lies in 2 pieces: what joins them was not felt, or not enough",)


def test_a_round_face_that_contradicts_the_others_is_left_out(monkeypatch):
    graph, _ = graph_of(Cube((20, 16, 12)))
    ball, _ = graph_of(Sphere(3.0), per_face=9)
    (stray,) = ball.faces
    assemble = best_body.assemble

    def strict(felt, box, **besides):
        if any(face.fit.kind == "sphere" for face in felt):
            raise ValueError("singular")
        return assemble(felt, box, **besides)

    monkeypatch.setattr(best_body, "assemble", strict)
    both = PatchGraph((*graph.faces, replace(stray, id=9)))
    made = reconstruct(both, [], BOX)
    assert made.closed
    assert made.warnings[0] == "a face (sphere, 9 contacts) contradicts the others; left out"
    assert len(made.contacts) == 6 * 80 + 9
    assert (made.face_of_contact[-9:] == -1).all()


def test_walls_that_nobody_felt_do_not_keep_a_round_one_that_was_out_of_the_body():
    """Sixteen guessed flats within a rod would be all of it, and one alone takes some away of what was felt."""
    graph, _ = graph_of(Cylinder(10.0, 30.0))
    felt = [best_body.FeltFace(face.fit, face.contacts) for face in graph.faces]
    turns = 2.0 * np.pi * np.arange(16) / 16

    def guessed(turn, out):
        way, along = np.array([np.cos(turn), np.sin(turn), 0.0]), np.array([-np.sin(turn), np.cos(turn), 0.0])
        places = out * way + np.array([s * along + [0.0, 0.0, t] for s in (-1, 0, 1) for t in (-9, 0, 9)])
        contacts = Contacts.of(places, np.broadcast_to(way, places.shape), 0.05, 0.05, touch=NOT_FELT)
        return best_body.FeltFace(fit("plane", contacts), contacts)

    body = best_body.best_body([*felt, *(guessed(turn, 9.8) for turn in turns)], BOX, None, 15.0)
    assert body.assembly.solid.volume == pytest.approx(np.pi * 100.0 * 30.0, rel=0.003)


@pytest.mark.parametrize("seed", [0, 1])
def test_a_side_that_no_face_ends_is_said_and_lies_at_the_last_contact(seed):
    world = pose(random_rotation(np.random.default_rng(seed)))
    step = (Cube((60.0, 40.0, 10.0)) | Cube((20.0, 40.0, 20.0)).at(-20, 0, 5)).placed(world)
    brep = labeled_boundary(Solid.from_csg(step, 0.01))[0]
    end = [f.id for f in brep.faces if f.shape.direction @ world[:3, 1] > 0.9]
    graph, _ = graph_of(step, skip=end)
    felt = [best_body.FeltFace(face.fit, face.contacts) for face in graph.faces]
    body = best_body.best_body(felt, BOX, None, 15.0)
    last = max(float((face.contacts.points @ world[:3, 1]).max()) for face in felt)
    assert (body.assembly.solid.vertices @ world[:3, 1]).max() == pytest.approx(last, abs=0.01)
    assert not body.whole
    (told,) = body.told()
    way = np.array([float(v) for v in told.split("(")[1].split(")")[0].split(",")])
    np.testing.assert_allclose(way, world[:3, 1], atol=0.01)
    whole = graph_of(step)[0]
    closed = best_body.best_body(
        [best_body.FeltFace(f.fit, f.contacts) for f in whole.faces], BOX, None, 15.0
    )
    assert closed.whole
    assert closed.told() == []


def body_of(tree, skip=()):
    """Of all contacts of a part, but those of the faces in `skip`."""
    graph, _ = graph_of(tree, skip=skip)
    return best_body.best_body([best_body.FeltFace(f.fit, f.contacts) for f in graph.faces], BOX, None, 15.0)


@pytest.mark.parametrize(
    "part",
    [
        Cube((60, 30, 8))
        | Cube((30, 30, 20)).at(0, 0, 10)
        | Cylinder(15, 30).turned("x", np.pi / 2).at(0, 0, 20),
        Cube((40, 20, 10))
        | Cylinder(10, 10).at(20, 0, 0)
        | Cylinder(10, 10).at(-20, 0, 0)
        | Cube((8, 20, 20)),
    ],
)
def test_where_flat_sides_end_at_a_round_one_the_body_is_closed(part):
    body = body_of(part.placed(pose(random_rotation(np.random.default_rng(1)))))
    assert body.whole
    assert body.told() == []


def test_a_post_of_which_nobody_felt_the_top_ends_with_the_contacts_and_says_so():
    turns = np.pi / 3.0 * np.arange(6)
    post = Prism(tuple((9.0 * np.cos(t), 9.0 * np.sin(t)) for t in turns), 36.0)
    part = Cube((60, 60, 8)) | post.at(0, 0, 22.0)
    brep = labeled_boundary(Solid.from_csg(part, 0.01))[0]
    top = [
        f.id
        for f in brep.faces
        if f.kind == "plane" and f.shape.anchor[2] > 39.0 and f.shape.direction[2] > 0.9
    ]
    assert len(top) == 1
    body = body_of(part, top)
    assert not body.whole
    assert len(body.told()) == 1
    assert body.assembly.solid.bounds[1, 2] == pytest.approx(40.0, abs=1.0)
    assert body.assembly.solid.bounds[1, 2] < 40.01
