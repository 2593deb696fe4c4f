"""The hardware commands over pseudo-terminals: they tell what is there, and move no further than a touch."""

from pathlib import Path

import numpy as np
import pytest

from primitives.errors import PalpateError
from recognition.frames.options import FramesOptions
from recognition.frames.run import run as frames
from recognition.hardware.check import check
from recognition.hardware.config import load_device
from recognition.hardware.jog import jog
from recognition.hardware.listen import REST, listen
from recognition.hardware.rehearse import rehearsed

BENCH = Path(__file__).parents[2] / "bench"
HEIGHT = 15.0


@pytest.fixture(scope="module")
def rig(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(BENCH))
        from devices.judged_rig import JudgedRig

        with JudgedRig(tmp_path_factory.mktemp("rig"), HEIGHT, 30.0, 0, 1.0, "lines") as made:
            yield made


def test_check_tells_the_array_and_where_the_flange_is(rig):
    told = check(rig.config)
    assert told["healthy"] == (not told["wrong"])
    assert not [line for line in told["wrong"] if "frames a second" not in line]  # which a busy machine costs
    assert 20.0 < told["rate_hz"] < 300.0
    assert told["flange_mm"] == pytest.approx([0.0, 0.0, 20.0 + HEIGHT], abs=0.01)


@pytest.mark.slow
def test_a_jog_arrives_or_ends_at_the_touch(rig):
    told = jog(rig.config, (5.0, 0.0, 0.0), home=False)
    assert told["ended"] == "arrived"
    assert told["position_mm"] == pytest.approx([5.0, 0.0, 20.0 + HEIGHT], abs=0.1)
    told = jog(rig.config, (0.0, 0.0, -HEIGHT - 5.0), home=False)
    assert told["touched"]
    assert rig.truth().force.max() < 30.0
    assert jog(rig.config, (-5.0, 0.0, HEIGHT), home=False, unlock=True)["ended"] == "arrived"


def test_frames_come_live_and_are_perceived(rig):
    shown = []
    recording, calibration = listen(rig.config, 0.4, lambda felt, _: shown.append(felt))
    seen = frames(FramesOptions(str(rig.config)), recording, calibration=calibration)
    assert len(seen.rows) > REST
    assert {row["kind"] for row in seen.rows} == {"nothing"}
    assert shown


@pytest.mark.slow
def test_a_dry_run_moves_nothing_and_lists_the_search(rig):
    before = rig.truth().position[-1]
    motions = rehearsed(rig.config)
    assert np.allclose(rig.truth().position[-1], before)
    assert motions[0].what.startswith("shake")
    assert np.allclose(motions[1].start[:3, 3], before, atol=1.5)
    felt = [m for m in motions if m.what == "feel along"]
    low, high = np.reshape(load_device(rig.config).limits.workspace_mm, (2, 3))
    assert all(m.end[2, 3] > low[2] - 5.0 and m.start[2, 3] < high[2] + 5.0 for m in felt)
    assert len(felt) > 5
    assert not any(m.trouble for m in motions)


def test_a_rig_whose_emulator_is_away_is_told_in_one_line(rig, tmp_path):
    text = rig.config.read_text().replace("palpate-", "gone-")
    (tmp_path / "gone.toml").write_text(text)
    with pytest.raises(PalpateError, match="emulate") as caught:
        check(tmp_path / "gone.toml")
    assert "\n" not in str(caught.value)
