import numpy as np
import pytest

from exploration.recordings.open import open_recording
from exploration.recordings.untouched import at_rest, calibration_at_rest
from exploration.sensing.spec import load_sensor

SHAPE = (10, 16)
OFFSETS = np.random.default_rng(9).uniform(20, 60, SHAPE)


def pressed(count, noise, rest=30, rng=None):
    """A press that comes on after `rest` frames, on taxels whose zeros differ."""
    rng = rng or np.random.default_rng(1)
    x, y = np.meshgrid(np.arange(16), np.arange(10))
    dome = np.exp(-((x - 8) ** 2 + (y - 4) ** 2) / 12)
    level = np.clip((np.arange(count) - rest) / 20, 0, 1)[:, None, None]
    return np.round(OFFSETS + 150 * level * dome + noise * rng.standard_normal((count, *SHAPE)))


def rest_of(path, stack, spec=None):
    np.save(path / "a.npy", stack)
    recording = open_recording(path / "a.npy", spec)
    return at_rest(recording)[0], recording.pads[0]


@pytest.mark.parametrize("noise", [0.0, 1.0, 4.0])
def test_zero_and_noise_come_from_the_recording(noise, tmp_path):
    rest, _ = rest_of(tmp_path, pressed(120, noise))
    expected = np.hypot(noise, np.sqrt(1 / 12))
    assert rest.noise == pytest.approx(expected, rel=0.15, abs=0.1)
    assert np.abs(rest.zero - np.round(OFFSETS)).max() < 1 + 1.5 * noise
    assert 75 < rest.plateau < 160


def test_a_recording_that_begins_in_contact_finds_its_zero_later(tmp_path):
    rest, _ = rest_of(tmp_path, pressed(120, 1.0)[::-1])
    assert np.abs(rest.zero - OFFSETS).max() < 5


def test_the_data_sheet_stands_in_where_no_frame_is_untouched(tmp_path):
    spec = load_sensor("lts210")
    rng = np.random.default_rng(4)
    unrelated = np.round(10 + 120 * rng.random((40, 1, 1)) + rng.standard_normal((40, *SHAPE)))
    rest, pad = rest_of(tmp_path, unrelated, spec)
    np.testing.assert_array_equal(rest.zero, np.full(SHAPE, spec.electronics.offset))
    calibration = calibration_at_rest(pad, rest)
    assert calibration.spread == spec.elastomer.spread
    assert rest.noise == pytest.approx(1.23, abs=0.05)


def test_absent_and_absurd_values_leave_it_standing(tmp_path):
    stack = pressed(60, 1.0)
    stack[10, 3, 3], stack[20, 0, 0], stack[30] = np.nan, 1e300, np.inf
    rest, _ = rest_of(tmp_path, stack)
    assert np.isfinite(rest.zero).all()
    assert rest.noise == pytest.approx(1.04, rel=0.2)


@pytest.mark.parametrize(
    "stack", [np.full((4, 5, 5), np.nan), np.zeros((1, 1, 1)), np.full((3, 1, 2), 1e300)]
)
def test_what_tells_nothing_gives_a_usable_rest(stack, tmp_path):
    rest, pad = rest_of(tmp_path, stack)
    assert np.isfinite(rest.zero).all()
    assert rest.noise > 0
    assert (calibration_at_rest(pad, rest).gain > 0).all()


def test_a_ceiling_and_a_threshold_are_seen_in_the_recording_itself(tmp_path):
    rng = np.random.default_rng(3)
    felt = pressed(120, 4.0, rng=rng) - OFFSETS
    rest, pad = rest_of(tmp_path, np.round(np.where(felt < 25.0, 0.0, np.minimum(felt, 110.0))))
    assert 105.0 < rest.ceiling <= 110.0
    assert 10.0 < rest.threshold < 40.0
    calibration = calibration_at_rest(pad, rest)
    assert (calibration.full_scale, calibration.threshold) == (rest.ceiling, rest.threshold)


def test_a_free_recording_has_neither(tmp_path):
    rest, _ = rest_of(tmp_path, pressed(120, 2.0))
    assert rest.ceiling == np.inf
    assert rest.threshold == 0.0
