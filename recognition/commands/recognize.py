"""`palpate recognize`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, cast

import typer

from recognition.commands import flags
from recognition.commands.answering import Json, one_line_errors, print_json
from recognition.console import interrupts


def recognize(
    source: Annotated[
        str,
        typer.Argument(
            metavar="SOURCE",
            help="A run folder, an episode.mcap, or contacts (.csv, .ply: x,y,z[,nx,ny,nz[,sigma]] in mm).",
        ),
    ],
    library: Annotated[Path, typer.Option("--library", metavar="DIR", help="A folder of CAD files.")],
    units: flags.Units = "auto",
    scale: flags.Scale = 1.0,
    contact_sigma: Annotated[
        str, typer.Option(metavar="MM|auto", help="1 sigma of contacts; auto: as told, else estimated.")
    ] = "auto",
    seed: flags.Seed = 0,
    as_json: Json = False,
) -> None:
    """Say which object of a library was touched, and where it is.

    From evidence that exists: nothing is touched.
    """
    with one_line_errors(exit_code=2):
        with interrupts.held():
            from models.formats.units import Units as UnitName
            from models.formats.units import checked_flags
            from recognition.recognizing.run import Asked
            from recognition.reconstructing.options import parse_sigma

        checked_flags(units, scale)
        asked = Asked(source, parse_sigma(contact_sigma), seed=seed)
    with one_line_errors():
        with interrupts.held():
            from recognition.recognizing.run import recognize as run
            from recognition.recognizing.text import summary_text

        summary = run(asked, library, cast(UnitName, units), scale)
    if as_json:
        print_json(summary)
    else:
        typer.echo(summary_text(summary))
