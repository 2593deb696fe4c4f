"""A worker: reads trials as JSON, one a line, and answers each with its row.

Run as ``python -m recognition.experiments.worker SCRATCH`` by a crew, which sets its threads to one.  It ends with
whoever started it: when its input closes, in the middle of a trial too.
"""

from __future__ import annotations

import json
import os
import queue
import shutil
import signal
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any, TextIO

from recognition.experiments.carried import carried
from recognition.experiments.kinds import KINDS
from recognition.experiments.suite import Limits
from recognition.experiments.trial import MEMORY, ROOM, Trial


def main(scratch: Path) -> None:
    """Serve until the input closes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever started it decides
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what libraries print must not get between the answers
    orders: queue.Queue[dict[str, Any]] = queue.Queue()
    threading.Thread(target=_listen, args=(sys.stdin, orders, scratch), daemon=True).start()
    order = orders.get()
    for name in order["kinds"]:
        KINDS[name].carry  # noqa: B018  imports it, outside any trial's time
    _answer(answers, {"ready": True})
    while True:
        order = orders.get()
        keep = Path(order["keep"]) if order["keep"] else None
        row = carried(Trial.from_json(order["trial"]), scratch, Limits(**order["limits"]), keep)
        _answer(answers, row)
        if row["outcome"] == MEMORY:  # a heap that ran full is not trusted with the next trial
            os._exit(0)


def _listen(source: TextIO, orders: queue.Queue[dict[str, Any]], scratch: Path) -> None:
    for line in source:
        orders.put(json.loads(line))
    shutil.rmtree(scratch, ignore_errors=True)
    if scratch.parent.name.startswith(ROOM):  # a crew's, which was killed where it could not clear up itself
        with suppress(OSError):
            scratch.parent.rmdir()
    os._exit(0)


def _answer(answers: TextIO, told: object) -> None:
    answers.write(json.dumps(told) + "\n")
    answers.flush()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
