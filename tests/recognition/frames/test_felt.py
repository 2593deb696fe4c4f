"""What is read in frames: edges where they are, nothing where nothing can be."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from exploration.recordings.open import open_recording
from exploration.sensing.spec import load_sensor
from recognition.frames.felt import Feeler
from recognition.frames.rows import frame_row

FINE = 8


def edge_frame(angle, offset, pitch=1.8, spread=1.2, shape=(10, 16)):
    """Depth share of a half plane on the positive side, blurred with scipy and averaged over taxels."""
    pad = 6 * FINE
    rows, columns = (n * FINE + 2 * pad for n in shape)
    y, x = ((np.arange(n) - (n - 1) / 2) * pitch / FINE for n in (rows, columns))
    cover = (y[:, None] * np.cos(angle) - x[None, :] * np.sin(angle) > offset).astype(float)
    blurred = gaussian_filter(cover, spread * FINE / pitch)[pad:-pad, pad:-pad]
    return blurred.reshape(shape[0], FINE, shape[1], FINE).mean(axis=(1, 3))


def recording_of(path, frames, rest=20, noise=1.0, offset=10.0, plateau=120.0, seed=0):
    rng = np.random.default_rng(seed)
    stack = np.concatenate([np.zeros((rest, *frames[0].shape)), frames])
    counts = np.round(offset + plateau * stack + noise * rng.standard_normal(stack.shape))
    np.save(path / "a.npy", counts)
    return path / "a.npy"


def felt_in(path, spec=None):
    return list(Feeler.of(open_recording(path, spec)).feel())


ANGLES = np.radians([0, 25, 70, 90, 118, 160])


@pytest.mark.parametrize("spec", [None, load_sensor("lts210")], ids=["plain", "lts210"])
def test_edges_of_a_stack_are_found_where_they_are(spec, tmp_path):
    truth = [(angle, 1.1) for angle in ANGLES]
    felt = felt_in(recording_of(tmp_path, np.array([edge_frame(*edge) for edge in truth])), spec)
    assert [bool(f.touch) for f in felt[:20]] == [False] * 20
    unit = 1.0 if spec else 1.8  # plain arrays count in taxels
    for f, (angle, offset) in zip(felt[20:], truth, strict=True):
        (line,) = f.touch.lines
        turn = (line.angle - angle + np.pi / 2) % np.pi - np.pi / 2
        assert abs(np.degrees(turn)) < 2.0
        sign = 1 if np.cos(line.angle - angle) > 0 else -1
        assert sign * line.offset * unit == pytest.approx(offset, abs=0.25)
        assert line.material_side == sign


HOSTILE = {
    "not a number": np.full((10, 16), np.nan),
    "one value missing beside an edge": np.where(
        np.eye(10, 16) * (np.arange(10) == 4)[:, None] > 0, np.nan, 0
    )
    + edge_frame(0.4, 1.0),
    "infinite": np.full((10, 16), np.inf),
    "absurd": 1e300 * edge_frame(0.4, 1.0),
    "far below zero": -edge_frame(0.4, 1.0),
    "saturated all over": np.full((10, 16), 4.0),
    "untouched": np.zeros((10, 16)),
}


@pytest.mark.parametrize("spec", [None, load_sensor("lts210")], ids=["plain", "lts210"])
@pytest.mark.parametrize("frame", HOSTILE.values(), ids=HOSTILE)
def test_a_hostile_frame_is_nothing_and_never_a_line(frame, spec, tmp_path):
    pressed = edge_frame(0.4, 1.0)
    path = recording_of(tmp_path, np.array([pressed, frame, frame * 1.0, pressed]), noise=0.0)
    felt = felt_in(path, spec)
    assert felt[20].touch.lines
    for f in felt[21:23]:
        assert f.touch.kind == "nothing"
        row = frame_row(f, open_recording(path, spec).pads[0])
        assert row["lines"] == row["arcs"] == []


@pytest.mark.parametrize("shape", [(1, 1), (1, 16), (2, 2), (16, 1), (3, 3)])
def test_small_arrays_answer_without_a_false_line(shape, tmp_path):
    rng = np.random.default_rng(2)
    stack = 50 + rng.standard_normal((40, *shape))
    stack[20:] += 100
    np.save(tmp_path / "a.npy", stack)
    felt = felt_in(tmp_path / "a.npy")
    assert not any(f.touch.lines or f.arcs for f in felt)


def test_every_number_of_a_row_is_plain(tmp_path):
    path = recording_of(tmp_path, np.array([edge_frame(0.4, 1.0)]))
    recording = open_recording(path, load_sensor("lts210"))
    row = frame_row(list(Feeler.of(recording).feel())[-1], recording.pads[0])
    assert row["time_ms"] is None
    assert row["pad"] == 0
    assert row["kind"] == "edge"
    assert sum(row["kinds"].values()) == pytest.approx(1.0, abs=1e-3)
    (line,) = row["lines"]
    assert 0 <= line["angle_deg"] < 180
    assert {type(value) for value in line.values()} == {float, int}
    assert row["force_n"] > 0
    assert len(row["curvatures_per_mm"]) == 2
