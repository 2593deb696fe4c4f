"""Edges that there is no room to roll over."""

from types import SimpleNamespace

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.moves.crossing import Crossing
from exploration.planning.open.frontier import Predicted
from exploration.planning.touching.findings import ExplorerConfig, Findings
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, PatchGraph, ranked_face

X, Y, Z = np.eye(3)


def barred():
    """What was found, and a crossing that a table below leaves no room for."""
    found = Findings()
    told = SimpleNamespace(leads_past=lambda pose: pose[2, 3] > 15.0)
    pad = SimpleNamespace(told=told, size=(28.8, 18.0), attitude=lambda normal, along: np.eye(3))
    return found, Crossing(SimpleNamespace(pad=pad, found=found, seen=[]), ExplorerConfig())


def test_what_is_predicted_past_an_edge_that_cannot_be_crossed_is_not_gone_for():
    found, crossing = barred()
    edge = Sighting(np.array([20.0, 0.0, 5.0]), Y, X, Z, 0.05, 12.0)
    face, note = crossing.cross(edge, 3)
    assert face is None
    assert "no room" in note
    assert found.barred == [(edge, 3)]
    points = np.array([[15.0, 0.0, 5.0], [26.0, 5.0, 5.0], [26.0, 5.0, 5.0], [26.0, 40.0, 5.0]])
    ids = np.array([3, 3, 4, 3])
    left = crossing.this_side(Predicted(points, np.tile(Z, (4, 1)), ids))
    assert left.points.tolist() == points[[0, 2, 3]].tolist()
    assert left.face.tolist() == [3, 4, 3]


def test_a_round_face_is_not_past_its_square_end_and_goes_on_past_an_edge_along_its_axis():
    found, crossing = barred()
    turn = np.linspace(0.0, 6.0, 24)
    ways = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(24)])
    lots = Contacts.of(15.0 * ways + np.outer(np.linspace(-20.0, 18.0, 24), Z), ways, 0.02, 0.02)
    bar = ranked_face(5, lots, MergeOptions())
    assert bar.fit.kind == "cylinder"
    found.graph = PatchGraph((bar,), ())
    skewed = np.array([0.0, 0.3, np.sqrt(0.91)])
    end = Sighting(np.array([15.0, 0.0, 20.0]), np.cross(X, skewed), skewed, X, 0.1, 8.0)
    flat = Sighting(np.array([15.0, 0.0, 0.0]), Z, Y, X, 0.1, 20.0)
    points = np.array([[0.0, 15.0, 30.0], [0.0, 15.0, 16.0], [0.0, -15.0, 0.0]])
    predicted = Predicted(points, points / 15.0, np.full(3, 5))
    found.barred = [(end, 5), (flat, 5)]
    assert crossing.this_side(predicted).points.tolist() == points[1:].tolist()
