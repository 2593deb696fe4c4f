"""`palpate locate`."""

from __future__ import annotations

from typing import Annotated, cast

import typer

from recognition.commands import flags
from recognition.commands.answering import Json, one_line_errors, print_json
from recognition.commands.part_argument import look_at_file
from recognition.console import interrupts


def locate(
    contacts: Annotated[
        str,
        typer.Argument(
            metavar="CONTACTS", help="Contacts (.csv, .ply: x,y,z[,nx,ny,nz[,sigma]] in mm), or a run."
        ),
    ],
    model: Annotated[
        str, typer.Argument(metavar="MODEL", help="A CAD file, or a built-in part (palpate parts).")
    ],
    units: flags.Units = "auto",
    scale: flags.Scale = 1.0,
    body: flags.Body = None,
    prior_center: Annotated[
        str | None,
        typer.Option(metavar="X,Y,Z", help="Where its middle may be [mm].", show_default="the contacts"),
    ] = None,
    prior_radius: Annotated[float, typer.Option(help="How far from there [mm].")] = 200.0,
    contact_sigma: Annotated[
        str, typer.Option(metavar="MM|auto", help="1 sigma of contacts; auto: as told, else estimated.")
    ] = "auto",
    seed: flags.Seed = 0,
    as_json: Json = False,
) -> None:
    """Find the pose of one known model from contacts.

    Every pose that explains them is told, with its probability.
    """
    with one_line_errors(exit_code=2):
        with interrupts.held():
            from models.formats.units import Units as UnitName
            from models.formats.units import checked_flags
            from recognition.config import parse_numbers
            from recognition.recognizing.run import Asked
            from recognition.reconstructing.options import parse_sigma

        checked_flags(units, scale)
        center = (
            None if prior_center is None else parse_numbers(prior_center, 3, "--prior-center", "X,Y,Z in mm")
        )
        asked = Asked(contacts, parse_sigma(contact_sigma), center, prior_radius, seed)
    with one_line_errors():
        look_at_file(model)
        with interrupts.held():
            from recognition.recognizing.run import locate as run
            from recognition.recognizing.text import summary_text

        summary = run(asked, model, cast(UnitName, units), scale, body)
    if as_json:
        print_json(summary)
    else:
        typer.echo(summary_text(summary))
