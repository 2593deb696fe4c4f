"""`palpate recognize`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, cast

import typer

from primitives.errors import PalpateError
from recognition.commands import flags
from recognition.commands.answering import Json, one_line_errors, print_json
from recognition.console import interrupts


def recognize(
    source: Annotated[
        str,
        typer.Argument(
            metavar="SOURCE",
            help="A run folder, an episode.mcap, or contacts (.csv, .ply: x,y,z[,nx,ny,nz[,sigma]] in mm).",
            show_default=False,
        ),
    ] = "",
    library: flags.Library = None,
    units: flags.Units = "auto",
    scale: flags.Scale = 1.0,
    prior_center: flags.PriorCenter = None,
    prior_radius: flags.PriorRadius = 200.0,
    contact_sigma: Annotated[
        str, typer.Option(metavar="MM|auto", help="1 sigma of contacts; auto: as told, else estimated.")
    ] = "auto",
    seed: flags.Seed = 0,
    as_json: Json = False,
) -> None:
    """Say which object of a library was touched, and where it is.

    From evidence that exists: nothing is touched.  A contact that a file repeats counts once.
    """
    with one_line_errors(exit_code=2):
        with interrupts.held():
            from models.formats.units import Units as UnitName
            from models.formats.units import checked_flags
            from recognition.recognizing.run import Asked, parse_center
            from recognition.reconstructing.options import parse_sigma

        checked_flags(units, scale)
        asked = Asked(source, parse_sigma(contact_sigma), parse_center(prior_center), prior_radius, seed)
    with _listing_runs_if_unknown(source):
        with interrupts.held():
            from recognition.recognizing.run import recognize as run
            from recognition.recognizing.text import summary_text

        summary = run(asked, library, cast(UnitName, units), scale)
    if as_json:
        print_json(summary)
    else:
        typer.echo(summary_text(summary))


@contextmanager
def _listing_runs_if_unknown(source: str) -> Iterator[None]:
    """After the line that says that a source is not there, list the runs that are."""
    with one_line_errors():
        try:
            if not source:
                raise PalpateError("recognize needs a source: a run folder, or contacts")
            yield
        except PalpateError as error:
            if source and (Path(source).suffix or Path(source).exists()):
                raise
            from recognition.report.terminal import table_text
            from recognition.sources.runs import run_rows

            rows = run_rows()
            there = table_text(rows) if rows else "there is no run yet; palpate explore PART makes one"
            raise PalpateError(f"{error}\n\n{there}") from None
