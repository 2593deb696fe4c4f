"""An emulator's clock, read while it is written."""

import multiprocessing
import time

import pytest

from exploration.devices.clock import ReadClock, WrittenClock
from primitives.errors import PalpateError

LONGEST = 0.005  # [s] that one tick may add


def write(clock):
    while True:
        clock.tick()


def test_a_reader_never_sees_time_go_back_or_run_ahead_of_the_machines(tmp_path):
    path = tmp_path / "clock"
    written = WrittenClock(path, longest=LONGEST)
    writer = multiprocessing.get_context("fork").Process(target=write, args=(written,), daemon=True)
    clock = ReadClock(path)
    writer.start()
    try:
        asked, last, faults = time.monotonic(), clock.now(), 0
        until = asked + 60.0
        while last < 0.3 and asked < until:
            asking, now = time.monotonic(), clock.now()
            # a tick that was reckoned before the writer was put aside, and the next one, come together
            faults += now < last or now - last > time.monotonic() - asked + 2 * LONGEST
            last, asked = now, asking
        assert last >= 0.3
        assert not faults
    finally:
        writer.kill()
        writer.join()


def test_time_stands_while_the_writer_does_not_run(tmp_path):
    clock = WrittenClock(tmp_path / "clock", longest=0.005)
    clock.tick()
    time.sleep(0.05)
    assert clock.tick() <= 0.0101


def test_a_clock_that_is_not_there_is_told_with_its_fix(tmp_path):
    with pytest.raises(PalpateError, match="emulate running"):
        ReadClock(tmp_path / "none")
