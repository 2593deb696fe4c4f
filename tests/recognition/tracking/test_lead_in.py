"""What was followed before an outline that closed is told apart from it."""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np

from exploration.control.sighting import Sighting
from exploration.control.track_outline import TrackedOutline
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from primitives.arrays import frozen
from primitives.evidence import EdgeTrace
from recognition.tracking.edge import TrackEdgeConfig, _felt_behind

WAY = [(0, -30), (0, 0), (60, 0), (60, 40), (0, 40), (0, 0)]  # the first leads to the corner of a rectangle


def straight(begin, end):
    points = np.linspace([*begin, 0.0], [*end, 0.0], 40)
    along = np.tile((points[-1] - points[0]) / np.linalg.norm(points[-1] - points[0]), (40, 1))
    up, sigma = np.tile([0.0, 0.0, 1.0], (40, 1)), np.full(40, 0.02)
    return EdgeTrace(frozen(points), frozen(along), frozen(up), frozen(sigma), False, 0, 0)


def test_the_edges_that_lead_to_a_loop_are_none_of_its_edges_and_the_run_says_so():
    traces = tuple(straight(a, b) for a, b in pairwise(WAY))
    nowhere = np.empty((0, 3))
    outline = TrackedOutline(traces, nowhere, "closed", 230.0, (1.0,), (1.0,), (None,) * 5, None, 1)
    spec = load_sensor("lts210")
    guard = SimpleNamespace(
        calibrations=[Calibration.nominal(spec)], active=0, sensor=SimpleNamespace(array=spec.array)
    )
    run = SimpleNamespace(guard=guard, warnings=[])
    edge = Sighting(traces[0].points[0], *np.eye(3)[[1, 0, 2]], 0.02, 30.0)
    track = _felt_behind(run, outline, edge, 0.5, lambda what: None, TrackEdgeConfig(dihedrals=0))
    found = track.found()
    assert [edge["length_mm"] for edge in found["edges"]] == [60.0, 40.0, 60.0, 40.0]
    assert [edge["length_mm"] for edge in found["lead_in"]] == [30.0]
    assert len(track.points) == 160
    assert run.warnings == ["the first 30 mm that were followed are no part of the outline that closed"]
