"""`palpate track`."""

from __future__ import annotations

from typing import Annotated

import typer

from primitives.errors import PalpateError
from recognition import flags
from recognition.commands.answering import Json, one_line_errors, print_json
from recognition.commands.part_argument import listing_parts_if_unknown, look_at_file
from recognition.console import interrupts


def track(
    what: Annotated[str, typer.Argument(help="What to follow: edge or surface.")],
    part: Annotated[str, typer.Argument(help="A built-in part (palpate parts) or a CAD file.")] = "",
    device: flags.Device = None,
    units: flags.Units = "auto",
    scale: flags.Scale = 1.0,
    body: flags.Body = None,
    facets: flags.Facets = False,
    workspace: flags.Workspace = flags.EVERYWHERE,
    pose: flags.Pose = "random",
    sensor: flags.Sensor = "lts210",
    noise: flags.Noise = None,
    pose_noise_mm: flags.PoseNoise = 0.0,
    speed_mm_s: Annotated[float, typer.Option(help="Along the edge, or over the surface [mm/s].")] = 20.0,
    latency_s: Annotated[
        float, typer.Option(help="By which the simulated stage obeys late [s]; measured, never told.")
    ] = 0.02,
    seed: flags.Seed = 0,
    out: flags.Out = None,
    overwrite: flags.Overwrite = False,
    as_json: Json = False,
) -> None:
    """Follow an edge or a surface of an object, from a contact that it finds.

    Exit code 0: the run is whole, and its summary says how it ended. 1: it could not begin, or followed nothing.
    """
    with one_line_errors(exit_code=2):
        with interrupts.held():
            from recognition.config import parse_numbers, parse_pose
            from recognition.tracking.options import TrackOptions

        options = TrackOptions(
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
            out=out,
            overwrite=overwrite,
            device=device,
            what=what,
            speed_mm_s=speed_mm_s,
            latency_s=latency_s,
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
