"""The pad travels round a convex object, from in front of what it came to last."""

import numpy as np

from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.touching.pad import Pad
from exploration.planning.ways.transit import Support
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube
from models.solid import Solid
from primitives import pose as se3

X, _, Z = np.eye(3)


def test_a_pad_that_met_nothing_goes_on_round_the_object_from_where_it_is():
    """From under a block to over it, and back without having lain there."""
    spec, start = load_sensor("lts210"), se3.pose(se3.frame_along(Z), [0.0, 0.0, -20.0])
    block = Solid.from_csg(Cube((80.0, 60.0, 20.0)))
    stage, arrays = simulate(block, [spec], np.random.default_rng(0), noise=0.05, start_pose=start)
    guard = Guard(stage, arrays, [Calibration.nominal(arrays[0].spec)])
    pad = Pad(guard, np.array([-200.0, -200.0, -200.0, 200.0, 200.0, 200.0]), lambda kind, detail: None)
    top, bottom = Support(10.0 * Z, Z), Support(-10.0 * Z, -Z)
    pad.here = bottom
    for support in (top, bottom):
        target = se3.pose(pad.attitude(support.normal, X), support.point)
        pad.travel(target, support, 5.0)
        assert np.allclose(guard.world_from_sensor[:3, 3], 1.5 * support.point, atol=0.1)
