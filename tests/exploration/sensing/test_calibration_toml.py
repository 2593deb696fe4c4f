from dataclasses import replace

import numpy as np
import pytest

from exploration.sensing.calibration import Calibration
from exploration.sensing.calibration_toml import calibration_from_toml, calibration_to_toml, load_calibration
from exploration.sensing.curve import Sampled
from exploration.sensing.spec import load_sensor, sensor_names
from primitives.errors import PalpateError


def _same(a, b):
    assert a.zero == pytest.approx(b.zero)
    assert a.gain == pytest.approx(b.gain)
    assert (a.dead == b.dead).all()
    assert np.asarray(a.gain_sigma) == pytest.approx(np.asarray(b.gain_sigma))
    for name in ("spread", "stiffness", "noise", "margin", "spread_sigma", "stiffness_sigma", "full_scale"):
        assert getattr(a, name) == getattr(b, name)
    assert a.curve.depth(np.array([0.1, 0.9])) == pytest.approx(b.curve.depth(np.array([0.1, 0.9])))
    assert (a.response is None) == (b.response is None)
    if a.response and b.response:
        assert a.response.table == pytest.approx(b.response.table, abs=1e-6)


@pytest.mark.parametrize("name", sensor_names())
def test_a_calibration_survives_its_file(name, tmp_path):
    known = Calibration.nominal(load_sensor(name))
    _same(calibration_from_toml(calibration_to_toml(known)), known)


def test_maps_sigmas_and_a_measured_curve_survive_too(tmp_path):
    known = Calibration.nominal(load_sensor("fingertip"))
    rng = np.random.default_rng(0)
    full = replace(
        known,
        gain=known.gain * rng.uniform(0.9, 1.1, (4, 4)),
        gain_sigma=rng.uniform(0.0, 0.1, (4, 4)),
        dead=rng.random((4, 4)) < 0.3,
        spread_sigma=0.01,
        stiffness_sigma=0.002,
        curve=Sampled.of([0.0, 0.5, 1.2], [0.0, 0.5, 1.0]),
    )
    path = tmp_path / "mine.toml"
    path.write_text(calibration_to_toml(full), encoding="utf-8")
    _same(load_calibration(path), full)


@pytest.mark.parametrize(
    ("wrong", "right", "says"),
    [
        ("stiffness = 0.15", "", "missing stiffness"),
        ("stiffness = 0.15", "stiffness = -1", "must be positive"),
        ("stiffness = 0.15", "stifness = 0.15", "unknown key"),
        ("zero = [[100.0, ", "zero = [[", "a value is not what it must be"),
        ("stiffness = 0.15", "stiffness = [", "not valid TOML"),
    ],
)
def test_a_broken_file_is_answered_in_one_line(wrong, right, says):
    text = calibration_to_toml(Calibration.nominal(load_sensor("fingertip")))
    assert wrong in text
    with pytest.raises(PalpateError, match=says) as caught:
        calibration_from_toml(text.replace(wrong, right, 1))
    assert "\n" not in str(caught.value).strip()
