"""The whole calibration by a stage, against the truth of a simulated unit that differs from its data sheet."""

from pathlib import Path

import numpy as np
import pytest

from recognition.hardware.saved_calibration import load, save, told_in

BENCH = Path(__file__).parents[2] / "bench"


@pytest.mark.slow
def test_a_stage_calibrates_its_array_and_where_it_sits(monkeypatch, tmp_path):
    monkeypatch.syspath_prepend(str(BENCH))
    from devices.calibrated_unit import calibrated_unit

    done = calibrated_unit(5)
    known, mount = done.made.calibration, done.made.mount
    assert (known.dead == done.unit.dead).all()
    off = done.errors(known, mount.flange_from_sensor)
    assert off["gains"] < 0.03
    assert max(off["spread"], off["stiffness"]) < 0.05
    assert off["place_mm"] < min(0.1, 5.0 * mount.translation_sigma)
    assert off["turn_deg"] < min(0.2, 5.0 * np.degrees(mount.rotation_sigma))
    assert off["stiffness"] < 5.0 * known.stiffness_sigma / known.stiffness

    save(known, mount, tmp_path / "c.toml")
    again, where = load(tmp_path / "c.toml")
    assert np.allclose(again.gain, known.gain)
    assert np.allclose(where, mount.flange_from_sensor)


def test_a_config_names_its_newest_calibration_and_keeps_the_rest(tmp_path):
    config = tmp_path / "rig.toml"
    config.write_text('[array]\nport = "a"  # left\n\n[stage]\nport = "b"\n')
    for name in ("one.toml", "two.toml"):
        told_in(config, tmp_path / name)
    text = config.read_text()
    assert text.count("calibration = ") == 1
    assert text.startswith('[array]\ncalibration = "two.toml"\nport = "a"  # left\n')
