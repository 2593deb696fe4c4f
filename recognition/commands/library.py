"""`palpate library`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from recognition import flags
from recognition.commands.answering import Json, one_line_errors, print_json
from recognition.commands.part_argument import look_at_file
from recognition.console import interrupts

app = typer.Typer(
    help="Models to recognize, and their boundaries.", no_args_is_help=True, rich_markup_mode=None
)


@app.command("show")
def library_show(
    file: Annotated[str, typer.Argument(help="A CAD file, or a built-in part (palpate parts).")],
    units: flags.Units = "auto",
    scale: flags.Scale = 1.0,
    body: flags.Body = None,
    facets: flags.Facets = False,
    out: Annotated[
        Path | None, typer.Option(metavar="PAGE.html", help="Also draw it as a page.", show_default=False)
    ] = None,
    as_json: Json = False,
) -> None:
    """Draw one model's boundary: faces by shape, edges by kind, which face meets which."""
    with one_line_errors(exit_code=2):
        from models.formats.units import checked_flags

        checked_flags(units, scale)
    with one_line_errors():
        look_at_file(file)
        with interrupts.held():
            from recognition.library_show import show, write_page

        shown = show(file, units, scale, body, facets)
        if out is not None:
            write_page(shown, out)
    if as_json:
        print_json(shown.summary)
    else:
        from recognition.report.boundary_terminal import print_boundary

        print_boundary(shown.summary)
        if out is not None:
            typer.echo(f"page: {out}", err=True)
