"""`palpate replay`: a run's page, served to a browser."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from recognition.commands.answering import Json, one_line_errors, print_json


def replay(
    run: Annotated[Path, typer.Argument(metavar="RUN", help="Folder of a run, or of a suite.")],
    host: Annotated[str, typer.Option(help="Where to serve it.")] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="0: any that is free.")] = 0,
    browser: Annotated[bool, typer.Option("--browser/--no-browser", help="Open it there.")] = True,
    as_json: Json = False,
) -> None:
    """Watch a run in the browser.

    Until Ctrl-C; one that still goes on is shown as far as it is recorded.
    """
    with one_line_errors():
        from recognition.live.replay import replay as show

        def told(address: str) -> None:
            if as_json:
                print_json({"command": "replay", "run": str(run), "address": address})
                sys.stdout.flush()
            else:
                typer.echo(f"{run} is at {address} until Ctrl-C", err=True)

        show(run, host, port, browser, told)
