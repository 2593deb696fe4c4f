"""Serial ports, local or over a network: a thin shell that says what is wrong in one line.

An address is a device (`/dev/ttyUSB0`, `COM3`), `socket://host:port` or `rfc2217://host:port`.
"""

import os
import threading
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

import serial
from serial.tools import list_ports

from primitives.errors import PalpateError

_STUCK = 1.0  # [s] after which a port that takes no bytes is gone
_MOST = 4096  # bytes that are read at once


@dataclass(frozen=True)
class FoundPort:
    """A port that is there."""

    address: str
    description: str
    trouble: str  # why it cannot be opened; empty where it can


class Port:
    """One open port; reading waits `patience` [s] at most, and whatever breaks is a `PalpateError`.

    It is never closed while it is read, and never opened again once its owner has closed it: a thread that is
    slow to end would read what another file's number brings, or take the answers of whoever opened the port next.
    """

    def __init__(self, address: str, baud: int, patience: float = 0.002) -> None:
        self.address, self.baud, self._patience = address, baud, patience
        self._busy, self._given_up = threading.Lock(), False
        self._open()

    def reopened(self) -> bool:
        """Open it again after it had gone; whether it was there, and is still wanted."""
        with self._busy:
            self._shut()
            if self._given_up:
                return False
            try:
                self._open()
            except PalpateError:
                return False
            return True

    def _open(self) -> None:
        address = self.address
        try:
            self._serial = serial.serial_for_url(address, baudrate=self.baud, timeout=self._patience)
            if not address.startswith("rfc2217://"):  # which knows no such timeout
                self._serial.write_timeout = _STUCK
        except PermissionError as error:
            raise PalpateError(_forbidden(address)) from error
        except (serial.SerialException, ValueError, OSError) as error:
            if getattr(error, "errno", None) == 13 or "Permission denied" in str(error):
                raise PalpateError(_forbidden(address)) from error
            raise PalpateError(
                f"cannot open {address}: is it plugged in, and its address right? (palpate hardware scan)"
            ) from error

    def read(self) -> bytes:
        """What has come, at least after waiting once."""
        with self._busy:
            try:
                data: bytes = self._serial.read(1)
                if data and (waiting := self._serial.in_waiting):
                    # a socket tells that something waits, not how much
                    data += self._serial.read(_MOST if self.address.startswith("socket://") else waiting)
            except (serial.SerialException, OSError, TypeError) as error:
                raise self._gone() from error
            return data

    def write(self, data: bytes) -> None:
        """Send bytes."""
        try:
            self._serial.write(data)
        except (serial.SerialException, OSError, TypeError) as error:
            raise self._gone() from error

    def close(self) -> None:
        """Close it for good; a port that is gone is closed."""
        self._given_up = True
        with self._busy:
            self._shut()

    def _shut(self) -> None:
        with suppress(Exception):
            self._serial.close()

    def _gone(self) -> PalpateError:
        return PalpateError(f"{self.address} is gone; check its cable, then begin again")


def scan() -> list[FoundPort]:
    """The ports of this machine."""
    return [
        FoundPort(p.device, p.description or "", trouble(p.device)) for p in sorted(list_ports.comports())
    ]


def trouble(address: str) -> str:
    """Why a local port cannot be opened; empty where it can, as far as permissions go."""
    if os.access(address, os.R_OK | os.W_OK) or not Path(address).exists():
        return ""
    return _forbidden(address)


def _forbidden(address: str) -> str:
    try:
        group = Path(address).group()
    except (OSError, KeyError, NotImplementedError):  # Windows knows no groups
        return f"{address} may not be opened; close the program that holds it"
    return f"{address} may not be opened; join its group: sudo usermod -aG {group} $USER, then log in again"
