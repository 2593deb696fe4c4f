"""`palpate report`: a run's page, written anew from its folder."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from recognition.commands.answering import one_line_errors


def report(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run, or of a suite.")],
) -> None:
    """Write a run's report.html again from what is in its folder."""
    with one_line_errors():
        from recognition.report.rewritten import rewrite

        typer.echo(f"report: {rewrite(run)}")
