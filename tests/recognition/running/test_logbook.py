"""What the logbook keeps, and what it makes of an image."""

from types import SimpleNamespace

import numpy as np
import pytest

from exploration.devices.guard import Observation
from exploration.recordings.mcap import RecordedEvent, RecordedFrame, Recorder, read
from exploration.sensing.frame import TactileImage, TaxelArray, TaxelFrame
from exploration.sensing.load import load_of
from primitives.arrays import frozen
from recognition.running.logbook import Logbook, LogConfig, Thinned, wrench

ARRAY = TaxelArray("pad", 4, 6, (2.0, 3.0))


def image(depth, sigma=0.01):
    return TactileImage(ARRAY, frozen(depth), frozen(np.full(ARRAY.shape, sigma)), 1.0, 0.1, 0.0)


def observation(index, depth):
    frame = TaxelFrame(np.round(100 * depth), 0.01 * index, index)
    seen = image(depth)
    return Observation(frame.time, frame, seen, np.eye(4), load_of(seen), 0)


@pytest.mark.parametrize("count", [0, 1, 9, 10, 11, 500, 1234])
def test_thinning_keeps_an_even_choice_that_is_never_too_long(count):
    thinned = Thinned(10)
    for k in range(count):
        thinned.offer(k)
    assert len(thinned.kept) <= 10
    assert len(thinned.kept) >= min(count, 5)
    assert len(set(np.diff(thinned.kept))) <= 1


def test_the_wrench_is_that_of_point_forces():
    depth = np.zeros(ARRAY.shape)
    depth[3, 0] = 0.5
    force = np.array([0.0, 0.0, -0.5 * 0.1 * 6.0])
    at = np.array([ARRAY.x[0], ARRAY.y[3], 0.0])
    assert wrench(load_of(image(depth))) == pytest.approx([*force, *np.cross(at, force)])


def test_a_dead_taxel_pushes_nothing():
    sigma = np.full(ARRAY.shape, 0.01)
    sigma[3, 0] = np.inf
    depth = np.zeros(ARRAY.shape)
    depth[3, 0] = 0.5
    assert wrench(load_of(image(depth, sigma))) == pytest.approx(np.zeros(6))


def test_every_frame_is_recorded_and_those_in_contact_are_preferred(tmp_path):
    guard = SimpleNamespace(cost=SimpleNamespace(touches=3, strokes=5))
    with Recorder(tmp_path / "episode.mcap") as recorder:
        logbook = Logbook(recorder, LogConfig(contact_frames=40, free_frames=10))
        for k in range(200):
            logbook.observe(guard, observation(k, np.full(ARRAY.shape, 0.4 if 100 <= k < 130 else 0.0)))
        logbook.announce("move", {"note": "here"})
    items = list(read(tmp_path / "episode.mcap"))
    assert [item.frame.index for item in items if isinstance(item, RecordedFrame)] == list(range(200))
    assert [item.kind for item in items if isinstance(item, RecordedEvent)] == ["approach", "stroke", "move"]
    frames = logbook.frames()
    assert (frames.touch == 2).sum() == 30
    assert (frames.touch == -1).sum() <= 10
    assert (np.diff(frames.times) > 0).all()
