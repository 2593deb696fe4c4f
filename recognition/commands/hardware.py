"""`palpate hardware`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from primitives.errors import PalpateError
from recognition.commands import flags
from recognition.commands.answering import Json, one_line_errors, print_json

app = typer.Typer(
    help="Arrays and stages on a wire: find, test, move, emulate.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
Config = Annotated[
    Path, typer.Argument(metavar="CONFIG", help="The set-up's TOML file (palpate hardware scan --out FILE).")
]


@app.command()
def scan(
    out: Annotated[
        Path | None, typer.Option(help="Write a config to start from.", show_default=False)
    ] = None,
    as_json: Json = False,
) -> None:
    """Find serial ports, and write a config to start from."""
    with one_line_errors():
        from recognition.hardware.scan import found_ports, start_config, text

        ports = found_ports()
        if out is not None:
            start_config(ports, out)
    if as_json:
        print_json({"ports": ports, "config": None if out is None else str(out)})
    else:
        typer.echo(text(ports))


@app.command()
def check(config: Config, as_json: Json = False) -> None:
    """Listen to the array, and ask the stage where it is.

    Nothing moves.
    """
    with one_line_errors():
        from recognition.hardware.check import check as checked
        from recognition.hardware.check import check_text

        told = checked(config)
    if as_json:
        print_json(told)
    else:
        typer.echo(check_text(told))
    with one_line_errors():
        if not told["healthy"]:
            raise PalpateError("the set-up is not as its config says; the lines above name what to mend")


@app.command()
def calibrate(
    config: Config,
    out: Annotated[
        Path | None, typer.Option(help="The file to write.", show_default="CONFIG-calibration.toml")
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="Do not ask before each part.")] = False,
    seed: flags.Seed = 0,
    as_json: Json = False,
) -> None:
    """Press flat, edge, step and ball, and write what they tell.

    Zeros, gains, dead taxels, spread, stiffness, and where the array sits, each with its standard deviation.
    """
    with one_line_errors():
        from recognition.hardware.calibrate import calibrate as calibrated
        from recognition.hardware.calibrate import calibrate_text

        def ask(line: str) -> None:
            if yes:
                typer.echo(f"palpate: {line}", err=True)
            else:
                typer.prompt(f"{line}; Enter", default="", show_default=False, err=True)

        file = out or config.with_name(f"{config.stem}-calibration.toml")
        told = calibrated(config, file, ask, seed)
    if as_json:
        print_json(told)
    else:
        typer.echo(calibrate_text(told))


@app.command()
def jog(
    config: Config,
    by: Annotated[
        str, typer.Option(metavar="DX,DY,DZ", help="Move the flange so far, guarded [mm].")
    ] = "0,0,0",
    home: Annotated[bool, typer.Option("--home", help="Home the stage first ($H).")] = False,
    unlock: Annotated[
        bool, typer.Option("--unlock", help="Reset it and leave an alarm first ($X); then home it.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Move by hand, guarded: contact ends the motion."""
    with one_line_errors():
        from recognition.config import parse_numbers
        from recognition.hardware.jog import jog as jogged

        told = jogged(config, parse_numbers(by, 3, "--by", "DX,DY,DZ in mm"), home, unlock)
    if as_json:
        print_json(told)
    else:
        typer.echo(f"{told['ended']}; the flange is at {told['position_mm']} mm")


@app.command()
def emulate(
    part: Annotated[
        str, typer.Argument(metavar="PART", help="A built-in part (palpate parts) or a CAD file.")
    ] = "block",
    protocol: Annotated[
        str, typer.Option(help="Of the array: dsa, wts, flexitac, matrix or lines.")
    ] = "flexitac",
    sensor: flags.Sensor = "lts210",
    axes: Annotated[str, typer.Option(help="Of the stage.")] = "XYZABC",
    config: Annotated[Path, typer.Option(help="Where to write the config.")] = Path("emulated.toml"),
    workspace: flags.Workspace = "-80,-80,-80,80,80,80",
    pose: flags.Pose = "random",
    seed: flags.Seed = 0,
    seconds: Annotated[float, typer.Option(help="How long to answer; 0: until Ctrl-C.")] = 0.0,
    pace: Annotated[
        float, typer.Option(help="Of its clock; below 1 on a busy machine, and all is as much slower.")
    ] = 1.0,
) -> None:
    """Serve a virtual array and stage over a part.

    A sensor's protocol and a Grbl controller, on pseudo-terminals.
    """
    with one_line_errors():
        from recognition.config import ExploreOptions, parse_numbers, parse_pose
        from recognition.hardware.emulate import serve

        box = parse_numbers(workspace, 6, "--workspace", "X0,Y0,Z0,X1,Y1,Z1 in mm")
        options = ExploreOptions(part, workspace=box, pose=parse_pose(pose), sensors=(sensor,), seed=seed)
        say = lambda line: typer.echo(f"palpate: {line}", err=True)  # noqa: E731
        serve(options, protocol, axes, config, seconds, say, pace)
