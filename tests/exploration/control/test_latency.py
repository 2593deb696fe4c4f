"""Latency is measured from motion in free air, within a millisecond or two, through encoder noise."""

import numpy as np
import pytest

from exploration.control.latency import measure_latency
from exploration.devices.guard import Guard
from exploration.devices.simulated import PoseNoise, simulate
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube
from models.solid import Solid
from primitives.pose import pose


@pytest.mark.parametrize("latency", [0.0, 0.008, 0.02, 0.05])
def test_latency_is_measured_through_encoder_noise(latency: float) -> None:
    spec = load_sensor("lts210")
    solid = Solid.from_csg(Cube((40.0, 40.0, 40.0)))
    above = pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 80.0])
    stage, arrays = simulate(
        solid, [spec], np.random.default_rng(3), pose_noise=PoseNoise(0.05), start_pose=above, latency=latency
    )
    found = measure_latency(Guard(stage, arrays, [Calibration.nominal(spec)]))
    assert found.seconds == pytest.approx(latency, abs=max(0.0015, 4.0 * found.sigma))
    assert found.sigma < 0.001
