"""The page of a run over HTTP, to this machine alone.

Only `report.html` is answered, and only to who asks for this host by its own name, so that no page of another
site can read it (DNS rebinding).  The file is read anew each time: a page that is rewritten shows when reloaded.
"""

from __future__ import annotations

import webbrowser
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

from primitives.errors import PalpateError

HOST = "127.0.0.1"
PAGE = "report.html"


def serve(run: Path, port: int, browser: bool, say: Callable[[str], object]) -> None:
    """Until it is interrupted."""
    with server(run, port) as serving:
        address = f"http://{HOST}:{serving.server_address[1]}/"
        say(f"{run} is at {address} until Ctrl-C")
        if browser:
            webbrowser.open(address)
        serving.serve_forever()


def server(run: Path, port: int) -> ThreadingHTTPServer:
    """What answers, not yet serving; refuses a folder without a page."""
    page = run / PAGE
    if not page.is_file():
        raise PalpateError(f"{run} has no {PAGE}; give the folder of a run that has ended")

    class Answer(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked = (self.headers.get("Host") or "").rpartition(":")[0]
            if asked not in (HOST, "localhost"):
                self.send_error(403)
            elif self.path not in ("/", f"/{PAGE}"):
                self.send_error(404)
            else:
                self._page()

        def _page(self) -> None:
            body = page.read_bytes()
            self.send_response(200)
            self.send_header("Content-Type", "text/html; charset=utf-8")
            self.send_header("Content-Length", str(len(body)))
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, format: str, *args: object) -> None:
            """Nothing: a terminal is not for each request."""

    try:
        return ThreadingHTTPServer((HOST, port), Answer)
    except OSError as error:
        raise PalpateError(
            f"cannot serve at port {port} ({error.strerror or error}); try another --port"
        ) from error
