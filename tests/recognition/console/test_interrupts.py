"""Interrupts are real signals to this process."""

import ctypes
import os
import signal
import sys
import time

import pytest

from recognition.console import interrupts

pytestmark = pytest.mark.usefixtures("heeded")


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_raises_where_the_program_is(number, code):
    with pytest.raises(KeyboardInterrupt) as told:
        os.kill(os.getpid(), number)
    assert told.value.exit_code == code


def written_while_interrupted(written):
    with interrupts.held():
        with interrupts.held():
            os.kill(os.getpid(), signal.SIGTERM)
            written.append("half")
        written.append("whole")


def test_a_signal_waits_until_what_is_being_written_is_whole():
    written = []
    with pytest.raises(interrupts.Interrupted):
        written_while_interrupted(written)
    assert written == ["half", "whole"]


def test_a_signal_that_is_held_raises_at_a_checkpoint():
    with interrupts.held():
        interrupts.checkpoint()
        os.kill(os.getpid(), signal.SIGINT)
        with pytest.raises(interrupts.Interrupted):
            interrupts.checkpoint()
        interrupts.heed()


def asked_twice(apart):
    with interrupts.held():
        os.kill(os.getpid(), signal.SIGTERM)
        time.sleep(apart)
        os.kill(os.getpid(), signal.SIGTERM)
        interrupts.heed()
        return "went on"


def test_who_asks_once_more_waits_for_nothing_unless_it_is_an_echo():
    assert asked_twice(0.0) == "went on"
    with pytest.raises(interrupts.Interrupted):
        asked_twice(1.1)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_in_a_callback_of_compiled_code_raises_once_that_is_left(number, code, capfd):
    callback = ctypes.CFUNCTYPE(None)(lambda: os.kill(os.getpid(), number))
    with pytest.raises(interrupts.Interrupted) as told:
        compile_for_long(callback)
    assert told.value.exit_code == code
    assert interrupts.asked() == code
    assert capfd.readouterr().err == ""


def compile_for_long(callback):
    callback()
    until = time.monotonic() + 10.0
    while time.monotonic() < until:
        pass


def test_other_errors_that_nobody_can_answer_are_told_as_ever(monkeypatch):
    told = []
    monkeypatch.setattr(sys, "unraisablehook", told.append)
    interrupts.heed()
    ctypes.CFUNCTYPE(None)(lambda: 1 // 0)()
    assert [type(one.exc_value) for one in told] == [ZeroDivisionError]


def test_a_signal_that_is_ignored_stays_ignored():
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    interrupts.heed()
    os.kill(os.getpid(), signal.SIGTERM)


def test_an_interrupt_is_found_behind_what_a_kernel_makes_of_it():
    told = SystemError("a kernel")
    told.__cause__ = interrupts.Interrupted()
    assert isinstance(interrupts.behind(told), interrupts.Interrupted)
    assert interrupts.behind(ValueError()) is None
