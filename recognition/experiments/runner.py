"""A suite, run: in this process, on workers, on a cluster or in shards; the table is the same.

Each trial draws everything random from its own seed, on one thread.  Rows are written as they come; when this
shard's are there, the table, the summary and the page are written from all rows of the folder.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from primitives.errors import PalpateError
from recognition.console import interrupts
from recognition.experiments.account import account
from recognition.experiments.carried import carried
from recognition.experiments.cluster import Cluster
from recognition.experiments.crew import Crew
from recognition.experiments.folder import SuiteFolder
from recognition.experiments.log import Log, rows_of
from recognition.experiments.suite import Suite, load_suite
from recognition.experiments.table import write_table
from recognition.experiments.trial import ROOM, Row, Trial

Told = Callable[[int, int, int], object]  # rows there are, of how many, how many of them not done


@dataclass(frozen=True)
class ExperimentOptions:
    """Everything `palpate experiment` can be told."""

    suite: Path
    out: Path | None = None
    workers: int = 1  # 0: in this process
    scheduler: str = ""
    shard: tuple[int, int] = (1, 1)
    resume: bool = False
    overwrite: bool = False
    merge: tuple[Path, ...] = ()  # folders of other shards

    def __post_init__(self) -> None:
        if self.workers < 0:
            raise PalpateError(f"--workers must be 0 (in this process) or more, not {self.workers}")
        if self.overwrite and self.resume:
            raise PalpateError("--resume goes on and --overwrite begins anew; give one of them")
        if self.overwrite and self.shard[1] > 1:
            raise PalpateError(
                "--overwrite with --shard would remove the rows of other shards; give a new --out"
            )


def parse_shard(text: str) -> tuple[int, int]:
    """`i/N`, as 1/4 to 4/4; 0/4 is the last one, so that arrays of jobs may count from 0."""
    first, _, last = text.partition("/")
    if not (first.isdigit() and last.isdigit() and int(last) >= 1 and int(first) <= int(last)):
        raise PalpateError(f"--shard {text!r} is not i/N, as 1/4, 2/4, 3/4, 4/4")
    return int(first) or int(last), int(last)


def run(options: ExperimentOptions, told: Told = lambda *_: None) -> tuple[dict[str, Any], Path]:
    """Run what is not there yet of a suite, and write its results; the summary, and the folder."""
    began = time.perf_counter()
    suite = load_suite(options.suite)
    shards = options.shard[1]
    merged = [SuiteFolder.merged(suite, path).path for path in options.merge]
    with _connected(options.scheduler) as cluster:
        folder = SuiteFolder.of(suite, options.out, options.resume, options.overwrite, shards > 1)
        folders = (folder.path, *merged)
        _fill(suite, options, folder, folders, cluster, told)
    summary = write_results(suite, folder, folders, time.perf_counter() - began)
    return summary, folder.path


def _fill(
    suite: Suite,
    options: ExperimentOptions,
    folder: SuiteFolder,
    folders: Iterable[Path],
    cluster: Cluster | None,
    told: Told,
) -> None:
    """Run every trial of this shard that has no row yet."""
    number, shards = options.shard
    there = rows_of(folders)
    mine = [trial for trial in suite.trials if trial.number % shards == number - 1]
    open_ = [trial for trial in mine if trial.number not in there]
    name = "trials.jsonl" if shards == 1 else f"trials-{number}-of-{shards}.jsonl"
    keep = folder.path / "runs" if suite.keep_runs else None
    ended, bad = len(mine) - len(open_), 0
    told(ended, len(mine), bad)
    with Log(folder.path / name) as log:
        for row in _rows(open_, suite, options.workers, keep, cluster):
            log.append(row)
            ended, bad = ended + 1, bad + (row["outcome"] != "done")
            told(ended, len(mine), bad)
            interrupts.checkpoint()


def write_results(
    suite: Suite, folder: SuiteFolder, folders: Iterable[Path], wall_seconds: float
) -> dict[str, Any]:
    """Table, page and summary from all rows of the folders."""
    from recognition.report.suite_page import suite_html

    with folder.locked():
        rows = list(rows_of(folders).values())
        summary = account(suite, rows, wall_seconds)
        with folder.writing("results.parquet") as path:
            write_table(path, suite, rows)
        folder.write_text("report.html", suite_html(summary))
        folder.finish(summary)
    return summary


def _connected(address: str) -> AbstractContextManager[Cluster | None]:
    """The cluster, before anything is written; none without an address."""
    if not address:
        return nullcontext()
    from recognition.experiments.cluster import connected

    return connected(address)


def _rows(
    trials: list[Trial], suite: Suite, workers: int, keep: Path | None, cluster: Cluster | None
) -> Iterator[Row]:
    kinds = sorted({trial.kind for trial in trials})
    if cluster is not None:
        yield from cluster.rows(trials, kinds, suite.limits)
    elif not trials:
        return
    elif workers == 0:
        with tempfile.TemporaryDirectory(prefix=ROOM) as room:
            for trial in trials:
                kept = keep / f"{trial.number:06d}" if keep else None
                yield carried(trial, Path(room) / "trial", suite.limits, kept)
    else:
        with Crew(min(workers, len(trials)), kinds, suite.limits, keep) as crew:
            yield from crew.run(trials)
