import bz2
import struct

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exploration.recordings.dsa import cells_of, read_dsa
from exploration.recordings.open import open_recording
from primitives.errors import PalpateError

PADS = ((4, 3), (2, 3))  # rows, columns


def matrix(index, rows, columns, mask=None):
    mask = mask or "\n".join(["1" * columns] * rows)
    return (
        f'<matrix index="{index}"><cells_x>{columns}</cells_x><cells_y>{rows}</cells_y>'
        f"<texel_width>3.4</texel_width><texel_height>2.0</texel_height><fullscale>4095</fullscale>"
        f"<static_mask>{mask}</static_mask></matrix>"
    )


def hexed(cells):
    """The format's run-length code, written independently of the reader."""
    out, run = [], 0
    for value in [*cells, None]:
        if value == 0:
            run += 1
            continue
        if run:
            out.append(-float(run))
            run = 0
        if value is not None:
            out.append(float(value))
    return b"".join(struct.pack(">f", value) for value in out).hex().upper()


def document(frames, pads=PADS, extra="", start=1410731503063):
    body = "".join(
        f'<frame index="{i}"><time_stamp>{start + 30 * i}</time_stamp><frame_data>\n {hexed(cells)}\n'
        f"</frame_data></frame>"
        for i, cells in enumerate(frames)
    )
    sensor = "".join(matrix(i, *shape) for i, shape in enumerate(pads))
    angles = (
        f'<joint_angles><angle index="0"><time_stamp>{start + 15}</time_stamp>'
        "<angle_data>90.0, -45.0</angle_data></angle></joint_angles>"
    )
    return f"<?xml version='1.0'?>{extra}<root><sensor>{sensor}</sensor><data>{body}</data>{angles}</root>"


def recorded(path, text):
    path.write_bytes(bz2.compress(text.encode()))
    return path


@settings(deadline=None, max_examples=50)
@given(st.lists(st.sampled_from([0, 0, 0, 1, 37, 4095]), min_size=1, max_size=60))
def test_runs_of_zeros_are_filled_in(cells):
    np.testing.assert_array_equal(cells_of(hexed(cells), len(cells)), cells)
    assert cells_of(hexed(cells), len(cells) + 1) is None


@pytest.mark.parametrize("text", ["", "C3F3", "zz", "CF000000", "FF800000", "BFC00000"])
def test_what_is_not_the_cells_of_a_frame_is_none(text):
    assert cells_of(text, 486) is None


def test_every_pad_gets_its_rows_in_order(tmp_path):
    cells = np.arange(18.0)
    recording = read_dsa(recorded(tmp_path / "a.dsa", document([cells * 0, cells])))
    assert [pad.array.shape for pad in recording.pads] == list(PADS)
    assert recording.pads[0].array.pitch == (3.4, 2.0)
    assert not recording.posed
    for _ in range(2):
        frames = list(recording.frames())
        assert [(item.pad, item.frame.index) for item in frames] == [(0, 0), (1, 0), (0, 1), (1, 1)]
        np.testing.assert_array_equal(frames[2].frame.counts, cells[:12].reshape(4, 3))
        np.testing.assert_array_equal(frames[3].frame.counts, cells[12:].reshape(2, 3))
        assert frames[2].frame.time == pytest.approx(0.03)


def test_joints_keep_their_own_clock(tmp_path):
    joints = read_dsa(recorded(tmp_path / "a.dsa", document([np.ones(18)]))).joints()
    np.testing.assert_allclose(joints.time, [0.015])
    np.testing.assert_allclose(joints.angles, np.radians([[90.0, -45.0]]))


def test_cells_that_the_mask_leaves_out_are_absent(tmp_path):
    text = document([np.ones(18)]).replace("111\n111\n111\n111", "010\n010\n111\n111", 1)
    absent = read_dsa(recorded(tmp_path / "a.dsa", text)).pads[0].absent
    np.testing.assert_array_equal(absent, [[1, 0, 1], [1, 0, 1], [0, 0, 0], [0, 0, 0]])


ENTITIES = "<!DOCTYPE r [<!ENTITY a 'lol'><!ENTITY b '&a;&a;&a;&a;&a;&a;'>]>"
GOOD = document([np.arange(18.0)] * 5)
BROKEN = {
    "cut short": (bz2.compress(GOOD.encode())[:-40], "cut short"),
    "cut within the XML": (bz2.compress(GOOD[:900].encode()), "not whole XML"),
    "entities": (bz2.compress(document([np.ones(18)], extra=ENTITIES).encode()), "document type"),
    "entities, not compressed": (document([np.ones(18)], extra=ENTITIES).encode(), "document type"),
    "deep": (b"<?xml version='1.0'?><root>" + b"<a>" * 50, "deeper"),
    "long text": (bz2.compress(b"<root>" + b" " * (1 << 21) + b"</root>"), "longer"),
    "other XML": (b"<?xml version='1.0'?><svg/>", "<svg>"),
    "no matrix": (bz2.compress(b"<root></root>"), "no matrix"),
    "no frame": (bz2.compress(document([]).encode()), "no frame"),
    "huge matrix": (bz2.compress(GOOD.replace("<cells_x>3", "<cells_x>1e6").encode()), "not an array"),
    "frame of another size": (bz2.compress(document([np.ones(17)]).encode()), "frame 0 is not 18 cells"),
    "no time": (bz2.compress(GOOD.replace("time_stamp", "stamp").encode()), "time_stamp"),
    "noise": (np.random.default_rng(0).bytes(500), "not whole XML"),
    "empty": (b"", "empty"),
}


@pytest.mark.parametrize(("data", "says"), BROKEN.values(), ids=BROKEN)
def test_what_is_wrong_with_a_file_is_one_line(data, says, tmp_path):
    (tmp_path / "a.dsa").write_bytes(data)
    with pytest.raises(PalpateError, match=says) as caught:
        list(open_recording(tmp_path / "a.dsa").frames())
    assert "\n" not in str(caught.value)
