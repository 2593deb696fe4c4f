"""`palpate parts` and `palpate sensors`: what is built in."""

from __future__ import annotations

import typer

from recognition.commands.answering import Json, one_line_errors, print_json


def parts(as_json: Json = False) -> None:
    """List the built-in parts."""
    with one_line_errors():
        from recognition.builtin import part_rows
        from recognition.report.terminal import table_text

        rows = part_rows()
    if as_json:
        print_json({"parts": rows})
    else:
        typer.echo(table_text(rows))


def sensors(as_json: Json = False) -> None:
    """List the built-in tactile arrays."""
    with one_line_errors():
        from recognition.builtin import sensor_rows
        from recognition.report.terminal import table_text

        rows = sensor_rows()
    if as_json:
        print_json({"sensors": rows})
    else:
        typer.echo(table_text(rows))
