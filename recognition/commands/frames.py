"""`palpate frames`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from primitives.errors import PalpateError
from recognition.commands.answering import Json, one_line_errors, print_json


def frames(
    file: Annotated[
        str, typer.Argument(metavar="FILE", help="A recording: .mcap, .dsa, .csv, .npy, .npz or .bin.")
    ] = "",
    device: Annotated[
        str | None,
        typer.Option(metavar="CONFIG.toml", help="Live from an array, in FILE's place.", show_default=False),
    ] = None,
    seconds: Annotated[
        float | None,
        typer.Option(help="How long to listen to a device.", show_default="until Ctrl-C; 5 with --json"),
    ] = None,
    sensor: Annotated[
        str | None,
        typer.Option(
            metavar="NAME|FILE.toml",
            help="The array that the frames are from (palpate sensors).",
            show_default="what the recording says",
        ),
    ] = None,
    index: Annotated[
        int | None, typer.Option(help="Show this frame in full, counted from 0.", show_default="all")
    ] = None,
    png: Annotated[
        Path | None,
        typer.Option(
            metavar="DIR", help="New folder for a picture of each frame in contact.", show_default=False
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Show what each frame of a recording or an array felt.

    The kind of contact, lines, arcs, curvature and force.
    """
    with one_line_errors(exit_code=2):
        if not (file or device):
            raise PalpateError(
                "frames needs a recording: .mcap, .dsa, .csv, .npy, .npz or .bin; or --device CONFIG"
            )
        if file and device:
            raise PalpateError("frames shows a recording or a device, not both; leave one out")
    with one_line_errors():
        from recognition.frames.options import FramesOptions

        options = FramesOptions(device or file, sensor, index, png)
        calibration = None
        if device is None:
            recording = options.recording()
        else:
            from recognition.frames.terminal import showing
            from recognition.hardware.listen import listen

            limit = seconds if seconds is not None else 5.0 * as_json
            with showing(quiet=as_json) as show:
                recording, calibration = listen(Path(device), limit, show)
        from recognition.frames.run import run
        from recognition.frames.terminal import print_frames, telling

        with telling(quiet=as_json) as tell:
            seen = run(options, recording, tell, calibration)
    if as_json:
        print_json(seen.summary)
    else:
        print_frames(seen, one=index is not None)
    if png is not None:
        typer.echo(f"{seen.pictures} pictures in {png}", err=True)
