"""`palpate reconstruct`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from recognition.commands import flags
from recognition.commands.answering import Json, one_line_errors, print_json
from recognition.console import interrupts


def reconstruct(
    source: Annotated[
        str,
        typer.Argument(
            metavar="SOURCE",
            help="A run folder, an episode.mcap, or contacts (.csv, .ply: x,y,z[,nx,ny,nz[,sigma]] in mm).",
        ),
    ],
    contact_sigma: Annotated[
        str,
        typer.Option(
            metavar="MM|auto",
            help="1 sigma of the contacts along the normal; auto: as the file says, else estimated.",
        ),
    ] = "auto",
    seed: flags.Seed = 0,
    out: flags.Out = None,
    overwrite: flags.Overwrite = False,
    as_json: Json = False,
) -> None:
    """Reconstruct an object as CSG from evidence that exists.

    A run, a recording, or any cloud of contacts, of which those read at one place count once.

    Exit code 0: the model is written, or the summary says why there is none. 1: the source could not be read.
    """
    with one_line_errors(exit_code=2):
        with interrupts.held():
            from recognition.reconstructing.options import ReconstructSourceOptions, parse_sigma

        options = ReconstructSourceOptions(Path(source), parse_sigma(contact_sigma), seed, out, overwrite)
    with one_line_errors():
        with interrupts.held():
            from recognition.console import compiling
            from recognition.reconstructing.run import run
            from recognition.reconstructing.text import summary_text
            from recognition.report.terminal import watching

        with watching(quiet=as_json) as watch, compiling.told(watch.say):
            summary = run(options, watch)
    if as_json:
        print_json(summary)
    else:
        typer.echo(summary_text(summary, watch.folder))
