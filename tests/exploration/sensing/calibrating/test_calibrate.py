from dataclasses import replace

import numpy as np
import pytest

from exploration.sensing.calibrating.calibrate import CalibrationFrames, calibrate
from exploration.sensing.calibration import Calibration, correct
from primitives.errors import PalpateError


@pytest.fixture(scope="module", params=["lts210", "square32", "dsa"])
def done(request, specimen):
    made = specimen(request.param, 3)
    frames = made.frames()
    return made, frames, calibrate(frames, Calibration.nominal(made.sheet), made.spec.array)


def test_gains_are_known_to_three_percent_and_to_their_sigma(done):
    made, _, known = done
    live = ~known.dead
    truth = made.unit.gain * made.spec.counts_per_pressure
    error = (known.gain / truth - 1.0)[live]
    assert np.sqrt(np.mean(error**2)) < 0.03
    assert np.quantile(np.abs(error - np.median(error)) / known.gain_sigma[live], 0.9) < 4.0


def test_dead_taxels_are_found_and_no_other(done):
    made, _, known = done
    assert (known.dead == made.unit.dead).all()


def test_spread_and_stiffness_are_known_to_five_percent_and_to_their_sigma(done):
    made, _, known = done
    rubber = made.spec.elastomer
    assert known.spread == pytest.approx(rubber.spread, rel=0.05)
    assert known.stiffness == pytest.approx(rubber.stiffness, rel=0.05)
    assert 0 < known.spread_sigma < 0.05 * rubber.spread
    assert 0 < known.stiffness_sigma < 0.05 * rubber.stiffness


def test_a_flat_then_reads_flat_and_as_deep_as_it_is(done):
    made, frames, known = done
    image = correct(frames.flats[0][0], known, made.spec.array)
    live = np.isfinite(image.sigma)
    x, y = np.meshgrid(image.array.x, image.array.y)
    basis = np.stack([np.ones(live.sum()), x[live], y[live]], axis=1)
    plane, *_ = np.linalg.lstsq(
        basis / image.sigma[live][:, None], image.depth[live] / image.sigma[live], rcond=None
    )
    residual = (image.depth[live] - basis @ plane) / image.sigma[live]
    assert np.sqrt(np.mean(residual**2)) < 2.0


def test_what_is_not_recorded_stays_as_the_data_sheet_says(specimen):
    made = specimen("lts210", 0)
    nominal = Calibration.nominal(made.sheet)
    known = calibrate(CalibrationFrames(made.frames().air), nominal, made.spec.array)
    assert known.zero == pytest.approx(np.full(known.zero.shape, 10.0), abs=1.0)
    assert (known.gain == nominal.gain).all()
    assert (known.spread, known.stiffness) == (nominal.spread, nominal.stiffness)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda f: replace(f, air=f.air[:3]), "too few"),
        (lambda f: replace(f, flats=[f.air, f.air]), "no deeper than the noise"),
        (lambda f: replace(f, flats=[f.flats[0]]), "2 presses"),
        (lambda f: replace(f, edges=[f.air] * 4), "0 of 4 presses show a straight edge"),
        (lambda f: replace(f, steps=[f.air]), "no press shows the step"),
        (lambda f: replace(f, step_height=0.0), "height must be positive"),
    ],
)
def test_frames_that_do_not_tell_are_refused_with_what_to_do(specimen, change, says):
    made = specimen("lts210", 1)
    with pytest.raises(PalpateError, match=says) as caught:
        calibrate(change(made.frames()), Calibration.nominal(made.sheet), made.spec.array)
    assert "\n" not in str(caught.value)
