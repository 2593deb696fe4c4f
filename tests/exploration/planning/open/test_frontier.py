from dataclasses import replace

import numpy as np

from exploration.planning.faces.consistency import drop_contradicted, drop_edges
from exploration.planning.known.touched import Touched
from exploration.planning.open.frontier import Frontier
from exploration.planning.ways.transit import Support
from primitives.evidence import Contacts, EdgeTrace
from primitives.patch_graph import PatchGraph
from primitives.surface_sigma import distance_sigma

BOX = np.array([-50.0, -50.0, -50.0, 50.0, 50.0, 50.0])


def side(axis: int, sign: float, half: float = 15.0, n: int = 40) -> Contacts:
    rng = np.random.default_rng(axis * 2 + int(sign > 0))
    points = rng.uniform(-half, half, (n, 3))
    points[:, axis] = sign * half
    normals = np.zeros((n, 3))
    normals[:, axis] = sign
    return Contacts.of(points, normals, sigma=0.01, normal_sigma=0.005)


def graph_of(*sides: Contacts) -> PatchGraph:
    graph = PatchGraph()
    for contacts in sides:
        graph, _ = graph.add_stroke(contacts)
    return graph


CUBE = graph_of(*(side(a, s) for a in range(3) for s in (-1.0, 1.0)))


def test_six_sides_of_a_cube_predict_its_surface_and_its_twelve_edges():
    frontier = Frontier(CUBE.faces, BOX)
    assert np.abs(np.abs(frontier.predicted.points).max(axis=1) - 15.0).max() < 0.05
    edges = frontier.open_edges([])
    assert len(edges) == 12
    for edge in edges:
        assert np.sort(np.abs(edge.point))[1:].round(1).tolist() == [15.0, 15.0]


def test_a_traced_edge_is_not_open():
    frontier = Frontier(CUBE.faces, BOX)
    along = np.linspace(-15.0, 15.0, 21)
    points = np.column_stack([along, np.full(21, 15.0), np.full(21, 15.0)])
    ones = np.tile([1.0, 0.0, 0.0], (21, 1))
    trace = EdgeTrace(points, ones, ones, np.full(21, 0.1), False, 0, 0)
    assert len(frontier.open_edges([trace])) == 11


def test_what_was_touched_is_not_open():
    frontier = Frontier(CUBE.faces, BOX)
    touched = Touched()
    assert len(frontier.untouched(touched, 5.0).points) == len(frontier.predicted.points)
    top = frontier.predicted.points[frontier.predicted.points[:, 2] > 14.9]
    touched.add(top, Support(np.array([0.0, 0.0, 15.0]), np.array([0.0, 0.0, 1.0])))
    left = frontier.untouched(touched, 5.0).points
    assert left[:, 2].max() < 12.0


def test_a_face_that_cuts_off_what_others_touched_is_dropped():
    rng = np.random.default_rng(9)
    wrong = rng.uniform(-2.0, 2.0, (6, 3))
    wrong[:, 0] = 5.0
    across = Contacts.of(wrong, np.tile([1.0, 0.0, 0.0], (6, 1)), sigma=0.01, normal_sigma=0.005)
    graph, bad = CUBE.add_stroke(across)
    assert len(graph.faces) == 7
    assert [f.id for f in drop_contradicted(graph).faces] == [f.id for f in CUBE.faces if f.id != bad]


def test_consistent_faces_all_stay():
    assert drop_contradicted(CUBE) is CUBE


def test_a_face_stays_though_contacts_of_a_narrow_one_beside_it_reach_past_their_edge():
    graph = graph_of(side(2, 1.0), side(2, -1.0))
    for contacts in (side(a, s) for a in (0, 1) for s in (-1.0, 1.0)):
        z = contacts.points[:, 2]
        past = np.where(np.abs(z) > 10.0, 15.7 * np.sign(z), z)
        graph, _ = graph.add_stroke(replace(contacts, points=np.column_stack([contacts.points[:, :2], past])))
    assert len(graph.faces) == 6
    assert drop_contradicted(graph) is graph


def test_a_face_that_is_poorly_known_is_open_though_it_was_touched():
    few = Contacts.of(
        [[-2, -2, 15], [2, -2, 15], [-2, 2, 15.0], [2, 2, 15], [0, 0, 15]], sigma=0.05, normal_sigma=0.1
    )
    poor = graph_of(*(side(a, s) for a in range(3) for s in (-1.0, 1.0) if (a, s) != (2, 1.0)), few)
    frontier = Frontier(poor.faces, BOX)
    left = frontier.doubtful()
    assert len(left.points) > 0
    assert set(left.face.tolist()) == {poor.faces[-1].id}
    assert len(Frontier(CUBE.faces, BOX).doubtful().points) == 0


def test_a_doubtful_face_is_to_be_pressed_in_its_middle_and_not_on_its_rim():
    """A ball that rounds a cube's corners, felt at one of the eight."""
    rng = np.random.default_rng(8)
    way = np.array([1.0, 1.0, 1.0]) / np.sqrt(3.0) + 0.08 * rng.standard_normal((14, 3))
    way = way / np.linalg.norm(way, axis=1, keepdims=True)
    corners = graph_of(
        *(side(a, s) for a in range(3) for s in (-1.0, 1.0)),
        Contacts.of(22.0 * way, way, sigma=0.03, normal_sigma=0.01),
    )
    frontier = Frontier(corners.faces, BOX)
    first = frontier.doubtful().points[0]
    inside = -np.sort(frontier.body.distances(frontier.predicted.points), axis=1)[:, -2]
    assert (
        -np.sort(frontier.body.distances(first[None])[0])[-2]
        > 0.8 * inside[frontier.predicted.face == 6].max()
    )
    assert (np.sign(first) < 0).any()


def test_the_deviation_of_a_surface_grows_away_from_its_contacts():
    face = graph_of(side(2, 1.0, half=15.0, n=20)).faces[0]
    near, far = distance_sigma(face.fit, np.array([[0.0, 0.0, 15.0], [60.0, 0.0, 15.0]]))
    assert near < 0.005
    assert far > 4 * near


def test_a_face_whose_contacts_all_lie_on_an_edge_is_dropped():
    rng = np.random.default_rng(5)
    along = rng.uniform(-14, 14, 20)
    rim = np.column_stack([along, np.full(20, 14.95), np.full(20, 14.95)])
    slanted = Contacts.of(rim, np.tile([0.0, np.sqrt(0.5), np.sqrt(0.5)], (20, 1)), 0.01, 0.01)
    graph, opened = CUBE.add_stroke(slanted)
    assert opened not in {face.id for face in CUBE.faces}
    assert {face.id for face in drop_edges(graph).faces} == {face.id for face in CUBE.faces}


def test_a_true_bevel_is_no_edge():
    rng = np.random.default_rng(6)
    along, down = rng.uniform(-14, 14, 30), rng.uniform(-2, 2, 30)
    bevel = np.column_stack([along, 13 + down, 13 - down])
    slanted = Contacts.of(bevel, np.tile([0.0, np.sqrt(0.5), np.sqrt(0.5)], (30, 1)), 0.01, 0.01)
    graph, _ = CUBE.add_stroke(slanted)
    assert len(drop_edges(graph).faces) == 7
