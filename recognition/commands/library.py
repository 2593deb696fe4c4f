"""`palpate library`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from recognition.commands import flags
from recognition.commands.answering import Json, one_line_errors, print_json
from recognition.commands.part_argument import look_at_file
from recognition.console import interrupts

app = typer.Typer(
    help="Models to recognize, and their boundaries.", no_args_is_help=True, rich_markup_mode=None
)
Folder = Annotated[Path, typer.Argument(metavar="DIR", help="A folder of CAD files, formats mixed.")]
Workers = Annotated[
    int | None, typer.Option(min=1, help="Processes that read files.", show_default="one a processor")
]


@app.command("build")
def library_build(
    folder: Folder,
    units: flags.Units = "auto",
    scale: flags.Scale = 1.0,
    workers: Workers = None,
    as_json: Json = False,
) -> None:
    """Index a folder of CAD files.

    What is new or changed is made, the rest is kept.

    Exit code 0: whatever can be read is indexed; files that cannot are named.  1: nothing could be.
    """
    _checked(units, scale)
    with one_line_errors():
        with interrupts.held():
            from models.library import build
            from recognition.libraries.answers import built_json, built_text, progress, workers_of

        with progress(as_json) as watch:
            built = build(folder, units, scale, watch, workers_of(workers))
    if as_json:
        print_json(built_json(built))
    else:
        typer.echo(built_text(built))
    with one_line_errors():
        _require_one(built.failed, len(built.made) + len(built.kept))


@app.command("list")
def library_list(
    folder: Folder,
    units: flags.Units = "auto",
    scale: flags.Scale = 1.0,
    as_json: Json = False,
) -> None:
    """List the objects of a library."""
    _checked(units, scale)
    with one_line_errors():
        with interrupts.held():
            from recognition.libraries.answers import list_rows, list_text, opened

        library = opened(folder, units, scale, as_json)
        rows = list_rows(library)
    if as_json:
        print_json({"entries": rows, "warnings": list(library.warnings)})
    else:
        typer.echo(list_text(rows, library.warnings))


@app.command("show")
def library_show(
    file: Annotated[
        str,
        typer.Argument(
            metavar="FILE|DIR", help="A CAD file, a built-in part (palpate parts), or a library's folder."
        ),
    ],
    name: Annotated[
        str, typer.Argument(metavar="NAME", help="Which object of the folder.", show_default=False)
    ] = "",
    units: flags.Units = "auto",
    scale: flags.Scale = 1.0,
    body: flags.Body = None,
    facets: flags.Facets = False,
    out: Annotated[
        Path | None, typer.Option(metavar="PAGE.html", help="Also draw it as a page.", show_default=False)
    ] = None,
    as_json: Json = False,
) -> None:
    """Draw one model's boundary, in the terminal and as a page.

    Faces by shape, edges by kind, and which face meets which.
    """
    _checked(units, scale)
    with one_line_errors():
        of_folder = bool(name) or Path(file).is_dir()
        if not of_folder:
            look_at_file(file)
        with interrupts.held():
            from recognition.libraries.shown import show, show_object, write_page

        if of_folder:
            shown = show_object(Path(file), name, units, scale)
        else:
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


@app.command("confusable")
def library_confusable(
    folder: Folder,
    units: flags.Units = "auto",
    scale: flags.Scale = 1.0,
    sensor: flags.Sensor = "lts210",
    noise: flags.Noise = None,
    pose_noise_mm: flags.PoseNoise = 0.0,
    contact_sigma: Annotated[
        float | None,
        typer.Option(
            metavar="MM",
            help="1 sigma of a contact's point, in place of what sensor and stage come to.",
            show_default=False,
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Say which objects this sensor cannot tell apart.

    And, of the others, which touches tell them.

    A pair's probability is that of naming the wrong one of the two after the best touches: 0.5 for equal objects.
    """
    _checked(units, scale)
    with one_line_errors(exit_code=2):
        with interrupts.held():
            from recognition.libraries.answers import (
                confusable_json,
                confusable_text,
                contact_sigma_of,
                opened,
                progress,
                sensor_of,
            )

        spec = sensor_of(sensor)
        sigma = contact_sigma_of(spec, noise, pose_noise_mm, contact_sigma)
    with one_line_errors():
        from recognition.confusable import confusable

        library = opened(folder, units, scale, as_json)
        with progress(as_json) as watch:
            pairs = confusable(library, spec, sigma, watch=watch)
    if as_json:
        print_json(confusable_json(pairs, len(library), spec.name, sigma, library.warnings))
    else:
        typer.echo(confusable_text(pairs, len(library), spec.name, sigma, library.warnings))


def _checked(units: str, scale: float) -> None:
    with one_line_errors(exit_code=2):
        from models.formats.units import checked_flags

        checked_flags(units, scale)


def _require_one(failed: dict[str, str], made: int) -> None:
    from primitives.errors import PalpateError

    if failed and not made:
        raise PalpateError(f"no file of the folder could be read; the first: {next(iter(failed.values()))}")
