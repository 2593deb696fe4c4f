import io
import os
import zipfile

import numpy as np
import pytest

from exploration.recordings.mcap import Recorder
from exploration.recordings.open import open_recording
from exploration.sensing.frame import TaxelFrame
from exploration.sensing.spec import load_sensor
from primitives.errors import PalpateError
from primitives.pose import pose

RNG = np.random.default_rng(3)
STACK = RNG.integers(0, 255, (7, 10, 16)).astype(np.uint8)
LTS = load_sensor("lts210")


def counts_of(recording, pad=0):
    return np.array([item.frame.counts for item in recording.frames() if item.pad == pad])


def lines_of(stack, separator=","):
    return "\n".join(separator.join(str(x) for x in row) for row in stack.reshape(len(stack), -1))


def blocks_of(stack, between="\n\n"):
    return between.join("\n".join(",".join(str(x) for x in row) for row in frame) for frame in stack)


def write(path, text):
    path.write_text(text)
    return path


def saved(path, *args, **kwargs):
    (np.save if path.suffix == ".npy" else np.savez)(path, *args, **kwargs)
    return path


WRITERS = {
    "npy": lambda f: saved(f / "a.npy", STACK),
    "npy, columns first in memory": lambda f: saved(f / "a.npy", np.asfortranarray(STACK)),
    "npy, one frame a line": lambda f: saved(f / "a.npy", STACK.reshape(7, 160)),
    "npz": lambda f: saved(f / "a.npz", anything=STACK),
    "npz, compressed": lambda f: (np.savez_compressed(f / "a.npz", frames=STACK), f / "a.npz")[1],
    "npz, columns first in memory": lambda f: saved(f / "a.npz", frames=np.asfortranarray(STACK)),
    "csv, one frame a line": lambda f: write(f / "a.csv", lines_of(STACK)),
    "csv, semicolons": lambda f: write(f / "a.csv", lines_of(STACK, ";")),
    "csv, spaces": lambda f: write(f / "a.csv", lines_of(STACK, "  ")),
    "csv, blank lines between": lambda f: write(f / "a.csv", "\n" + blocks_of(STACK) + "\n\n"),
    "csv, comments between": lambda f: write(f / "a.csv", "# first\n" + blocks_of(STACK, "\n# next\n")),
    "capital suffix": lambda f: saved(f / "a.npy", STACK).rename(f / "A.NPY"),
}


@pytest.mark.parametrize("spec", [None, LTS], ids=["plain", "lts210"])
@pytest.mark.parametrize("make", WRITERS.values(), ids=WRITERS)
def test_every_layout_gives_the_same_frames(make, spec, tmp_path):
    recording = open_recording(make(tmp_path), spec)
    for _ in range(2):
        np.testing.assert_array_equal(counts_of(recording), STACK)
    assert recording.pads[0].assumed_pitch == (spec is None)
    assert any("no poses" in warning for warning in recording.warnings)


@pytest.mark.parametrize(
    ("header", "unit"),
    [("time_ms,", 1e-3), ("frame,t,", 1.0), ("", 1.0)],
    ids=["ms", "after an index", "unnamed"],
)
def test_a_time_column_is_known(header, unit, tmp_path):
    names = header + ",".join(f"c{i}" for i in range(160)) + "\n" if header else ""
    rows = "\n".join(
        ",".join([*([str(i)] if "frame" in header else []), str(5 + 20 * i), *map(str, frame.ravel())])
        for i, frame in enumerate(STACK)
    )
    recording = open_recording(write(tmp_path / "a.csv", names + rows))
    np.testing.assert_array_equal(counts_of(recording), STACK)
    times = [item.frame.time for item in recording.frames()]
    np.testing.assert_allclose(times, 20 * np.arange(7) * unit)


def test_an_empty_cell_is_a_missing_value(tmp_path):
    recording = open_recording(write(tmp_path / "a.csv", "1,2,3\n4,,6\n7,8,9\n"))
    np.testing.assert_array_equal(counts_of(recording), [[[1, 2, 3], [4, np.nan, 6], [7, 8, 9]]])


def test_pads_times_and_poses_come_with_a_stack(tmp_path):
    stack = RNG.normal(size=(5, 2, 4, 4))
    poses = np.stack([pose(None, [i, 0, 0]) for i in range(5)])
    path = saved(tmp_path / "a.npz", frames=stack, time_ms=1000 + 10 * np.arange(5), poses=poses)
    recording = open_recording(path)
    assert recording.posed
    assert recording.timed
    items = list(recording.frames())
    np.testing.assert_array_equal(counts_of(recording, 1), stack[:, 1])
    assert [item.frame.time for item in items[::2]] == pytest.approx([0, 0.01, 0.02, 0.03, 0.04])
    np.testing.assert_array_equal(items[8].world_from_sensor, poses[4])


def test_an_episode_reads_back_with_its_poses(tmp_path):
    with Recorder(tmp_path / "e.mcap") as recorder:
        for i, counts in enumerate(STACK.astype(float)):
            recorder.frame("lts210", TaxelFrame(counts, i / 200, i), pose(None, [i, 2, 3]), np.zeros(6))
    recording = open_recording(tmp_path / "e.mcap")
    np.testing.assert_array_equal(counts_of(recording), STACK)
    assert recording.pads[0].spec.array.pitch == (1.8, 1.8)
    assert recording.warnings == ()
    assert [item.world_from_sensor[0, 3] for item in recording.frames()] == pytest.approx(range(7))


def test_an_episode_cut_short_says_so(tmp_path):
    with Recorder(tmp_path / "e.mcap") as recorder:
        for i in range(3000):
            recorder.frame(
                "lts210", TaxelFrame(RNG.normal(size=(10, 16)), i / 200, i), np.eye(4), np.zeros(6)
            )
    data = (tmp_path / "e.mcap").read_bytes()
    (tmp_path / "e.mcap").write_bytes(data[: len(data) // 2])
    recording = open_recording(tmp_path / "e.mcap")
    assert any("cut short" in warning for warning in recording.warnings)
    assert 0 < len(counts_of(recording)) < 3000


def header_of(shape):
    data = io.BytesIO()
    np.lib.format.write_array_header_1_0(data, {"descr": "<f8", "fortran_order": False, "shape": shape})
    return data.getvalue()


def zipped(path, data):
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("frames.npy", data)


def npy(array, **kwargs):
    data = io.BytesIO()
    np.save(data, array, **kwargs)
    return data.getvalue()


OBJECTS = npy(np.array([{"a": 1}], dtype=object), allow_pickle=True)
BROKEN = {
    "pickled.npy": (OBJECTS, "pickled"),
    "announces.npy": (header_of((10**9, 10, 16)) + bytes(100), "cut short"),
    "cut.npy": (npy(STACK)[:-100], "cut short"),
    "complex.npy": (npy(np.zeros((3, 4, 4), complex)), "not real numbers"),
    "nothing.npy": (npy(np.zeros((0, 10, 16))), "no frames"),
    "wide.npy": (npy(np.zeros((1, 2, 5000), np.uint8)), "at most"),
    "noise.npy": (RNG.bytes(300), "header"),
    "noise.npz": (b"PK\x03\x04" + RNG.bytes(300), "damaged"),
    "a_csv.npy": (b"1,2\n3,4\n", "header"),
    "an_npy.csv": (npy(STACK), "rename it to an_npy.npy"),
    "ragged.csv": (b"1,2,3\n4,5\n", "line 2 has 2 values"),
    "words.csv": (b"1,2\nthree,4\n", "line 2 holds 'three'"),
    "uneven.csv": (b"1,2\n3,4\n\n5,6\n", "1 lines"),
    "header_only.csv": (b"a,b\n", "no line of numbers"),
    "utf16.csv": ("1,2\n".encode("utf-16"), "not text"),
    "odd.csv": (b"1,2,3,4,5,6,7\n" * 500, "--sensor"),
    "noise.mcap": (RNG.bytes(300), "not an MCAP"),
    "head.mcap": (b"\x89MCAP0\r\n", "no frame"),
    "empty.csv": (b"", "empty"),
    "picture.png": (b"\x89PNG", "ends in .mcap, .dsa"),
}


@pytest.mark.parametrize("name", BROKEN)
def test_what_is_wrong_with_a_file_is_one_line(name, tmp_path):
    data, says = BROKEN[name]
    (tmp_path / name).write_bytes(data)
    with pytest.raises(PalpateError, match=says) as caught:
        list(open_recording(tmp_path / name).frames())
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("data", [OBJECTS, header_of((10**9, 10, 16))], ids=["pickled", "announces too much"])
def test_an_archive_is_looked_at_before_it_is_read(data, tmp_path):
    zipped(tmp_path / "a.npz", data)
    with pytest.raises(PalpateError, match=r"pickled|cut short"):
        open_recording(tmp_path / "a.npz")


def test_a_byte_that_turned_over_in_an_archive_is_found(tmp_path):
    path = saved(tmp_path / "a.npz", frames=STACK)
    data = bytearray(path.read_bytes())
    data[600] ^= 0xFF
    path.write_bytes(data)
    with pytest.raises(PalpateError, match="damaged"):
        list(open_recording(path).frames())


def test_another_array_is_refused_with_those_that_fit(tmp_path):
    path = saved(tmp_path / "a.npy", np.zeros((5, 14, 6)))
    with pytest.raises(
        PalpateError, match=r"14 x 6.*lts210 is 10 x 16.*--sensor dsa.*rows = 14 and columns = 6"
    ):
        open_recording(path, LTS)
    with pytest.raises(PalpateError, match="transpose"):
        open_recording(saved(tmp_path / "b.npy", np.zeros((5, 16, 10))), LTS)


def test_what_is_not_a_file_is_said(tmp_path):
    (tmp_path / "folder.dsa").mkdir()
    for name, says in (("folder.dsa", "folder"), ("gone.dsa", "no file"), ("gone", "no file")):
        with pytest.raises(PalpateError, match=says):
            open_recording(tmp_path / name)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="left out: no named pipes here")
def test_a_pipe_is_not_waited_for(tmp_path):
    os.mkfifo(tmp_path / "a.csv")
    with pytest.raises(PalpateError, match="pipe"):
        open_recording(tmp_path / "a.csv")
