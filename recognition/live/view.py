"""A run in the browser while it goes on: what was felt until now, drawn whenever a browser asks for it.

    with shown(address, watch, say) as told:
        summary = run(options, told)    # the run's own thread draws, between two moves

When the run has ended, whoever looks gets its page, which needs no server.

The run is never waited for: a browser that asks gets what was drawn last, and asking makes the run draw again.
"""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType
from typing import Self
from urllib.parse import parse_qs

from recognition.live.server import HTML, JSON, address_of, parse_address, server
from recognition.report.page import live_html
from recognition.report.payload import payload
from recognition.report.terminal import progress_text
from recognition.running.folder import json_text
from recognition.running.progress import Page, Progress

_EVERY = 0.4  # [s] between two drawings
_LINGER = 10.0  # [s] that a page which looks has to fetch the whole one, when the run has ended


@contextmanager
def shown(
    address: str | None, told: Callable[[Progress], object], say: Callable[[str], object]
) -> Iterator[Callable[[Progress], None]]:
    """Something to tell progress to: who was told before, and a browser where there is an address."""
    if address is None:
        yield lambda progress: _to(progress, told)
        return
    with LiveView(address, say) as live:
        yield lambda progress: _to(progress, told, live.told)
        live.ended()


def _to(progress: Progress, *watchers: Callable[[Progress], object]) -> None:
    for told in watchers:
        told(progress)


class LiveView:
    """Serves a run; a context manager."""

    def __init__(self, address: str, say: Callable[[str], object]) -> None:
        host, port = parse_address(address)
        self._say = say
        self._server = server({"/": self._whole, "/now": self._now}, host, port)
        self._asked, self._seen = threading.Event(), threading.Event()
        self._page: Page | None = None
        self._folder: Path | None = None
        self._drawn, self._number, self._data = 0.0, 0, "null"
        self._stand = "starting"
        self._done = False

    @property
    def address(self) -> str:
        """Where it is served."""
        return address_of(self._server)

    def __enter__(self) -> Self:
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        self._say(f"live at {self.address}")
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._server.shutdown()
        self._server.server_close()
        self._page = None  # what it draws must not outlive the run in a thread that still answers

    def told(self, progress: Progress) -> None:
        """Draw what there is, if somebody looks."""
        self._page = progress.page or self._page
        self._folder = progress.folder or self._folder
        self._stand = progress_text(progress)
        if self._page is None or not self._asked.is_set() or time.monotonic() - self._drawn < _EVERY:
            return
        self._asked.clear()
        self._data = json_text(payload(self._page()))
        self._number += 1
        self._drawn = time.monotonic()

    def ended(self) -> None:
        """Hand the whole page to whoever looked, and go."""
        self._done = True
        if self._asked.is_set() or self._number:
            self._seen.wait(_LINGER)

    def _whole(self, query: str) -> tuple[str, bytes] | None:
        page = None if self._folder is None else self._folder / "report.html"
        if self._done and page is not None and page.is_file():
            body = page.read_bytes()
            self._seen.set()
            return HTML, body
        self._asked.set()
        return HTML, live_html().encode()

    def _now(self, query: str) -> tuple[str, bytes] | None:
        last = (parse_qs(query).get("after") or [""])[0]
        data = "null" if last == str(self._number) else self._data
        self._asked.set()
        head = {"number": self._number, "stand": self._stand, "done": self._done}
        return JSON, f'{json.dumps(head)[:-1]}, "data": {data}}}'.encode()
