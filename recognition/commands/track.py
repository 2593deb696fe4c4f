"""`palpate track`."""

from __future__ import annotations

from typing import Annotated

import typer

from primitives.errors import PalpateError
from recognition.commands import flags
from recognition.commands.answering import Json, one_line_errors, print_json
from recognition.commands.part_argument import listing_parts_if_unknown, look_at_file
from recognition.commands.run_flags import Latency, Part, RunFlags, spread
from recognition.console import interrupts


@spread
def track(
    what: Annotated[str, typer.Argument(metavar="WHAT", help="What to follow: edge or surface.")],
    part: Part = "",
    device: flags.Device = None,
    speed_mm_s: Annotated[float, typer.Option(help="Along the edge, or over the surface [mm/s].")] = 20.0,
    latency_s: Latency = 0.02,
    max_touches: flags.MaxTouches = 500,
    *,
    told: RunFlags,
    as_json: Json = False,
) -> None:
    """Follow an edge or a surface of an object.

    It begins at a contact that it finds.

    Exit code 0: the run is whole, and its summary says how it ended. 1: it could not begin, or followed nothing.
    """
    with one_line_errors(exit_code=2):
        with interrupts.held():
            from recognition.tracking.options import TrackOptions

        options = told.options(
            TrackOptions,
            part=part,
            device=device,
            what=what,
            speed_mm_s=speed_mm_s,
            latency_s=latency_s,
            max_touches=max_touches,
        )
    with listing_parts_if_unknown(device or part, "track"):
        look_at_file(part)
        with interrupts.held():
            from recognition.console import compiling
            from recognition.tracking.run import run
            from recognition.tracking.text import nothing_followed, summary_text
            from recognition.tracking.view import viewing

        with viewing(quiet=as_json) as view, compiling.told(view.say):
            summary = run(options, view)
    if as_json:
        print_json(summary)
    else:
        typer.echo(summary_text(summary, view.folder))
    with one_line_errors():
        if why := nothing_followed(summary):
            raise PalpateError(f"{why}; {view.folder} has what was felt before")
