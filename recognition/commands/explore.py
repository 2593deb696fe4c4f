"""`palpate explore`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from primitives.errors import PalpateError
from recognition.commands import flags
from recognition.commands.answering import Json, one_line_errors, print_json
from recognition.commands.part_argument import listing_parts_if_unknown, look_at_file
from recognition.commands.run_flags import Part, RunFlags, spread
from recognition.console import interrupts

_BOTH = RunFlags(sensor="lts210,fingertip")  # most parts have what a large pad cannot enter


@spread
def explore(
    part: Part = "",
    device: flags.Device = None,
    max_touches: Annotated[int, typer.Option(help="Touches after which exploration stops.")] = 500,
    max_minutes: Annotated[float, typer.Option(help="Minutes of the stage after which it stops.")] = 30.0,
    policy: Annotated[
        str,
        typer.Option(help="closure, or to measure against: grid, random, raster.", show_default=True),
    ] = "closure",
    dry_run: Annotated[
        bool, typer.Option("--dry-run", help="With --device: list every motion before the first contact.")
    ] = False,
    live: flags.Live = False,
    live_at: flags.LiveAt = None,
    *,
    told: RunFlags = _BOTH,
    as_json: Json = False,
) -> None:
    """Explore an object by touch, and reconstruct it as CSG.

    Its shape is unknown to the explorer, and so is where it lies: anywhere in the workspace.

    Exit code 0: the run is whole, and its summary says how it ended. 1: it could not begin, or a fault ended it.
    """
    with one_line_errors(exit_code=2):
        with interrupts.held():
            from recognition.config import ExploreOptions

        options = told.options(
            ExploreOptions,
            part=part,
            max_touches=max_touches,
            max_minutes=max_minutes,
            policy=policy,
            device=device,
        )
    if dry_run:
        _rehearse(device, as_json)
        return
    with listing_parts_if_unknown(device or part):
        look_at_file(part)
        with interrupts.held():
            from recognition.console import compiling
            from recognition.explore import run
            from recognition.live.view import shown as live_view
            from recognition.report.terminal import summary_text, watching
            from recognition.running.summary import fault_of

        with (
            watching(quiet=as_json) as watch,
            compiling.told(watch.say),
            live_view(live_at or ("" if live else None), watch, watch.say) as shown,
        ):
            summary = run(options, shown)
    if as_json:
        print_json(summary)
    else:
        typer.echo(summary_text(summary, watch.folder))
    with one_line_errors():
        if fault := fault_of(summary):
            raise PalpateError(
                f"a fault ended exploration ({fault}); {watch.folder} has what was felt before"
            )


def _rehearse(device: str | None, as_json: bool) -> None:
    with one_line_errors(exit_code=2):
        if device is None:
            raise PalpateError("--dry-run lists the motions of a stage; give its --device CONFIG")
    with one_line_errors():
        from recognition.hardware.rehearse import print_rehearsal, rehearsal_json, rehearsed

        motions = rehearsed(Path(device))
        if as_json:
            print_json(rehearsal_json(Path(device), motions))
        else:
            print_rehearsal(motions)
