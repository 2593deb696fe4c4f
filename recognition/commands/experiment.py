"""`palpate experiment`."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import Annotated

import typer

from recognition.commands import flags
from recognition.commands.answering import Json, one_line_errors, print_json
from recognition.console import interrupts


def experiment(
    suite: Annotated[Path, typer.Argument(metavar="SUITE.toml", help="What is tried with what.")],
    workers: Annotated[
        int | None,
        typer.Option(help="Processes; 0: in this one, one after another.", show_default="one a core"),
    ] = None,
    scheduler: Annotated[
        str, typer.Option(metavar="ADDRESS", help="Of an existing dask cluster.", show_default=False)
    ] = "",
    shard: Annotated[
        str, typer.Option(metavar="i/N", help="Only every N-th trial; all shards may share one --out.")
    ] = "1/1",
    merge: Annotated[
        list[Path] | None, typer.Option(metavar="DIR", help="Take in the rows of another folder, too.")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Go on where a run was ended.")] = False,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the results, new or empty.", show_default="runs/NAME")
    ] = None,
    overwrite: flags.Overwrite = False,
    as_json: Json = False,
) -> None:
    """Run a suite of trials: a table, a summary and a page.

    They are results.parquet, summary.json and report.html; docs/suites has suites to begin with.

    Exit code 0: every trial has its row, failed ones with the reason.
    """
    with one_line_errors(exit_code=2):
        with interrupts.held():
            from recognition.experiments.runner import ExperimentOptions, parse_shard, run

        options = ExperimentOptions(
            suite=suite,
            out=out,
            workers=workers if workers is not None else os.cpu_count() or 1,
            scheduler=scheduler,
            shard=parse_shard(shard),
            resume=resume,
            overwrite=overwrite,
            merge=tuple(merge or ()),
        )
    with one_line_errors():
        summary, folder = run(options, _Progress(quiet=as_json))
    if as_json:
        print_json(summary)
        return
    from recognition.report.suite_terminal import suite_text

    typer.echo(suite_text(summary, folder))


class _Progress:
    """A line on stderr now and then, with the time that is left."""

    def __init__(self, quiet: bool) -> None:
        self._quiet = quiet
        self._began = self._last = time.monotonic()
        self._first: int | None = None

    def __call__(self, ended: int, count: int, bad: int) -> None:
        now = time.monotonic()
        if self._first is None:
            self._first = ended
        if self._quiet or (now - self._last < 2.0 and ended < count):
            return
        self._last = now
        made = ended - self._first
        left = (now - self._began) / made * (count - ended) if made else 0.0
        failed = f", {bad} not done" if bad else ""
        typer.echo(f"{ended} of {count} trials{failed}, {left:.0f} s left", err=True)
