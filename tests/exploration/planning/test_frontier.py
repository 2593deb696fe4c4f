import numpy as np

from exploration.planning.consistency import drop_contradicted
from exploration.planning.frontier import Frontier
from exploration.planning.touched import Touched
from exploration.planning.transit import Support
from primitives.evidence import Contacts, EdgeTrace
from primitives.patch_graph import PatchGraph

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
