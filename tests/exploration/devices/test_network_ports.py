"""An array behind a network port reads as one on a cable."""

import socket
import threading
from collections.abc import Iterator
from contextlib import closing, contextmanager
from itertools import count

import numpy as np
import pytest
import serial
import serial.rfc2217

from exploration.devices.ports import Port
from exploration.devices.serial_array import SerialArray
from exploration.devices.wire import line_text
from exploration.sensing.frame import TaxelArray
from primitives.errors import PalpateError

SMALL = TaxelArray("small", 3, 4, (2.0, 2.0))


def frames(enough: threading.Event) -> Iterator[bytes]:
    for k in count():
        if enough.wait(0.005):
            return
        yield line_text.encode(np.arange(12) + 10 * k, k, 10 * k)


def over_socket(connection: socket.socket, enough: threading.Event) -> None:
    for data in frames(enough):
        connection.sendall(data)


def over_rfc2217(connection: socket.socket, enough: threading.Event) -> None:
    """A port server: what the array says, escaped, and the client's requests answered."""
    port = serial.serial_for_url("loop://", timeout=0)
    connection.settimeout(0.001)
    writer = type("Writer", (), {"write": staticmethod(connection.sendall)})
    manager = serial.rfc2217.PortManager(port, writer)
    for data in frames(enough):
        connection.sendall(b"".join(manager.escape(data)))
        try:
            b"".join(manager.filter(connection.recv(1024)))
        except TimeoutError:
            continue


@contextmanager
def served(kind: str) -> Iterator[tuple[str, threading.Event]]:
    """An address, and the event after which nobody answers there any more."""
    enough = threading.Event()
    server = socket.create_server(("127.0.0.1", 0))

    def serve() -> None:
        connection, _ = server.accept()
        with closing(server), closing(connection):
            {"socket": over_socket, "rfc2217": over_rfc2217}[kind](connection, enough)

    thread = threading.Thread(target=serve, daemon=True)
    thread.start()
    yield f"{kind}://127.0.0.1:{server.getsockname()[1]}", enough
    enough.set()
    thread.join(60.0)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["socket", "rfc2217"])
def test_frames_come_whole_over_the_network_and_a_closed_peer_is_told(kind):
    with served(kind) as (address, enough):
        array = SerialArray(Port(address, 115200), "lines", SMALL, 0.005, np.eye(4))
        array.start()
        try:
            for _ in range(20):
                frame = array.read()
                assert (np.diff(frame.counts.ravel()) == 1).all()
            enough.set()
            with pytest.raises(PalpateError, match=r"is gone|no frame") as caught:
                list(iter(array.read, None))
            assert "\n" not in str(caught.value)
        finally:
            array.close()
