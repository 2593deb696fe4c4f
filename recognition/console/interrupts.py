"""Ctrl-C and a polite kill alike end a program where it can end: between two frames, not inside one.

`heed` turns SIGTERM and SIGHUP into a `KeyboardInterrupt` as Ctrl-C is one.  Raised anywhere, it takes a half-made
import for a missing one, or cuts a recording in two; so within `held` a signal is only noted, and raises at the
next `checkpoint` or where the block ends; whoever asks once more a second later waits for neither, as in the
middle of a long computation.  In a callback of compiled code, as there are while kernels compile,
Python drops whatever is raised; there the signal is sent again, until it is raised where it is answered.
"""

from __future__ import annotations

import _thread
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

_AGAIN = 0.02  # [s] until an interrupt that was dropped is sent again
_PATIENCE = 1.0  # [s] from when on asking once more is no echo, as of a shell and `make` that both ask
_NAMES = ("SIGINT", "SIGTERM", "SIGHUP")  # a system may lack the last


class Interrupted(KeyboardInterrupt):
    """Somebody wants the program to end."""

    def __init__(self, number: int = signal.SIGINT) -> None:
        super().__init__(number)
        self.exit_code = 128 + number


class _State:
    depth = 0  # of blocks that hold interrupts
    asked: int | None = None  # the signal that asked to end
    since = 0.0  # [s] of the monotonic clock, when it did first
    dropped = staticmethod(sys.__unraisablehook__)  # what is done with other errors that nobody can answer


_state = _State()


def heed() -> None:
    """From now on note or raise what asks to end, unless it is ignored; forget what was asked before."""
    _state.asked = None
    ours = (signal.SIG_DFL, signal.default_int_handler, _told)
    for name in _NAMES:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) in ours:
            signal.signal(number, _told)
    if sys.unraisablehook is not _send_again:
        _state.dropped, sys.unraisablehook = sys.unraisablehook, _send_again


@contextmanager
def held() -> Iterator[None]:
    """Within the block, interrupts raise at checkpoints alone, and at its end."""
    _state.depth += 1
    try:
        yield
    finally:
        _state.depth -= 1
    if not _state.depth:
        checkpoint()


def checkpoint() -> None:
    """Raise if somebody asked for an end."""
    if _state.asked is not None:
        raise Interrupted(_state.asked)


def asked() -> int | None:
    """The exit code of the interrupt that nobody has answered yet; it is answered now."""
    number, _state.asked = _state.asked, None
    return None if number is None else 128 + number


def behind(error: BaseException | None) -> KeyboardInterrupt | None:
    """The interrupt that is behind an error: a compiled kernel hands it on as a SystemError."""
    while error is not None:
        if isinstance(error, KeyboardInterrupt):
            return error
        error = error.__cause__ or error.__context__
    return None


def _send_again(unraisable: sys.UnraisableHookArgs) -> None:
    """Answer an error that Python drops: an interrupt comes back soon, others are told as ever."""
    if not isinstance(unraisable.exc_value, Interrupted):
        _state.dropped(unraisable)
        return
    number = unraisable.exc_value.exit_code - 128
    timer = threading.Timer(_AGAIN, _thread.interrupt_main, (number,))
    timer.daemon = True
    timer.start()


def _told(number: int, frame: FrameType | None) -> None:
    now = time.monotonic()
    if _state.asked is None:
        _state.since = now
    _state.asked = number
    if not _state.depth or now - _state.since > _PATIENCE:
        raise Interrupted(number)
