"""`palpate identify`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from recognition import flags
from recognition.commands.answering import Json, one_line_errors, print_json
from recognition.commands.part_argument import listing_parts_if_unknown, look_at_file
from recognition.console import interrupts


def identify(
    part: Annotated[str, typer.Argument(help="A built-in part (palpate parts) or a CAD file.")] = "",
    library: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="A folder of CAD files.", show_default="the built-in parts"),
    ] = None,
    policy: Annotated[
        str, typer.Option(help="How touches are chosen: information, random, grid or largest-gap.")
    ] = "information",
    confidence: Annotated[float, typer.Option(help="Probability at which to stop.")] = 0.95,
    units: flags.Units = "auto",
    scale: flags.Scale = 1.0,
    body: flags.Body = None,
    facets: flags.Facets = False,
    workspace: flags.Workspace = flags.EVERYWHERE,
    pose: flags.Pose = "random",
    sensor: flags.Sensor = "lts210",
    noise: flags.Noise = None,
    pose_noise_mm: flags.PoseNoise = 0.0,
    seed: flags.Seed = 0,
    max_touches: Annotated[int, typer.Option(help="Touches after which it stops, sure or not.")] = 40,
    out: flags.Out = None,
    overwrite: flags.Overwrite = False,
    as_json: Json = False,
) -> None:
    """Touch an object until it is sure which one of a library it is, and where.

    Exit code 0: the run is whole, and its summary says what was decided. 1: it could not begin.
    """
    with one_line_errors(exit_code=2):
        with interrupts.held():
            from recognition.config import parse_numbers, parse_pose
            from recognition.identifying.options import IdentifyOptions

        options = IdentifyOptions(
            part=part,
            units=units,
            scale=scale,
            body=body,
            facets=facets,
            workspace=parse_numbers(workspace, 6, "--workspace", "X0,Y0,Z0,X1,Y1,Z1 in mm"),
            pose=parse_pose(pose),
            sensors=tuple(sensor.split(",")),
            noise=noise,
            pose_noise=pose_noise_mm,
            seed=seed,
            max_touches=max_touches,
            out=out,
            overwrite=overwrite,
            library=library,
            policy=policy,
            confidence=confidence,
        )
    with listing_parts_if_unknown(part, "identify"):
        look_at_file(part)
        with interrupts.held():
            from recognition.console import compiling
            from recognition.identifying.run import run
            from recognition.identifying.text import TouchView, summary_text

        view = TouchView(quiet=as_json)
        with compiling.told(view.say):
            summary = run(options, told=view.told, watch=view.touched)
    if as_json:
        print_json(summary)
    else:
        typer.echo(summary_text(summary, view.folder))
