"""The zero that creeps, renewed in free air."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.control.procedures.tare import tare
from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube
from models.solid import Solid
from primitives import pose as se3


def in_air(drift):
    spec = load_sensor("lts210")
    spec = replace(spec, electronics=replace(spec.electronics, drift=drift))
    rng = np.random.default_rng(0)
    above = se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 200.0])
    stage, arrays = simulate(Solid.from_csg(Cube((40, 40, 40))), [spec], rng, noise=0.02, start_pose=above)
    guard = Guard(stage, arrays, [Calibration.nominal(arrays[0].spec)])
    for _ in range(600):
        guard.hold()
    return guard


def rms(guard):
    images = [guard.hold().image for _ in range(20)]
    depth = np.mean([image.depth for image in images], axis=0)
    return float(np.sqrt(np.mean(depth**2)) / np.median(images[0].sigma))


def test_a_crept_zero_is_renewed():
    guard = in_air(drift=0.05)
    before = rms(guard)
    assert before > 1.0
    assert tare(guard)
    assert rms(guard) < 0.5 * before


def test_a_quiet_sensor_keeps_its_zero():
    guard = in_air(drift=0.0)
    zero = guard.calibrations[0].zero
    assert not tare(guard)
    assert guard.calibrations[0].zero is zero


@pytest.mark.parametrize("spread", [0.0, 0.05])
def test_gains_known_to_a_spread_make_deep_taxels_less_sure(spread):
    from exploration.sensing.calibration import correct
    from exploration.sensing.frame import TaxelFrame

    spec = load_sensor("lts210")
    spec = replace(spec, electronics=replace(spec.electronics, gain_spread=spread))
    calibration = Calibration.nominal(spec)
    counts = np.broadcast_to(
        calibration.zero + 0.5 * calibration.gain * calibration.stiffness, spec.array.shape
    )
    pressed = correct(TaxelFrame(counts, 0.0, 0), calibration, spec.array)
    free = correct(TaxelFrame(calibration.zero, 0.0, 0), calibration, spec.array)
    assert np.allclose(pressed.sigma**2 - free.sigma**2, (spread * 0.5) ** 2)
