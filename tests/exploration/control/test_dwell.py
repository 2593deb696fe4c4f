"""A dwell's mean picture belongs to its mean pose, also where it begins while the stage still moves."""

import numpy as np

from exploration.control.dwell import dwell
from exploration.control.sighting import sight
from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.sensing.calibration import Calibration
from exploration.sensing.lines.hough import sure_lines
from exploration.sensing.spec import load_sensor
from models.csg import Cube
from models.solid import Solid
from primitives import pose as se3


def test_an_edge_seen_while_the_stage_brakes_lies_where_it_is():
    spec, solid = load_sensor("lts210"), Solid.from_csg(Cube((60.0, 60.0, 20.0)))
    high, far = solid.bounds[1, 2], solid.bounds[1, 0]
    start = se3.pose(np.diag([1.0, -1.0, -1.0]), [far - 8.0, 30.0 + solid.bounds[0, 1], high - 0.5])
    stage, arrays = simulate(solid, [spec], np.random.default_rng(1), start_pose=start, latency=0.03)
    guard = Guard(stage, arrays, [Calibration.nominal(spec)])
    for _ in range(30):
        guard.move(np.array([30.0, 0.0, 0.0, 0.0, 0.0, 0.0]))
    seen = dwell(guard, 16)
    moved = guard.world_from_sensor[0, 3] - seen.world_from_sensor[0, 3]
    (line,) = sure_lines(seen.image, 1)
    assert moved > 0.1  # the last pose would be that far off
    assert abs(sight(line, seen).point[0] - far) < 0.04
