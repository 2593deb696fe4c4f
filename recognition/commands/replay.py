"""`palpate replay`: a run's page, served to the browser of this machine."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from recognition.commands.answering import one_line_errors


def replay(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run, or of a suite.")],
    port: Annotated[int, typer.Option(min=0, max=65535, help="0: any that is free.")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open it there.")] = True,
) -> None:
    """Watch a run in the browser, served on 127.0.0.1 until Ctrl-C."""
    with one_line_errors():
        from recognition.report.served import serve

        serve(run, port, browser, lambda text: typer.echo(text, err=True))
