from dataclasses import replace

import numpy as np
import pytest

from exploration.sensing.calibration import Calibration, correct
from exploration.sensing.capacitive import capacitive
from exploration.sensing.curve import STRAIGHT, ParallelPlates, Sampled
from exploration.sensing.frame import TaxelFrame
from exploration.sensing.lines.hough import find_lines
from exploration.sensing.lines.line import normalized
from exploration.sensing.physics.capacitor import transducer
from exploration.sensing.physics.electronics import Memory, Unit, read_out
from exploration.sensing.physics.gap import indentation
from exploration.sensing.response import rubber
from exploration.sensing.spec import load_sensor
from models.csg import Cube
from models.solid import Solid
from primitives.errors import PalpateError
from primitives.pose import inverse, pose, rotation_exp, transform_points

SPEC = load_sensor("capacitive")
DOWN = np.diag([1.0, -1.0, -1.0])
EDGES = 60


@pytest.fixture(scope="module")
def edges():
    """Ray-cast presses over the edge of a block, as counts, with each edge's true angle and offset."""
    rng = np.random.default_rng(0)
    block = Solid.from_csg(Cube((100.0, 400.0, 100.0)))
    unit = Unit(np.ones(SPEC.array.shape), np.zeros(SPEC.array.shape, dtype=bool))
    electronics = replace(SPEC.electronics, drift=0.0)
    spec = replace(
        SPEC, electronics=electronics, elastomer=replace(SPEC.elastomer, hysteresis=0.0, margin=8.0)
    )
    taxels, out = transducer(spec), []
    for _ in range(EDGES):
        turn, offset = rng.uniform(-np.pi, np.pi), rng.uniform(-0.2, 0.2) * spec.array.size[1]
        sensor = pose(rotation_exp([0.0, 0.0, turn]) @ DOWN, [50.0 + offset, 0.0, 50.0 - spec.press_depth])
        felt = indentation(block, sensor, spec)
        counts, _ = read_out(
            taxels.press(felt.modes, felt.partial), spec, unit, Memory.fresh(spec), 0.01, rng
        )
        ends = transform_points(inverse(sensor), np.array([[50.0, -1.0, 50.0], [50.0, 1.0, 50.0]]))[:, :2]
        angle = float(np.arctan2(*(ends[1] - ends[0])[::-1]))
        rho = float(ends[0] @ [-np.sin(angle), np.cos(angle)])
        out.append((TaxelFrame(counts, 0.0, 0), *normalized(angle, rho, 1)[:2]))
    return spec, out


def _misses(calibration, edges):
    """(n,) [mm] of the offsets, into the material."""
    spec, frames = edges
    out = []
    for frame, angle, offset in frames:
        lines = find_lines(correct(frame, calibration, spec.array))
        if lines and abs(np.sin(lines[0].angle - angle)) < 0.05:
            sign = 1.0 if abs(lines[0].angle - angle) < 1.0 else -1.0
            out.append((lines[0].offset - sign * offset) * lines[0].material_side)
    assert len(out) >= 0.9 * len(frames)
    return np.array(out)


def test_an_edge_of_a_capacitive_array_is_found_without_bias(edges):
    spec, _ = edges
    calibration = Calibration.nominal(spec)
    miss = _misses(calibration, edges)
    assert abs(miss.mean()) < 0.02 * spec.array.pitch[0] + 3 * miss.std() / np.sqrt(len(miss))
    assert abs(miss.mean()) < 0.05


def test_taken_for_rubber_over_pressure_taxels_it_would_lie_elsewhere(edges):
    spec, _ = edges
    known = Calibration.nominal(spec)
    mistaken = replace(known, curve=STRAIGHT, response=None)
    assert abs(_misses(mistaken, edges).mean()) > 3 * abs(_misses(known, edges).mean())


def test_a_full_press_reads_as_deep_as_it_is(edges):
    spec, _ = edges
    block = Solid.from_csg(Cube((400.0, 400.0, 100.0)))
    for depth in (0.2, 0.5, 1.0):
        felt = indentation(block, pose(DOWN, [0.0, 0.0, 50.0 - depth]), spec)
        signal = transducer(spec).press(felt.modes, felt.partial) * spec.counts_per_pressure
        counts = TaxelFrame(signal + spec.electronics.offset, 0.0, 0)
        assert correct(counts, Calibration.nominal(spec), spec.array).depth == pytest.approx(depth, abs=1e-3)


def test_with_endless_gap_and_no_fringe_the_response_is_that_of_rubber():
    plain, limit = rubber(1.8, (1.8, 1.8)), capacitive(1.8, 0.0, (1.8, 1.8), 1e9, 0.5)
    u = np.linspace(-4.0, 4.0, 33) * 1.87
    assert limit.variance == pytest.approx(plain.variance)
    assert limit.edge(u, 1.87) == pytest.approx(plain.edge(u, 1.87), abs=3e-3)


@pytest.mark.parametrize(
    "curve", [ParallelPlates(2.0), Sampled.of([0.0, 0.5, 1.5], [0.0, 0.4, 0.9]), STRAIGHT]
)
def test_a_curve_undoes_itself_and_knows_its_slope(curve):
    signal = np.array([0.05, 0.3, 0.8, 1.2])
    assert curve.signal(curve.depth(signal)) == pytest.approx(signal)
    rise = (curve.depth(signal + 1e-6) - curve.depth(signal - 1e-6)) / 2e-6
    assert curve.slope(signal) == pytest.approx(rise, rel=1e-4)


def test_a_sampled_curve_that_falls_is_refused():
    with pytest.raises(PalpateError, match="both rising"):
        Sampled.of([0.0, 1.0, 0.5], [0.0, 1.0, 2.0])
