from dataclasses import replace

import numpy as np
import pytest

from exploration.sensing.calibration import Calibration, correct
from exploration.sensing.frame import TaxelFrame
from exploration.sensing.physics.electronics import (
    Memory,
    converted,
    draw_unit,
    hysteresis,
    read_out,
)
from exploration.sensing.spec import load_sensor, sensor_from_toml
from primitives.errors import PalpateError

LTS = load_sensor("lts210")
BARE = """
array = { rows = 4, columns = 5, pitch = [2.0, 2.5] }
elastomer = { stiffness = 0.1, thickness = 2.0 }
housing = { size = [12, 12, 30], proud = 2.0 }
"""


def with_electronics(**changes):
    return replace(LTS, electronics=replace(LTS.electronics, **{"noise": 0.0, **changes}))


def counts_of(spec, depth, seed=0):
    rng = np.random.default_rng(seed)
    pressure = np.full(spec.array.shape, depth * spec.elastomer.stiffness)
    return read_out(pressure, spec, draw_unit(spec, rng), Memory.fresh(spec), 0.005, rng)[0]


def test_nominal_press_reads_the_plateau():
    e = LTS.electronics
    assert (counts_of(with_electronics(), LTS.press_depth) == e.offset + e.plateau).all()


def test_counts_are_whole_and_saturate():
    spec = with_electronics()
    assert (counts_of(spec, 50.0) == spec.electronics.full_scale).all()
    noisy = counts_of(with_electronics(noise=0.1), 0.2)
    assert (noisy == np.rint(noisy)).all()
    full = spec.electronics.full_scale
    assert [converted(value, full) for value in (-3.0, 1.4, 999.0)] == [0.0, 1.0, 255.0]


def test_without_a_converter_counts_are_neither_whole_nor_bounded():
    spec = with_electronics(bits=0)
    e = spec.electronics
    expected = e.offset + e.plateau * 0.123 / spec.press_depth
    assert counts_of(spec, 0.123) == pytest.approx(np.full(spec.array.shape, expected), rel=1e-12)
    assert counts_of(spec, 50.0).min() > 255
    assert converted(1.4, e.full_scale) == 1.4


def test_every_stage_is_absent_unless_a_preset_asks_for_it():
    e = sensor_from_toml(BARE, "bare").electronics
    assert (e.bits, e.noise, e.gain_spread, e.dead, e.drift, e.scan) == (0,) * 6


def test_noise_is_a_fraction_of_the_plateau():
    spec = with_electronics(noise=0.05)
    many = np.stack([counts_of(spec, 0.5, seed) for seed in range(60)])
    assert many.std() == pytest.approx(0.05 * spec.electronics.plateau, rel=0.03)


def test_dead_taxels_read_the_offset_and_gain_spreads():
    spec = with_electronics(dead=0.3, gain_spread=0.1)
    counts = counts_of(spec, 0.5)
    dead = counts == spec.electronics.offset
    assert 0.15 < dead.mean() < 0.45
    live = (counts[~dead] - spec.electronics.offset) / spec.electronics.plateau
    assert live.std() == pytest.approx(0.1, rel=0.25)


def test_hysteresis_lags_on_the_way_down_as_much_as_on_the_way_up():
    path = [0.0]
    for signal in [*np.linspace(0, 100, 50), *np.linspace(100, 0, 50)]:
        path.append(hysteresis(signal, path[-1], 4.0))
    path = path[1:]
    up, down = np.array(path[:50]), np.array(path[50:])[::-1]
    assert down[20] - up[20] == pytest.approx(8.0)
    assert min(path) >= 0.0


def test_drift_grows_with_the_root_of_time():
    spec, rng = with_electronics(drift=0.01), np.random.default_rng(0)
    unit, memory = draw_unit(spec, rng), Memory.fresh(spec)
    spread = []
    for _ in range(400):
        _, memory = read_out(np.zeros(spec.array.shape), spec, unit, memory, 0.25, rng)
        spread.append(float(memory.drift.std()))
    assert spread[99] == pytest.approx(0.01 * spec.electronics.plateau * 5.0, rel=0.2)
    assert spread[399] == pytest.approx(2.0 * spread[99], rel=0.3)


def test_absent_stages_draw_nothing():
    spec, rng = with_electronics(), np.random.default_rng(0)
    unit = draw_unit(spec, rng)
    before = rng.bit_generator.state
    read_out(np.zeros(spec.array.shape), spec, unit, Memory.fresh(spec), 0.005, rng)
    assert rng.bit_generator.state == before


def test_correct_undoes_the_electronics():
    image = correct(
        TaxelFrame(counts_of(with_electronics(), 0.4), 1.5, 0), Calibration.nominal(LTS), LTS.array
    )
    assert image.depth == pytest.approx(np.full((10, 16), 0.4), abs=0.5 / 120 / 2 + 1e-9)
    assert image.time == 1.5
    assert (image.sigma > 0).all()


def test_dead_taxels_known_to_the_calibration_have_no_weight():
    nominal = Calibration.nominal(LTS)
    dead = np.zeros(LTS.array.shape, bool)
    dead[3, 4] = True
    image = correct(TaxelFrame(np.full((10, 16), 90.0), 0.0, 0), replace(nominal, dead=dead), LTS.array)
    assert np.isinf(image.sigma[3, 4])
    assert image.depth[3, 4] == 0.0


def test_calibration_of_another_array_is_refused():
    with pytest.raises(PalpateError, match="differ in shape"):
        correct(TaxelFrame(np.zeros((4, 4)), 0.0, 0), Calibration.nominal(LTS), LTS.array)
