import numpy as np
import pytest

from primitives.errors import PalpateError
from primitives.evidence import Contacts, EdgeTrace
from primitives.fit import NoFit, fit
from primitives.patch_graph import Face, MergeOptions, PatchGraph, join, ranked_face
from primitives.shapes import Cylinder, Plane


def stroke_on(shape, rng, middle, n=20, width=6.0, sigma=0.05, turn=0.03):
    points = shape.project(np.asarray(middle) + rng.uniform(-width, width, (n, 3)))
    normals = shape.normals(points)
    points = points + sigma * normals * rng.standard_normal((n, 1))
    normals = normals + turn * rng.standard_normal((n, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Contacts.of(points, normals, sigma, turn)


CUBE = [Plane(20 * s * np.eye(3)[a], s * np.eye(3)[a]) for a in range(3) for s in (1.0, -1.0)]


def trace():
    x = np.linspace(0, 10, 5)
    points = np.stack([x, 0 * x, 0 * x], axis=1)
    return EdgeTrace(
        points, np.tile([1.0, 0, 0], (5, 1)), np.tile([0, 0, 1.0], (5, 1)), np.full(5, 0.1), False, 0, 0
    )


def test_strokes_on_a_cube_open_six_faces_and_rejoin_them():
    rng, graph, ids = np.random.default_rng(0), PatchGraph(), []
    for _ in range(2):
        for face in CUBE:
            graph, found = graph.add_stroke(stroke_on(face, rng, face.origin + rng.uniform(-8, 8, 3)))
            ids.append(found)
    assert ids == [*range(6), *range(6)]
    assert all(face.fit and face.fit.kind == "plane" for face in graph.faces)


def test_strokes_round_a_cylinder_are_one_face():
    rng, graph, rod = np.random.default_rng(1), PatchGraph(), Cylinder([0, 0, 0], [0, 0, 1], 15.0)
    for angle in np.linspace(0, 2 * np.pi, 7):
        middle = [15 * np.cos(angle), 15 * np.sin(angle), rng.uniform(-15, 15)]
        graph, _ = graph.add_stroke(stroke_on(rod, rng, middle))
    assert len(graph.faces) == 1
    assert graph.faces[0].fit.shape.radius == pytest.approx(15.0, abs=0.1)


def test_the_narrow_sides_of_a_plate_are_no_faces_of_one_cylinder(monkeypatch):
    """One of them was read as one; fitted again to both, it has half the plate's width."""
    rng, lots = np.random.default_rng(3), []
    for sign in (1.0, -1.0):
        points = [rng.uniform(0, 60, 40), rng.uniform(-0.75, 0.75, 40), np.full(40, 25.0 * sign)]
        lots.append(Contacts.of(np.column_stack(points) + 0.02 * rng.standard_normal((40, 3)), None, 0.05))
    rod = fit("cylinder", Contacts.concatenate(lots))
    sides = Face(0, rod, lots[0], ()), Face(1, NoFit("too few to tell"), lots[1], ())
    assert join(*sides, MergeOptions()) is None
    monkeypatch.setattr("primitives.patch_graph.two_flats", lambda *_: False)
    joined = join(*sides, MergeOptions())
    assert joined is not None
    assert joined.shape.radius == pytest.approx(25.0, abs=0.2)


def test_parallel_planes_a_millimeter_apart_stay_apart():
    rng, graph = np.random.default_rng(2), PatchGraph()
    for height in (0.0, 1.0):
        graph, _ = graph.add_stroke(
            stroke_on(Plane([0, 0, height], [0, 0, 1]), rng, [height * 20, 0, height])
        )
    assert len(graph.faces) == 2


def test_two_faces_are_asked_once_whether_they_are_one(monkeypatch):
    rng, asked = np.random.default_rng(4), []
    faces = tuple(ranked_face(i, stroke_on(CUBE[i], rng, CUBE[i].origin), MergeOptions()) for i in range(4))

    def join(first, second, options):
        asked.append((first.id, second.id))

    monkeypatch.setattr("primitives.patch_graph.join", join)
    graph, _ = PatchGraph(faces).merge_faces()
    assert len(asked) == 6
    graph, _ = graph.merge_faces()
    assert len(asked) == 6
    graph.add_contacts(stroke_on(CUBE[1], rng, CUBE[1].origin), 1).merge_faces()
    assert sorted(asked[6:]) == [(0, 1), (1, 2), (1, 3)]


def test_faces_that_turn_out_to_be_one_merge_with_their_edges():
    rng, graph = np.random.default_rng(3), PatchGraph()
    top, side = CUBE[4], CUBE[0]
    faces = tuple(
        ranked_face(i, stroke_on(shape, rng, shape.origin + np.array(shift, dtype=float)), graph.options)
        for i, (shape, shift) in enumerate([(top, (-8, 0, 0)), (side, (0, 0, 0)), (top, (8, 0, 0))])
    )
    graph, edge = PatchGraph(faces).add_trace(trace(), 2)
    merged, gone = graph.attach(edge, 1).merge_faces()
    assert gone == {2: 0}
    assert [face.id for face in merged.faces] == [0, 1]
    assert merged.edges[0].faces == (0, 1)
    assert len(merged.face(0).contacts) == 40
    assert len(graph.faces) == 3


def test_an_edge_is_open_until_its_other_face_is_known():
    rng = np.random.default_rng(4)
    graph, first = PatchGraph().add_stroke(stroke_on(CUBE[0], rng, CUBE[0].origin))
    graph, second = graph.add_stroke(stroke_on(CUBE[2], rng, CUBE[2].origin))
    graph, edge = graph.add_trace(trace(), first)
    assert [e.id for e in graph.open_edges()] == [edge]
    closed = graph.attach(edge, second)
    assert closed.open_edges() == ()
    assert closed.edges_of(second)[0].faces == (first, second)
    assert len(graph.open_edges()) == 1


def test_what_is_not_there_is_refused():
    with pytest.raises(PalpateError, match="no face 3"):
        PatchGraph().face(3)
    with pytest.raises(PalpateError, match="no edge 5"):
        PatchGraph(
            (
                Face(
                    0,
                    ranked_face(0, Contacts.of([[0, 0, 0.0]]), PatchGraph().options).fit,
                    Contacts.of([[0, 0, 0.0]]),
                ),
            )
        ).attach(5, 0)
