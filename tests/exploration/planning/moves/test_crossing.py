"""Edges that there is no room to roll over."""

from types import SimpleNamespace

import numpy as np

from exploration.control.sighting import Sighting
from exploration.planning.moves.crossing import Crossing
from exploration.planning.open.frontier import Predicted
from exploration.planning.touching.findings import ExplorerConfig, Findings

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
