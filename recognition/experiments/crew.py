"""Workers as processes of their own, watched: one that hangs, grows too large or is lost costs its trial alone.

Each has a thread here that hands it trials and waits for rows; `run` watches their clocks and their memory
meanwhile.  A worker runs on one thread, so that as many as there are cores never get in each other's way.
"""

from __future__ import annotations

import json
import os
import queue
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass
from pathlib import Path
from types import TracebackType
from typing import IO

from primitives.errors import PalpateError
from recognition.experiments import carried
from recognition.experiments.suite import Limits
from recognition.experiments.trial import LOST, MEMORY, ROOM, TIMEOUT, Row, Trial

ONE_THREAD = {
    f"{library}_NUM_THREADS": "1"
    for library in ("OMP", "OPENBLAS", "MKL", "NUMBA", "NUMEXPR", "VECLIB_MAXIMUM")
}
_LOOK = 0.25  # [s] between two looks at clocks and memory
_GRACE = 5.0  # [s] past its limit, in which a worker may end its trial by itself
_TAIL, _LINE = 4096, 200  # characters of what a worker wrote that are read, and told
_ROOM = 1.25  # times the memory limit, at which a worker that does not notice is killed


@dataclass
class Worker:
    """One process."""

    kinds: Sequence[str]
    limits: Limits
    scratch: Path
    process: subprocess.Popen[str] | None = None
    said: IO[str] | None = None  # what it and its libraries write on their standard error
    began: float = 0.0  # 0: idle
    floor: int = 0  # [bytes] resident before its first trial
    killed: str = ""  # for which reason

    def carry(self, trial: Trial, keep: Path | None) -> Row:
        """The row of a trial, whatever happens to the process."""
        process = self._running()
        self.killed, self.began = "", time.monotonic()
        order = {
            "trial": trial.as_json(),
            "limits": asdict(self.limits),
            "keep": None if keep is None else str(keep.absolute()),
        }
        answer = _exchange(process, order)
        took = time.monotonic() - self.began
        self.began = 0.0
        if answer:
            row: Row = json.loads(answer)
            if row["outcome"] == MEMORY:
                self.end()
            return row
        code, last = process.wait(), self._last_word()
        self.end()
        if self.killed == TIMEOUT:
            return carried.timeout(trial, self.limits, took)
        if self.killed == MEMORY:
            return carried.memory(trial, self.limits, took)
        how = f"by signal {-code}" if code < 0 else f"with exit code {code}"
        return trial.row(LOST, f"its worker ended {how}{last and f' ({last})'}", None, took)

    def look(self) -> None:
        """Kill it if it is past its limits."""
        process, began = self.process, self.began
        if process is None or not began:
            return
        if time.monotonic() - began > self.limits.seconds + _GRACE:
            self.killed = TIMEOUT
        elif _resident(process.pid) - self.floor > _ROOM * self.limits.memory_mb * 1e6:
            self.killed = MEMORY
        if self.killed:
            process.kill()

    def end(self) -> None:
        """Stop the process, and clear up behind it."""
        process, self.process = self.process, None
        if process is not None:
            process.kill()
            process.wait()
            for pipe in (process.stdin, process.stdout):
                if pipe is not None:
                    with suppress(OSError):
                        pipe.close()
        if self.said is not None:
            self.said.close()
            self.said = None
        shutil.rmtree(self.scratch, ignore_errors=True)

    def _running(self) -> subprocess.Popen[str]:
        if self.process is not None and self.process.poll() is None:
            return self.process
        self.end()
        self.said = tempfile.TemporaryFile("w+", encoding="utf-8", errors="replace")  # noqa: SIM115  until end
        self.process = subprocess.Popen(
            [sys.executable, "-m", "recognition.experiments.worker", str(self.scratch)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self.said,
            text=True,
            encoding="utf-8",
            env={**os.environ, **ONE_THREAD, "PYTHONHASHSEED": "0"},
            start_new_session=True,
        )
        if not _exchange(self.process, {"kinds": list(self.kinds)}):
            last = self._last_word() or "it said nothing"
            raise PalpateError(f"a worker does not start ({last}); `palpate doctor` says what is missing")
        self.floor = _resident(self.process.pid)
        return self.process

    def _last_word(self) -> str:
        """The last line that it wrote on its standard error."""
        if self.said is None:
            return ""
        self.said.seek(max(0, self.said.seek(0, os.SEEK_END) - _TAIL))
        return (self.said.read().strip().splitlines() or [""])[-1][:_LINE]


class Crew:
    """So many workers; a context manager that ends them."""

    def __init__(self, count: int, kinds: Sequence[str], limits: Limits, keep: Path | None = None) -> None:
        self._room = Path(tempfile.mkdtemp(prefix=ROOM))
        self._keep = keep
        self._workers = [Worker(kinds, limits, self._room / str(k)) for k in range(count)]
        self._rows: queue.Queue[Row | Exception] = queue.Queue()
        self._ended = False

    def run(self, trials: Iterable[Trial]) -> Iterator[Row]:
        """Their rows, in the order in which they end."""
        waiting: queue.SimpleQueue[Trial] = queue.SimpleQueue()
        count = 0
        for trial in trials:
            waiting.put(trial)
            count += 1
        for worker in self._workers:
            threading.Thread(target=self._serve, args=(worker, waiting), daemon=True).start()
        while count:
            try:
                row = self._rows.get(timeout=_LOOK)
            except queue.Empty:
                for worker in self._workers:
                    worker.look()
                continue
            if isinstance(row, Exception):
                raise row
            count -= 1
            yield row

    def _serve(self, worker: Worker, waiting: queue.SimpleQueue[Trial]) -> None:
        try:
            while not self._ended:
                trial = waiting.get_nowait()
                keep = self._keep / f"{trial.number:06d}" if self._keep else None
                self._rows.put(worker.carry(trial, keep))
        except queue.Empty:
            return
        except Exception as error:
            self._rows.put(error)

    def __enter__(self) -> Crew:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ended = True
        for worker in self._workers:
            worker.end()
        shutil.rmtree(self._room, ignore_errors=True)


def _exchange(process: subprocess.Popen[str], order: object) -> str:
    """What a worker answers; nothing where it has ended."""
    assert process.stdin is not None
    assert process.stdout is not None
    try:
        process.stdin.write(json.dumps(order) + "\n")
        process.stdin.flush()
        answer = process.stdout.readline()
    except (OSError, ValueError):
        return ""
    return answer if answer.endswith("\n") else ""


def _resident(process: int) -> int:
    """[bytes] of memory that a process holds; 0 where the system does not say."""
    try:
        pages = int(Path(f"/proc/{process}/statm").read_text(encoding="ascii").split()[1])
    except (OSError, ValueError, IndexError):
        return 0
    return pages * os.sysconf("SC_PAGE_SIZE")
