"""`palpate explore`."""

from __future__ import annotations

from typing import Annotated

import typer

from primitives.errors import PalpateError
from recognition import flags
from recognition.commands.answering import Json, one_line_errors, print_json
from recognition.commands.part_argument import listing_parts_if_unknown, look_at_file
from recognition.console import interrupts


def explore(
    part: Annotated[str, typer.Argument(help="A built-in part (palpate parts) or a CAD file.")] = "",
    device: flags.Device = None,
    units: flags.Units = "auto",
    scale: flags.Scale = 1.0,
    body: flags.Body = None,
    facets: flags.Facets = False,
    workspace: flags.Workspace = flags.EVERYWHERE,
    feature_mm: Annotated[float, typer.Option(help="Smallest feature that must not be missed [mm].")] = 10.0,
    pose: flags.Pose = "random",
    sensor: flags.Sensor = "lts210",
    noise: flags.Noise = None,
    pose_noise_mm: flags.PoseNoise = 0.0,
    seed: flags.Seed = 0,
    max_touches: Annotated[int, typer.Option(help="Touches after which exploration stops.")] = 500,
    policy: Annotated[
        str,
        typer.Option(help="closure, or to measure against: grid, random, raster.", show_default=True),
    ] = "closure",
    out: flags.Out = None,
    overwrite: flags.Overwrite = False,
    as_json: Json = False,
) -> None:
    """Explore an object of unknown shape and pose by touch, and reconstruct it.

    Exit code 0: the run is whole, and its summary says how it ended. 1: it could not begin, or a fault ended it.
    """
    with one_line_errors(exit_code=2):
        with interrupts.held():
            from recognition.config import ExploreOptions, parse_numbers, parse_pose

        options = ExploreOptions(
            part=part,
            units=units,
            scale=scale,
            body=body,
            facets=facets,
            workspace=parse_numbers(workspace, 6, "--workspace", "X0,Y0,Z0,X1,Y1,Z1 in mm"),
            feature=feature_mm,
            pose=parse_pose(pose),
            sensors=tuple(sensor.split(",")),
            noise=noise,
            pose_noise=pose_noise_mm,
            seed=seed,
            max_touches=max_touches,
            policy=policy,
            out=out,
            overwrite=overwrite,
            device=device,
        )
    with listing_parts_if_unknown(device or part):
        look_at_file(part)
        with interrupts.held():
            from recognition.console import compiling
            from recognition.explore import run
            from recognition.report.terminal import summary_text, watching
            from recognition.summary import fault_of

        with watching(quiet=as_json) as watch, compiling.told(watch.say):
            summary = run(options, watch)
    if as_json:
        print_json(summary)
    else:
        typer.echo(summary_text(summary, watch.folder))
    with one_line_errors():
        if fault := fault_of(summary):
            raise PalpateError(
                f"a fault ended exploration ({fault}); {watch.folder} has what was felt before"
            )
