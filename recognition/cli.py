"""The `palpate` command: parse, call, print.

Every import that is not needed to parse sits inside its subcommand: `palpate --help` takes 0.06 s, against
0.03 s for a bare `import typer` and 0.13 s when typer lays the help out with rich, which is why
`rich_markup_mode` is off (median of 10, one 2-core machine).  Results go to stdout, progress and errors to
stderr.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, NoReturn

import typer

from primitives.errors import PalpateError
from recognition import flags
from recognition.console import interrupts

app = typer.Typer(
    name="palpate",
    help="Recognize objects by touch: explore with a tactile array, reconstruct as CSG.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
library_app = typer.Typer(
    help="Models to recognize, and their boundaries.", no_args_is_help=True, rich_markup_mode=None
)
app.add_typer(library_app, name="library")
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on stdout and nothing else there.")]


def main() -> None:
    """Run the command line: whatever happens is one line on stderr and an exit code, and never a traceback."""
    interrupts.heed()
    if sys.stdout is None:
        _end("standard output is closed; send it to a file or to /dev/null")
    try:
        with interrupts.held():
            command = typer.main.get_command(app)
        command()
    except (KeyboardInterrupt, SystemExit):
        if code := interrupts.asked():  # while arguments were parsed, where nobody else says so
            _end(_INTERRUPTED, code)
        raise
    except OSError as error:
        if error.filename is not None:
            _end(_bug_text(error))
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # or the exit would try again
        _end(f"cannot print the result ({error.strerror or error}); send standard output elsewhere")
    except Exception as error:
        _end(_bug_text(error))


_INTERRUPTED = "interrupted; what was recorded until then is whole"


def _end(text: str, exit_code: int = 1) -> NoReturn:
    typer.echo(f"palpate: {text}", err=True)
    sys.exit(exit_code)


def _bug_text(error: Exception) -> str:
    from recognition.console import bugs

    return str(bugs.told(error))


@contextmanager
def one_line_errors(exit_code: int = 1) -> Iterator[None]:
    """A known error is one line on stderr and exit 1; Ctrl-C is one line and exit 130, SIGTERM 143."""
    try:
        yield
    except PalpateError as error:
        typer.echo(f"palpate: {error}", err=True)
        raise typer.Exit(exit_code) from None
    except (KeyboardInterrupt, SystemError) as error:
        interrupt = interrupts.behind(error)
        if interrupt is None:
            raise
        typer.echo(f"palpate: {_INTERRUPTED}", err=True)
        raise typer.Exit(interrupts.asked() or 130) from None


def print_json(value: Mapping[str, object]) -> None:
    """One JSON object on stdout."""
    from recognition.run_folder import json_text

    typer.echo(json_text(value))


@app.command()
def explore(
    part: Annotated[str, typer.Argument(help="A built-in part (palpate parts) or a CAD file.")] = "",
    units: Annotated[str, typer.Option(help="Unit of the CAD file: auto, mm, cm, m or in.")] = "auto",
    scale: Annotated[float, typer.Option(help="Factor on the CAD file's size.")] = 1.0,
    body: Annotated[
        int | None, typer.Option(help="Which body of a CAD file that holds several, counted from 1.")
    ] = None,
    facets: Annotated[
        bool,
        typer.Option("--facets", help="Keep the flat sides of OpenSCAD's circles ($fn)."),
    ] = False,
    workspace: Annotated[
        str, typer.Option(metavar="X0,Y0,Z0,X1,Y1,Z1", help="Where the object may be [mm].")
    ] = "-300,-300,-300,300,300,300",
    feature_mm: Annotated[float, typer.Option(help="Smallest feature that must not be missed [mm].")] = 10.0,
    pose: Annotated[
        str,
        typer.Option(
            help="Where the object is: random (any attitude, its middle within 60 mm of the workspace's), "
            "as-is (the file's coordinates), or X,Y,Z,QW,QX,QY,QZ."
        ),
    ] = "random",
    sensor: Annotated[
        str, typer.Option(metavar="NAME|FILE.toml", help="The tactile array (palpate sensors).")
    ] = "lts210",
    noise: Annotated[
        float | None,
        typer.Option(
            help="1 sigma, as a fraction of the full-contact signal.", show_default="the sensor's own"
        ),
    ] = None,
    pose_noise_mm: Annotated[
        float, typer.Option(help="1 sigma of the stage's reported position [mm].")
    ] = 0.0,
    seed: Annotated[int, typer.Option(help="Seed of everything random.")] = 0,
    max_touches: Annotated[int, typer.Option(help="Touches after which exploration stops.")] = 500,
    out: Annotated[
        Path | None, typer.Option(help="Folder of the run, new or empty.", show_default="runs/PART")
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="Replace the run in --out.")] = False,
    as_json: Json = False,
) -> None:
    """Explore a convex object of unknown shape and pose by touch, and reconstruct it.

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
            out=out,
            overwrite=overwrite,
        )
    with listing_parts_if_unknown(part):
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


@app.command()
def track(
    what: Annotated[str, typer.Argument(help="What to follow: edge or surface.")],
    part: Annotated[str, typer.Argument(help="A built-in part (palpate parts) or a CAD file.")] = "",
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
            what=what,
            speed_mm_s=speed_mm_s,
            latency_s=latency_s,
        )
    with listing_parts_if_unknown(part, "track"):
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


@app.command()
def probe(
    part: Annotated[str, typer.Argument(help="A built-in part (palpate parts) or a CAD file.")] = "",
    procedure: Annotated[
        str, typer.Argument(help="What to do there; without one, all procedures are listed.")
    ] = "",
    units: flags.Units = "auto",
    scale: flags.Scale = 1.0,
    body: flags.Body = None,
    facets: flags.Facets = False,
    workspace: flags.Workspace = flags.EVERYWHERE,
    pose: flags.Pose = "random",
    sensor: flags.Sensor = "lts210",
    noise: flags.Noise = None,
    pose_noise_mm: flags.PoseNoise = 0.0,
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
    latency_s: Annotated[
        float, typer.Option(help="By which the simulated stage obeys late [s]; measured, never told.")
    ] = 0.02,
    seed: flags.Seed = 0,
    out: flags.Out = None,
    overwrite: flags.Overwrite = False,
    as_json: Json = False,
) -> None:
    """Carry one exploratory procedure out on an object: what it felt.

    Exit code 0: the run is whole. 1: it could not begin, or the procedure could not be carried out.
    """
    with one_line_errors(exit_code=2):
        with interrupts.held():
            from recognition.config import parse_numbers, parse_pose
            from recognition.probing.options import ProbeOptions

        options = ProbeOptions(
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
            procedure=procedure,
            force_n=force_n,
            stiffness_n_mm3=stiffness,
            roughness_mm=roughness_mm,
            material=material,
            latency_s=latency_s,
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


def look_at_file(part: str) -> None:
    """Say what is wrong with a file at a glance, which takes no second of imports."""
    from models.formats.intake import glance, looks_like_a_file

    if looks_like_a_file(part):
        glance(Path(part))


@contextmanager
def listing_parts_if_unknown(part: str, command: str = "explore") -> Iterator[None]:
    """After the line that says what was wrong with a part that is not there, list what there is."""
    with one_line_errors():
        try:
            if not part:
                raise PalpateError(f"{command} needs a part: a built-in name, or a CAD file")
            yield
        except PalpateError as error:
            if Path(part).suffix or (part and Path(part).exists()):
                raise
            from models.parts import names
            from recognition.builtin import part_rows
            from recognition.report.terminal import table_text

            if part in names():
                raise
            raise PalpateError(f"{error}\n\n{table_text(part_rows())}") from None


@app.command()
def parts(as_json: Json = False) -> None:
    """List the built-in parts."""
    with one_line_errors():
        from recognition.builtin import part_rows
        from recognition.report.terminal import table_text

        rows = part_rows()
    if as_json:
        print_json({"parts": rows})
    else:
        typer.echo(table_text(rows))


@app.command()
def sensors(as_json: Json = False) -> None:
    """List the built-in tactile arrays."""
    with one_line_errors():
        from recognition.builtin import sensor_rows
        from recognition.report.terminal import table_text

        rows = sensor_rows()
    if as_json:
        print_json({"sensors": rows})
    else:
        typer.echo(table_text(rows))


@app.command()
def frames(
    file: Annotated[str, typer.Argument(help="A recording: .mcap, .dsa, .csv, .npy or .npz.")],
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
    """Show what each frame of a recording felt: kind of contact, lines, curvature."""
    with one_line_errors():
        from recognition.frames.options import FramesOptions

        options = FramesOptions(file, sensor, index, png)
        recording = options.recording()
        from recognition.frames.run import run
        from recognition.frames.terminal import print_frames, telling

        with telling(quiet=as_json) as tell:
            seen = run(options, recording, tell)
    if as_json:
        print_json(seen.summary)
    else:
        print_frames(seen, one=index is not None)
    if png is not None:
        typer.echo(f"{seen.pictures} pictures in {png}", err=True)


@library_app.command("show")
def library_show(
    file: Annotated[str, typer.Argument(help="A CAD file, or a built-in part (palpate parts).")],
    units: Annotated[str, typer.Option(help="Unit of the CAD file: auto, mm, cm, m or in.")] = "auto",
    scale: Annotated[float, typer.Option(help="Factor on the CAD file's size.")] = 1.0,
    body: Annotated[
        int | None, typer.Option(help="Which of a file's bodies, from 1.", show_default=False)
    ] = None,
    facets: Annotated[
        bool,
        typer.Option("--facets", help="Keep the flat sides of OpenSCAD's circles ($fn)."),
    ] = False,
    out: Annotated[
        Path | None, typer.Option(metavar="PAGE.html", help="Also draw it as a page.", show_default=False)
    ] = None,
    as_json: Json = False,
) -> None:
    """Draw one model's boundary: faces by shape, edges by kind, which face meets which."""
    with one_line_errors(exit_code=2):
        from models.formats.units import checked_flags

        checked_flags(units, scale)
    with one_line_errors():
        look_at_file(file)
        with interrupts.held():
            from recognition.library_show import show, write_page

        shown = show(file, units, scale, body, facets)
        if out is not None:
            write_page(shown, out)
    if as_json:
        print_json(shown.summary)
    else:
        from recognition.report.boundary_terminal import print_boundary

        print_boundary(shown.summary)
        if out is not None:
            typer.echo(f"page: {out}", err=True)


@app.command()
def doctor(as_json: Json = False) -> None:
    """Say what is installed, what is missing and what collides."""
    with one_line_errors():
        from recognition.doctor import examine

        findings = examine()
    if as_json:
        print_json(findings.as_json())
    else:
        typer.echo(findings.as_text())
    if not findings.healthy:
        raise typer.Exit(1)


if __name__ == "__main__":
    main()
