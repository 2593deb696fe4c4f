"""`palpate probe`."""

from __future__ import annotations

from typing import Annotated

import typer

from recognition.commands import flags
from recognition.commands.answering import Json, one_line_errors, print_json
from recognition.commands.part_argument import listing_parts_if_unknown, look_at_file
from recognition.commands.run_flags import Latency, Part, RunFlags, spread
from recognition.console import interrupts


@spread
def probe(
    part: Part = "",
    procedure: Annotated[
        str,
        typer.Argument(metavar="PROCEDURE", help="What to do there; without one, all procedures are listed."),
    ] = "",
    force_n: Annotated[float, typer.Option(help="Of an approach, and of compliance [N].")] = 20.0,
    stiffness: Annotated[
        float | None,
        typer.Option(help="Of the simulated object [N/mm^3].", show_default="rigid"),
    ] = None,
    roughness_mm: Annotated[
        float | None,
        typer.Option(help="Of the simulated object, root mean square [mm].", show_default="smooth"),
    ] = None,
    material: Annotated[
        str | None,
        typer.Option(metavar="FILE.toml", help="Both of these, face by face.", show_default=False),
    ] = None,
    latency_s: Latency = 0.02,
    max_touches: flags.MaxTouches = 500,
    *,
    told: RunFlags,
    as_json: Json = False,
) -> None:
    """Carry one exploratory procedure out on an object.

    It finds the object, lies on it, and says what it felt.

    Exit code 0: the run is whole. 1: it could not begin, or the procedure could not be carried out.
    """
    with one_line_errors(exit_code=2):
        with interrupts.held():
            from recognition.probing.options import ProbeOptions

        options = told.options(
            ProbeOptions,
            part=part,
            procedure=procedure,
            force_n=force_n,
            stiffness_n_mm3=stiffness,
            roughness_mm=roughness_mm,
            material=material,
            latency_s=latency_s,
            max_touches=max_touches,
        )
    with one_line_errors():
        from recognition.probing.text import requested

        requested(options)
    with listing_parts_if_unknown(part, "probe"):
        look_at_file(part)
        with interrupts.held():
            from recognition.console import compiling
            from recognition.probing.run import run
            from recognition.probing.text import summary_text
            from recognition.tracking.view import viewing

        with viewing(quiet=as_json) as view, compiling.told(view.say):
            summary = run(options, view)
    if as_json:
        print_json(summary)
    else:
        typer.echo(summary_text(summary, view.folder))
