"""A simulated unit is calibrated by what it felt, and only where its cells differ."""

import numpy as np
import pytest

from exploration.devices.simulated import simulate
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Sphere
from models.solid import Solid
from recognition.running.bench_calibration import calibrated


def unit(name):
    spec = load_sensor(name)
    _, (array,) = simulate(Solid.from_csg(Sphere(20.0)), [spec], np.random.default_rng(3))
    return spec, array


@pytest.mark.parametrize("name", ["magnetic", "conductive_elastomer"])
def test_presses_on_a_flat_tell_how_the_cells_differ(name):
    spec, array = unit(name)
    found = calibrated(array, np.random.default_rng(4))
    live = ~found.dead & ~array._unit.dead
    true, told = array._unit.gain[live], (found.gain / Calibration.nominal(spec).gain)[live]
    left = np.std(told / told.mean() - true / true.mean())
    assert left < 0.25 * np.std(true / true.mean())
    assert (found.dead == array._unit.dead).all()


def test_even_cells_are_as_the_data_sheet_has_them():
    spec, array = unit("lts210")
    found, sheet = calibrated(array, np.random.default_rng(4)), Calibration.nominal(spec)
    assert (found.gain == sheet.gain).all()
    assert found.noise == sheet.noise
