"""Every protocol of arrays: published vectors, frames there and back, and frames found in damaged streams."""

from itertools import pairwise

import numpy as np
import pytest
from wire_soak import PROTOCOLS, mutated_streams

from exploration.devices.wire import weiss_dsa, weiss_wts
from exploration.devices.wire.stream import Stream
from exploration.devices.wire.weiss_packets import crc16

HEX = bytes.fromhex
STREAMS, FRAMES = 100, 100  # 10,000 frames of every protocol


def test_weiss_crc_has_its_published_value_and_vanishes_over_data_and_crc():
    assert crc16(b"123456789") == 0x6EB4
    assert crc16(b"123456789" + (0x6EB4).to_bytes(2, "little")) == 0


@pytest.mark.parametrize(
    ("made", "published"),
    [
        (weiss_dsa.configure(True), "AA AA AA 03 03 00 81 1E 00 2C 76"),
        (weiss_dsa.configure(False), "AA AA AA 03 03 00 00 00 00 8D 00"),
        (weiss_dsa.ask_matrix(), "AA AA AA 0B 01 00 00 CB FB"),
        (
            weiss_dsa.encode_frame(np.array([0, 0, 0, 500]), 1234),
            "AA AA AA 00 09 00 D2 04 00 00 01 00 30 F4 11 38 DD",
        ),
        (weiss_wts.ask_matrix(), "AA AA AA 30 00 00 CA CF"),
    ],
)
def test_published_packets_come_out_byte_for_byte(made, published):
    assert made == HEX(published)


def test_a_published_frame_is_read():
    (frame,) = weiss_dsa.cut(HEX("AA AA AA 00 09 00 D2 04 00 00 01 00 30 F4 11 38 DD"), 4).frames
    assert frame.counts.tolist() == [0, 0, 0, 500]
    assert frame.device_time == pytest.approx(1.234)


@pytest.mark.parametrize("name", PROTOCOLS)
def test_random_frames_come_back_whatever_pieces_they_arrive_in(name):
    protocol, rng = PROTOCOLS[name], np.random.default_rng(1)
    for _ in range(STREAMS):
        frames = [protocol.random(rng) for _ in range(FRAMES)]
        data = b"".join(protocol.encode(f, i) for i, f in enumerate(frames))
        stream, got = Stream(protocol.cut), []
        stream.gap()  # a reader knows where the line was silent
        cuts = [0, *np.cumsum(rng.integers(1, 200, len(data) // 100)).tolist(), len(data)]
        for begin, end in pairwise(cuts):
            got += stream.feed(data[begin:end])
        assert [np.ravel(g.counts).tolist() for g in got] == [f.tolist() for f in frames]
        assert stream.skipped == 0


@pytest.mark.parametrize("name", PROTOCOLS)
def test_the_next_good_frames_are_found_after_any_damage(name):
    assert mutated_streams(PROTOCOLS[name], 400, seed=2) == 400


def test_replies_between_frames_are_kept_apart():
    told = weiss_dsa.MatrixInfo((3.4, 3.4), (2, 2), 4095.0)
    frame = weiss_dsa.encode_frame(np.arange(4), 5)
    cut = weiss_dsa.cut(frame + weiss_dsa.encode_matrix_info(told) + frame, 4)
    assert len(cut.frames) == 2
    assert weiss_dsa.matrix_info(cut.replies[0].payload).cells == (2, 2)
