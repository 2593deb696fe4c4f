"""`palpate replay`: a run's page, served to a browser."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from recognition.commands.answering import one_line_errors


def replay(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run, or of a suite.")],
    host: Annotated[str, typer.Option(help="Where to serve it.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="0: any that is free.")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open it there.")] = True,
) -> None:
    """Watch a run in the browser.

    Until Ctrl-C; one that still goes on is shown as far as it is recorded.
    """
    with one_line_errors():
        from recognition.live.replay import replay as show

        show(run, host, port, browser, lambda text: typer.echo(text, err=True))
