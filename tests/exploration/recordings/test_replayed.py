"""A recording stands in for an array and a stage, and a FlexiTac's bytes are a recording."""

import numpy as np
import pytest

from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.devices.wire import flexitac
from exploration.recordings.mcap import Recorder
from exploration.recordings.open import open_recording
from exploration.recordings.replayed import replayed
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube
from models.solid import Solid
from primitives import pose as se3
from primitives.errors import PalpateError

LTS = load_sensor("lts210")
MOUNT = se3.pose(se3.rotation_exp([0.2, -0.1, 0.4]), [5.0, -3.0, 20.0])


@pytest.fixture(scope="module")
def pressed(tmp_path_factory):
    """What a guard saw while it pressed on a block, and the episode of it."""
    above = se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 21.0]) @ se3.inverse(MOUNT)
    block = Solid.from_csg(Cube((40.0, 40.0, 40.0)))
    stage, arrays = simulate(
        block, [LTS], np.random.default_rng(0), start_pose=above, flange_from_sensor=[MOUNT]
    )
    guard = Guard(stage, arrays, [Calibration.nominal(LTS)])
    path = tmp_path_factory.mktemp("run") / "episode.mcap"
    with Recorder(path) as recorder:
        seen = [guard.move(np.array([1.0, 0.0, 8.0, 0.0, 0.0, 0.1])) for _ in range(40)]
        for one in seen:
            recorder.frame("lts210", one.frame, one.world_from_sensor, np.zeros(6))
    return seen, path


def test_a_guard_sees_in_a_recording_what_it_saw_when_it_was_made(pressed):
    seen, path = pressed
    stage, array = replayed(open_recording(path), flange_from_sensor=MOUNT)
    again = Guard(stage, [array], [Calibration.nominal(LTS)])
    assert array.period == pytest.approx(LTS.period)
    for before in seen:
        now = again.observe()
        assert now.time == pytest.approx(before.time, abs=1e-9)
        assert now.force == pytest.approx(before.force)
        np.testing.assert_array_equal(now.image.depth, before.image.depth)
        np.testing.assert_allclose(now.world_from_sensor, before.world_from_sensor, atol=1e-6)
    assert seen[-1].force > 1.0
    with pytest.raises(PalpateError, match="has ended"):
        again.observe()


def test_a_recording_goes_where_it_went_whatever_it_is_told(pressed):
    seen, path = pressed
    stage, array = replayed(open_recording(path))
    stage.go_to(np.eye(4))
    assert not stage.moving
    array.read()
    np.testing.assert_allclose(stage.pose(), seen[0].world_from_sensor, atol=1e-6)
    with pytest.raises(PalpateError, match="no pad 1"):
        replayed(open_recording(path), pad=1)


@pytest.mark.parametrize("told", [None, LTS], ids=["plain", "lts210"])
def test_a_flexitacs_bytes_are_read_from_wherever_they_begin(told, tmp_path):
    rng = np.random.default_rng(1)
    frames = rng.integers(0, 256, (30, 10, 16))
    data = b"".join(map(flexitac.encode, frames))
    (tmp_path / "log.bin").write_bytes(data[57:-20])
    recording = open_recording(tmp_path / "log.bin", told)
    got = np.array([item.frame.counts for item in recording.frames()])
    np.testing.assert_array_equal(got, frames[1:-1])
    assert any("no whole frame" in line for line in recording.warnings)
    _, array = replayed(recording)
    times = [array.read().time for _ in range(3)]
    assert np.allclose(np.diff(times), array.period)


def test_bytes_that_are_no_flexitacs_are_refused_in_one_line(tmp_path):
    (tmp_path / "log.bin").write_bytes(bytes(5000))
    for told in (None, LTS):
        with pytest.raises(PalpateError, match="--sensor") as caught:
            open_recording(tmp_path / "log.bin", told)
        assert "\n" not in str(caught.value)
