"""Pseudo-terminals that are plugged and pulled like cables, each under a name that stays."""

import contextlib
import os
import tty
from pathlib import Path


def plugged(path: str) -> tuple[int, int]:
    """Both ends of a new pseudo-terminal that `path` leads to."""
    master, slave = os.openpty()
    tty.setraw(slave)
    os.set_blocking(master, False)
    Path(path).unlink(missing_ok=True)
    Path(path).symlink_to(os.ttyname(slave))
    return master, slave


def pulled(path: str, *ends: int) -> tuple[int, int]:
    """Both ends closed, the name gone, which might soon lead to another's terminal; what stands for them then."""
    Path(path).unlink(missing_ok=True)
    for end in ends:
        with contextlib.suppress(OSError):
            os.close(end)
    return -1, -1


def read(end: int) -> bytes:
    """What has come; nothing from an end that is gone."""
    with contextlib.suppress(OSError):
        return os.read(end, 4096)
    return b""


def write(end: int, data: bytes) -> int:
    """Send, as far as there is room; how many bytes had, and all of them where the end is gone."""
    try:
        return os.write(end, data)
    except BlockingIOError:
        return 0
    except OSError:
        return len(data)
