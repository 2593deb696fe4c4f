"""`palpate identify`."""

from __future__ import annotations

from typing import Annotated

import typer

from recognition.commands import flags
from recognition.commands.answering import Json, one_line_errors, print_json
from recognition.commands.part_argument import listing_parts_if_unknown, look_at_file
from recognition.commands.run_flags import Part, RunFlags, spread
from recognition.console import interrupts


@spread
def identify(
    part: Part = "",
    device: flags.Device = None,
    library: flags.Library = None,
    policy: Annotated[
        str, typer.Option(help="How touches are chosen: information, random, grid, largest-gap or planar.")
    ] = "information",
    confidence: Annotated[float, typer.Option(help="Probability at which to stop.")] = 0.95,
    max_touches: Annotated[int, typer.Option(help="Touches after which it stops, sure or not.")] = 40,
    pose_mm: Annotated[
        float, typer.Option(help="Error of the place [mm] down to which it is touched on, once named.")
    ] = 0.15,
    pose_deg: Annotated[float, typer.Option(help="Error of the attitude [degrees], likewise.")] = 0.25,
    pose_touches: Annotated[int, typer.Option(help="Touches for the pose alone, at most.")] = 3,
    live: flags.Live = False,
    live_at: flags.LiveAt = None,
    *,
    told: RunFlags,
    as_json: Json = False,
) -> None:
    """Touch an object until sure which one of a library it is.

    Each touch is chosen for what it is expected to tell of the name and of the pose.

    Exit code 0: the run is whole, and its summary says what was decided. 1: it could not begin.
    """
    with one_line_errors(exit_code=2):
        with interrupts.held():
            from recognition.identifying.options import IdentifyOptions

        options = told.options(
            IdentifyOptions,
            part=part,
            device=device,
            max_touches=max_touches,
            library=library,
            policy=policy,
            confidence=confidence,
            pose_mm=pose_mm,
            pose_deg=pose_deg,
            pose_touches=pose_touches,
        )
    with listing_parts_if_unknown(device or part, "identify"):
        look_at_file(part)
        with interrupts.held():
            from recognition.console import compiling
            from recognition.identifying.run import run
            from recognition.identifying.text import TouchView, summary_text
            from recognition.live.view import shown as live_view

        view = TouchView(quiet=as_json)
        with (
            compiling.told(view.say),
            live_view(live_at or ("" if live else None), view.told, view.say) as watch,
        ):
            summary = run(options, told=watch, watch=view.touched)
    if as_json:
        print_json(summary)
    else:
        typer.echo(summary_text(summary, view.folder))
