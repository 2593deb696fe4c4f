"""One line while kernels compile for the first time, which else is a silent minute.

Numba tells when it compiles and not when it loads what it compiled before.  Single small kernels are not worth a
word: the line comes once a second has gone into compiling.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from numba.core import event

_SILENT = 1.0  # [s] of compiling that nobody is told of
TEXT = "compiling the kernels, which happens once and takes a minute or two"


class _Told(event.Listener):  # type: ignore[misc]
    def __init__(self, say: Callable[[str], object]) -> None:
        self._say: Callable[[str], object] | None = say
        self._spent = self._depth = self._began = 0.0

    def on_start(self, event: Any) -> None:
        if self._depth == 0:
            self._began = time.monotonic()
            if self._say is not None and self._spent > _SILENT:
                self._say(TEXT)
                self._say = None
        self._depth += 1

    def on_end(self, event: Any) -> None:
        self._depth -= 1
        if self._depth == 0:
            self._spent += time.monotonic() - self._began


@contextmanager
def told(say: Callable[[str], object]) -> Iterator[None]:
    """`say` one line, once, if much compiles in the block."""
    with event.install_listener("numba:compile", _Told(say)):
        yield
