"""`palpate report`: a run's page, written anew from its folder."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from recognition.commands.answering import Json, one_line_errors, print_json


def report(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run, or of a suite.")],
    as_json: Json = False,
) -> None:
    """Write a run's report.html again from what is in its folder."""
    with one_line_errors():
        from recognition.report.rewritten import rewrite

        page = rewrite(run)
    if as_json:
        print_json({"command": "report", "run": str(run), "files": {"report": page.name}})
    else:
        typer.echo(f"report: {page}")
