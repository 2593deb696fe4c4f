"""Who wants `reconstruct` to end does not wait for the model, and gets no half of one."""

import os
import signal

import numpy as np
import pytest

from recognition.console import interrupts
from recognition.reconstructing import run as running
from recognition.reconstructing.options import ReconstructSourceOptions

_STEPS = ["surfaces", "reconstruct", "write_model", "write_report"]


@pytest.mark.slow
@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
@pytest.mark.parametrize("step", _STEPS)
@pytest.mark.usefixtures("heeded")
def test_a_signal_ends_it_where_it_is_or_once_a_file_is_whole(tmp_path, monkeypatch, step, number, code):
    done = []
    for name in _STEPS:
        monkeypatch.setattr(running, name, interrupted(getattr(running, name), name == step, number, done))
    points = np.random.default_rng(0).uniform(-1.0, 1.0, (40, 3))
    points = 20.0 * points / np.abs(points).max(axis=1, keepdims=True)
    np.savetxt(tmp_path / "c.csv", points, delimiter=",")
    with pytest.raises(interrupts.Interrupted):
        running.run(ReconstructSourceOptions(tmp_path / "c.csv", 0.01, out=tmp_path / "run"), lambda _: None)
    assert interrupts.asked() == code
    writes = step.startswith("write")
    assert set(done) == set(_STEPS[: _STEPS.index(step) + writes])
    assert not (tmp_path / "run" / "summary.json").exists()
    assert (tmp_path / "run" / "model.csg").exists() == writes


def interrupted(function, here, number, done):
    def one_step(*arguments):
        if here:
            os.kill(os.getpid(), number)
        result = function(*arguments)
        done.append(function.__name__)
        return result

    return one_step
