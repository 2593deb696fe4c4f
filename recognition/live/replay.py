"""`palpate replay`: the page of a run that has ended, or of one that still goes on, as far as it is recorded."""

from __future__ import annotations

import webbrowser
from collections.abc import Callable
from http.server import ThreadingHTTPServer
from pathlib import Path

from primitives.errors import PalpateError
from recognition.live.server import HOST, HTML, address_of, server
from recognition.report.page import report_html
from recognition.report.rewritten import so_far
from recognition.running.folder import RECORDING

PAGE = "report.html"
_AGAIN = 5  # [s] after which the page of a run that goes on is asked for again


def replay(run: Path, host: str, port: int, browser: bool, told: Callable[[str], object]) -> None:
    """Until it is interrupted; `told` is given the address."""
    with serving(run, host, port) as made:
        told(address_of(made))
        if browser:
            webbrowser.open(address_of(made))
        made.serve_forever()


def serving(run: Path, host: str = HOST, port: int = 0) -> ThreadingHTTPServer:
    """What answers, not yet serving; refuses a folder with neither a page nor a recording."""
    if not (run / PAGE).is_file() and not (run / RECORDING).is_file():
        raise PalpateError(f"{run} has neither {PAGE} nor {RECORDING}; give the folder of a run")

    def page(query: str) -> tuple[str, bytes] | None:
        return HTML, _page(run)

    return server({"/": page, f"/{PAGE}": page}, host, port)


def _page(run: Path) -> bytes:
    if (run / PAGE).is_file():
        return (run / PAGE).read_bytes()
    html = report_html(so_far(run))
    again = f'<meta http-equiv="refresh" content="{_AGAIN}"><title>'
    return html.replace("<title>", again, 1).encode()
