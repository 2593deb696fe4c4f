"""How a command answers: one JSON object on stdout, or one line on stderr and an exit code."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Annotated

import typer

from primitives.errors import PalpateError
from recognition.console import interrupts

INTERRUPTED = "interrupted; what was recorded until then is whole"
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout and nothing else there.")]


@contextmanager
def one_line_errors(exit_code: int = 1) -> Iterator[None]:
    """A known error is one line on stderr and exit 1; Ctrl-C is one line and exit 130, SIGTERM 143."""
    try:
        yield
    except PalpateError as error:
        typer.echo(f"palpate: {error}", err=True)
        raise typer.Exit(exit_code) from None
    except (KeyboardInterrupt, SystemError) as error:
        interrupt = interrupts.behind(error)
        if interrupt is None:
            raise
        typer.echo(f"palpate: {INTERRUPTED}", err=True)
        raise typer.Exit(interrupts.asked() or 130) from None


def print_json(value: Mapping[str, object]) -> None:
    """One JSON object on stdout."""
    from recognition.running.folder import json_text

    typer.echo(json_text(value))
