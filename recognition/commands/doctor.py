"""`palpate doctor`."""

from __future__ import annotations

import typer

from recognition.commands.answering import Json, one_line_errors, print_json


def doctor(as_json: Json = False) -> None:
    """Say what is installed, what is missing and what collides."""
    with one_line_errors():
        from recognition.doctor import examine

        findings = examine()
    if as_json:
        print_json(findings.as_json())
    else:
        typer.echo(findings.as_text())
    if not findings.healthy:
        raise typer.Exit(1)
