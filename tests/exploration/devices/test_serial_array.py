"""What becomes of frames between a wire and whoever reads them."""

import time
from collections import deque

import numpy as np

from exploration.devices.serial_array import SerialArray
from exploration.devices.wire import line_text
from exploration.sensing.frame import TaxelArray

SMALL = TaxelArray("small", 3, 4, (2.0, 2.0))
COUNTS = np.arange(12)


class Told:
    """A port on which some bytes come, and then no more."""

    address = "told"

    def __init__(self, pieces):
        self.pieces = deque(pieces)

    def read(self) -> bytes:
        if self.pieces:
            return self.pieces.popleft()
        time.sleep(0.002)
        return b""

    def close(self) -> None:
        self.pieces.clear()


def heard(numbers, noise=b""):
    """The counts of an array whose frames carry these numbers."""
    lines = [line_text.encode(COUNTS, number, 10 * number) for number in numbers]
    port = Told([lines[0], noise, *lines[1:]])
    array = SerialArray(port, "lines", SMALL, 10.0, np.eye(4))
    array.start()
    until = time.monotonic() + 60.0
    while array.counts.read < len(numbers) and time.monotonic() < until:
        time.sleep(0.005)
    array.close()
    return array.counts


def test_frames_that_never_came_are_told_by_their_numbers():
    counts = heard([7, 8, 9, 13, 14])
    assert (counts.read, counts.lost) == (5, 3)
    assert "3 never came" in counts.remark


def test_an_array_that_begins_to_count_anew_has_lost_nothing():
    assert heard([70000, 70001, 0, 1]).lost == 0
    assert heard([0, 1, 2_000_000]).lost == 0


def test_strange_bytes_are_counted_and_all_well_is_no_remark():
    assert "5 bytes" in heard([1, 2], b"#*!?\n").remark
    assert heard([1, 2, 3]).remark == ""
