"""An emulator's clock, read while it is written."""

import multiprocessing
import time

import pytest

from exploration.devices.clock import ReadClock, WrittenClock
from primitives.errors import PalpateError


def write(clock, seconds):
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        clock.tick()


def test_a_reader_never_sees_time_go_back_or_leap(tmp_path):
    path = tmp_path / "clock"
    writer = multiprocessing.get_context("fork").Process(target=write, args=(WrittenClock(path), 1.0))
    clock = ReadClock(path)
    writer.start()
    last, leaps = clock.now(), 0
    until = time.monotonic() + 0.8
    while time.monotonic() < until:
        now = clock.now()
        leaps += now < last or now > last + 0.2
        last = now
    writer.join()
    assert last > 0.0
    assert not leaps


def test_time_stands_while_the_writer_does_not_run(tmp_path):
    clock = WrittenClock(tmp_path / "clock", longest=0.005)
    clock.tick()
    time.sleep(0.05)
    assert clock.tick() <= 0.0101


def test_a_clock_that_is_not_there_is_told_with_its_fix(tmp_path):
    with pytest.raises(PalpateError, match="emulate running"):
        ReadClock(tmp_path / "none")
