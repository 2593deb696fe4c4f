"""What a page makes of a recording."""

from types import SimpleNamespace

import numpy as np

from exploration.devices.guard import Observation
from exploration.recordings.mcap import Recorder
from exploration.sensing.frame import TactileImage, TaxelArray, TaxelFrame
from exploration.sensing.load import load_of
from exploration.sensing.spec import load_sensor
from primitives.arrays import frozen
from recognition.report.recorded import recorded
from recognition.running.logbook import Logbook

ARRAY = TaxelArray("pad", 4, 6, (2.0, 3.0))


def observation(index, pressed):
    depth = np.full(ARRAY.shape, 0.4 if pressed else 0.0)
    frame = TaxelFrame(np.round(100 * depth), 0.01 * index, index)
    image = TactileImage(ARRAY, frozen(depth), frozen(np.full(ARRAY.shape, 0.01)), 1.0, 0.1, 0.0)
    return Observation(frame.time, frame, image, np.eye(4), load_of(image), 0)


def test_touches_are_those_that_the_run_counted_however_long_the_pad_was_off(tmp_path):
    cost = SimpleNamespace(touches=0, strokes=0)
    with Recorder(tmp_path / "episode.mcap") as recorder:
        logbook = Logbook(recorder)
        begins = {0: 1, 20: 2, 30: 3}  # the first leaves its surface for long, the others come soon after it
        for k in range(40):
            cost.touches = begins.get(k, cost.touches)
            logbook.observe(SimpleNamespace(cost=cost), observation(k, k % 10 >= 5))
    told = recorded(tmp_path / "episode.mcap").frames
    assert len(told.times) == 40
    np.testing.assert_array_equal(told.touch, logbook.frames().touch)
    assert set(told.touch.tolist()) == {-1, 0, 1, 2}


def test_contact_in_a_recording_that_counts_no_touches_is_contact(tmp_path):
    with Recorder(tmp_path / "episode.mcap") as recorder:
        for k in range(10):
            seen = observation(k, k > 4)
            wrench = np.array([0.0, 0.0, -seen.force, 0.0, 0.0, 0.0])
            recorder.frame("pad", seen.frame, np.eye(4), wrench)
    told = recorded(tmp_path / "episode.mcap").frames
    np.testing.assert_array_equal(told.touch, [-1] * 5 + [0] * 5)


def test_frames_of_a_second_array_are_shown_on_the_grid_of_the_first(tmp_path):
    specs = [load_sensor("lts210"), load_sensor("fingertip")]
    with Recorder(tmp_path / "episode.mcap") as recorder:
        for k, spec in enumerate(specs):
            counts = np.full(spec.array.shape, spec.electronics.offset + spec.electronics.plateau)
            recorder.frame(spec.name, TaxelFrame(counts, 0.01 * k, k), np.eye(4), np.zeros(6))
    wide, small = recorded(tmp_path / "episode.mcap").frames.counts
    assert (wide == 130.0).all()
    assert np.count_nonzero(small == 130.0) == 16  # 8 x 8 mm of a grid of 1.8 mm
    assert set(small.ravel().tolist()) == {10.0, 130.0}
