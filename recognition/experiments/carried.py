"""A trial carried out here and now: within its limits, and whatever happens is a row.

Time ends by an alarm, memory by a limit on the data of this process (neither reaches into a hanging kernel, for
which whoever started a worker kills it); where the system has no alarm or no limit there is none.
"""

from __future__ import annotations

import math
import shutil
import signal
import threading
import time
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import FrameType

from primitives.errors import NotWritten, PalpateError
from recognition.console.bugs import named
from recognition.experiments.kinds import KINDS
from recognition.experiments.settings import Value
from recognition.experiments.suite import Limits
from recognition.experiments.trial import DONE, FAILED, MEMORY, TIMEOUT, Row, Trial, Work


class _OutOfTime(BaseException):
    """The alarm of a trial."""


def carried(trial: Trial, scratch: Path, limits: Limits, keep: Path | None = None) -> Row:
    """The row of one trial; `scratch` is its folder, and what is in it goes to `keep` or nowhere."""
    scratch.mkdir(parents=True, exist_ok=True)
    kind = KINDS[trial.kind]
    began = time.perf_counter()
    try:
        with _within(limits):
            told = kind.carry(trial.settings, Work(Path(trial.base), scratch))
        metrics = {name: _plain(told.get(name), metric.type) for name, metric in kind.metrics.items()}
        return trial.row(DONE, "", metrics, time.perf_counter() - began)
    except _OutOfTime:
        return timeout(trial, limits, time.perf_counter() - began)
    except MemoryError:
        return memory(trial, limits, time.perf_counter() - began)
    except NotWritten as error:
        return trial.row(FAILED, _line(error, scratch), None, time.perf_counter() - began)
    except PalpateError as error:
        if isinstance(error.__cause__, MemoryError):
            return memory(trial, limits, time.perf_counter() - began)
        return trial.row(FAILED, _line(error, scratch), None, time.perf_counter() - began)
    except Exception as error:
        last = traceback.extract_tb(error.__traceback__)[-1]
        where = f"{Path(last.filename).name}:{last.lineno}"
        return trial.row(
            FAILED, f"bug in palpate: {named(error)} ({where})", None, time.perf_counter() - began
        )
    finally:
        with suppress(OSError):
            if keep is not None:
                shutil.copytree(scratch, keep, dirs_exist_ok=True)
            shutil.rmtree(scratch, ignore_errors=True)


def timeout(trial: Trial, limits: Limits, seconds: float) -> Row:
    """The row of a trial that was ended for its time."""
    return trial.row(TIMEOUT, f"took longer than {limits.seconds:g} s ([limits] seconds)", None, seconds)


def memory(trial: Trial, limits: Limits, seconds: float) -> Row:
    """The row of a trial that was ended for its memory."""
    return trial.row(MEMORY, f"needed more than {limits.memory_mb:g} MB ([limits] memory_mb)", None, seconds)


def _line(error: Exception, scratch: Path) -> str:
    """The error as one line that is the same wherever it ran."""
    text = str(error).splitlines()[0] if str(error) else type(error).__name__
    return text.replace(str(scratch), "its folder")


def _plain(value: object, wanted: type) -> Value:
    """A metric as its column's type; what is not finite or not there is null."""
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return None
    out: Value = wanted(value)
    return out


@contextmanager
def _within(limits: Limits) -> Iterator[None]:
    with _less_memory_than(limits.memory_mb):
        if threading.current_thread() is not threading.main_thread() or not hasattr(signal, "setitimer"):
            yield
            return
        before = signal.signal(signal.SIGALRM, _ring)
        signal.setitimer(signal.ITIMER_REAL, limits.seconds)
        try:
            yield
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, before)


def _ring(number: int, frame: FrameType | None) -> None:
    raise _OutOfTime


@contextmanager
def _less_memory_than(megabytes: float) -> Iterator[None]:
    """On Linux, so much more than what the process holds already."""
    try:
        import resource

        held = _data_bytes()
    except (ImportError, OSError):
        yield
        return
    soft, hard = resource.getrlimit(resource.RLIMIT_DATA)
    wanted = held + int(megabytes * 1e6)
    resource.setrlimit(
        resource.RLIMIT_DATA, (wanted if hard == resource.RLIM_INFINITY else min(wanted, hard), hard)
    )
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_DATA, (soft, hard))


def _data_bytes() -> int:
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith("VmData:"):
            return 1024 * int(line.split()[1])
    return 0
