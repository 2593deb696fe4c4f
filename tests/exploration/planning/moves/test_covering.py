"""Where a pad comes down on surface that was only predicted."""

from types import SimpleNamespace

import numpy as np

from exploration.planning.known.touched import Touched
from exploration.planning.moves.covering import Covering
from exploration.planning.open.frontier import Predicted
from exploration.planning.touching.findings import Attempts, ExplorerConfig
from exploration.planning.ways.transit import Support

Z = np.array([0.0, 0.0, 1.0])


def test_who_met_nothing_goes_on_next_to_what_was_touched_and_not_farther_out():
    points = np.array([[x, 0.0, 0.0] for x in (12.0, 24.0, 36.0, 48.0)])
    missing = Predicted(points, np.tile(Z, (4, 1)), np.zeros(4, dtype=np.int64))
    went: list[float] = []
    pad = SimpleNamespace(covered=Touched(), guard=SimpleNamespace(world_from_sensor=np.eye(4)))
    pad.here = Support(np.array([50.0, 0.0, 0.0]), Z)  # beyond the end, whence 48 is nearest
    pad.covered.add(np.zeros((1, 3)), Support(np.zeros(3), Z))

    def travel(target, far, standoff):
        went.append(float(target[0, 3]))
        pad.here = far

    pad.travel, pad.touch = travel, lambda *args, **kwargs: went[-1] < 20.0
    study = SimpleNamespace(pad=pad, found=SimpleNamespace(), face_here=lambda: 0)
    covering = Covering(study, Attempts(3), ExplorerConfig())
    assert covering.cover(missing, None)[0] is None
    assert covering.cover(missing, None)[0] == 0
    assert went == [48.0, 12.0]
