"""Trials on an existing dask cluster; the only file that imports dask.

A task hands its trial to a process of its own beside the dask worker, so limits hold there as they do here, and
a thread of dask's is never the one that hangs.
"""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from primitives.errors import PalpateError
from recognition.experiments.crew import Worker
from recognition.experiments.suite import Limits
from recognition.experiments.trial import LOST, ROOM, Row, Trial

_mine = threading.local()
_WAIT = 30.0  # [s] for a scheduler to answer
_LOOK = 0.25  # [s]


@dataclass(frozen=True)
class Cluster:
    """A scheduler that answers."""

    client: Any

    def rows(self, trials: Sequence[Trial], kinds: Sequence[str], limits: Limits) -> Iterator[Row]:
        """In the order in which they end."""
        from distributed import as_completed

        futures = {
            self.client.submit(_carry, trial.as_json(), list(kinds), asdict(limits), pure=False): trial
            for trial in trials
        }
        for future in as_completed(list(futures)):
            trial = futures.pop(future)
            if future.status == "finished":
                row: Row = future.result()
            else:
                row = trial.row(LOST, f"dask gave it up ({type(future.exception()).__name__})")
            yield row


@contextmanager
def connected(address: str) -> Iterator[Cluster]:
    """The cluster at an address, or one line why there is none."""
    try:
        from distributed import Client
    except ImportError:
        raise PalpateError('--scheduler needs dask: pip install "palpate[cluster]"') from None
    try:
        client = Client(address, timeout=_WAIT)
    except (OSError, ValueError, TypeError) as error:
        raise PalpateError(
            f"no dask scheduler answers at {address} ({(str(error) or type(error).__name__).splitlines()[0]})"
        ) from error
    with client:
        yield Cluster(client)


def _carry(told: Mapping[str, Any], kinds: Sequence[str], limits: Mapping[str, float]) -> Row:
    worker: Worker | None = getattr(_mine, "worker", None)
    if worker is None:
        scratch = Path(tempfile.mkdtemp(prefix=ROOM))
        worker = _mine.worker = Worker(tuple(kinds), Limits(**limits), scratch)
    worker.limits = Limits(**limits)
    ended = threading.Event()
    threading.Thread(target=_watch, args=(worker, ended), daemon=True).start()
    try:
        return worker.carry(Trial.from_json(told), None)
    finally:
        ended.set()


def _watch(worker: Worker, ended: threading.Event) -> None:
    while not ended.wait(_LOOK):
        worker.look()
