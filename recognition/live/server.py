"""Pages over HTTP, to this machine alone unless told otherwise.

Only who asks for the host by its own name, or by a number, is answered, so that no page of another site can read
them (DNS rebinding).  Every answer is made anew: what is rewritten shows when reloaded.
"""

from __future__ import annotations

import ipaddress
from collections.abc import Callable, Mapping
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import urlsplit

from primitives.errors import PalpateError

HOST = "127.0.0.1"
HTML, JSON = "text/html; charset=utf-8", "application/json; charset=utf-8"
Answer = Callable[
    [str], tuple[str, bytes] | None
]  # from what follows "?" to kind and body; None: not to be had


def server(answers: Mapping[str, Answer], host: str = HOST, port: int = 0) -> ThreadingHTTPServer:
    """What answers under each path, not yet serving."""

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            asked = urlsplit(self.path)
            if not _own_name(self.headers.get("Host") or "", host):
                self.send_error(403)
                return
            made = answers[asked.path](asked.query) if asked.path in answers else None
            if made is None:
                self.send_error(404)
                return
            kind, body = made
            self.send_response(200)
            self.send_header("Content-Type", kind)
            self.send_header("Content-Length", str(len(body)))
            self.send_header("Cache-Control", "no-store")
            self.end_headers()
            self.wfile.write(body)

        def log_message(self, format: str, *args: object) -> None:
            """Nothing: a terminal is not for each request."""

    try:
        return ThreadingHTTPServer((host, port), Handler)
    except (OSError, OverflowError) as error:
        reason = getattr(error, "strerror", None) or error
        raise PalpateError(f"cannot serve at {host}:{port} ({reason}); try another host or port") from error


def address_of(serving: ThreadingHTTPServer) -> str:
    """Where a browser finds it."""
    host, port = serving.server_address[:2]
    return f"http://{host!s}:{port}/"


def parse_address(text: str) -> tuple[str, int]:
    """`HOST`, `:PORT` or `HOST:PORT`; a port of 0 is any that is free."""
    host, colon, port = text.rpartition(":") if ":" in text else (text, "", "")
    if colon and not (port.isdigit() and int(port) < 65536):
        raise PalpateError(f"{text!r} is not HOST:PORT, as {HOST}:8000")
    return host or HOST, int(port or 0)


def _own_name(asked: str, host: str) -> bool:
    name = asked.rpartition(":")[0] or asked
    if name in (host, HOST, "localhost"):
        return True
    try:
        return host != HOST and bool(ipaddress.ip_address(name.strip("[]")))
    except ValueError:
        return False
