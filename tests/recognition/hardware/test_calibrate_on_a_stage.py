"""The whole calibration by a stage, against the truth of a simulated unit that differs from its data sheet."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.devices.guard import Guard, GuardLimits
from exploration.devices.simulated import simulate
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.solid import Solid
from primitives import pose as se3
from recognition.hardware.artifact import Artifact, emulated_artifact
from recognition.hardware.calibrate import made_by
from recognition.hardware.presses import StagePresses
from recognition.hardware.saved_calibration import load, save

SHEET = load_sensor("lts210")
STIFFER, NARROWER = 1.12, 0.88


class AsToldMounted:
    """An array whose driver takes it to sit on the flange's middle."""

    flange_from_sensor = np.eye(4)

    def __init__(self, array):
        self._array = array

    def __getattr__(self, name):
        return getattr(self._array, name)


@pytest.fixture(scope="module")
def done():
    rng = np.random.default_rng(5)
    rubber = replace(
        SHEET.elastomer,
        stiffness=SHEET.elastomer.stiffness * STIFFER,
        spread=SHEET.elastomer.spread * NARROWER,
    )
    electronics = replace(
        SHEET.electronics, plateau=SHEET.electronics.plateau * STIFFER, gain_spread=0.1, dead=0.02
    )
    true = replace(SHEET, elastomer=rubber, electronics=electronics)
    mount = se3.pose(se3.rotation_exp(rng.normal(0.0, 0.03, 3)), rng.normal(0.0, 1.5, 3))
    above = se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 100.0])
    solid = Solid.from_csg(emulated_artifact())
    stage, (array,) = simulate(solid, [true], rng, start_pose=above, flange_from_sensor=[mount])
    unit = array._unit
    guard = Guard(stage, [AsToldMounted(array)], [Calibration.nominal(SHEET)], GuardLimits())
    presses = StagePresses(guard, SHEET, Artifact(), np.random.default_rng(5))
    made = made_by(presses, lambda line: None, SHEET, Artifact(), np.eye(4))
    return true, unit, mount, made


@pytest.mark.slow
def test_a_stage_calibrates_its_array_and_where_it_sits(done, tmp_path):
    true, unit, mount, made = done
    known, live = made.calibration, ~made.calibration.dead
    assert (known.dead == unit.dead).all()
    gain = known.gain / (unit.gain * SHEET.counts_per_pressure)
    assert np.sqrt(np.mean((gain[live] - 1.0) ** 2)) < 0.03
    assert known.spread == pytest.approx(true.elastomer.spread, rel=0.05)
    assert known.stiffness == pytest.approx(true.elastomer.stiffness, rel=0.05)
    off = se3.log(se3.inverse(mount) @ made.mount.flange_from_sensor)
    assert np.linalg.norm(made.mount.flange_from_sensor[:3, 3] - mount[:3, 3]) < 0.1
    assert np.linalg.norm(off[3:]) < np.radians(0.2)

    save(known, made.mount, tmp_path / "c.toml")
    again, where = load(tmp_path / "c.toml")
    assert np.allclose(again.gain, known.gain)
    assert np.allclose(where, made.mount.flange_from_sensor)
