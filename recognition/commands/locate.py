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
    facets: flags.Facets = False,
    prior_center: flags.PriorCenter = None,
    prior_radius: flags.PriorRadius = 200.0,
    contact_sigma: Annotated[
        str, typer.Option(metavar="MM|auto", help="1 sigma of contacts; auto: as told, else estimated.")
    ] = "auto",
    seed: flags.Seed = 0,
    as_json: Json = False,
) -> None:
    """Find the pose of one known model from contacts.

    Every pose that explains them is told, with its probability.  A contact that a file repeats counts once.
    """
    with one_line_errors(exit_code=2):
        with interrupts.held():
            from models.formats.units import Units as UnitName
            from models.formats.units import checked_flags
            from recognition.recognizing.run import Asked, parse_center
            from recognition.reconstructing.options import parse_sigma

        checked_flags(units, scale)
        asked = Asked(contacts, parse_sigma(contact_sigma), parse_center(prior_center), prior_radius, seed)
    with one_line_errors():
        look_at_file(model)
        with interrupts.held():
            from recognition.recognizing.run import locate as run
            from recognition.recognizing.text import summary_text

        summary = run(asked, model, cast(UnitName, units), scale, body, facets)
    if as_json:
        print_json(summary)
    else:
        typer.echo(summary_text(summary))
