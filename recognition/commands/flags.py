"""The flags that commands share, with their help."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

Units = Annotated[str, typer.Option(help="Unit of the CAD file: auto, mm, cm, m or in.")]
Scale = Annotated[float, typer.Option(help="Factor on the part's size.")]
Body = Annotated[
    int | None,
    typer.Option(help="Which body of a CAD file that holds several, counted from 1.", show_default=False),
]
FeatureMm = Annotated[float, typer.Option(help="Smallest feature that must not be missed [mm].")]
Facets = Annotated[bool, typer.Option("--facets", help="Keep the flat sides of OpenSCAD's circles ($fn).")]
Workspace = Annotated[str, typer.Option(metavar="X0,Y0,Z0,X1,Y1,Z1", help="Where the object may be [mm].")]
Pose = Annotated[
    str,
    typer.Option(
        help="Where the object is: random (any attitude, its middle within 60 mm of the workspace's), "
        "as-is (the file's coordinates), or X,Y,Z,QW,QX,QY,QZ."
    ),
]
Sensor = Annotated[
    str,
    typer.Option(
        metavar="NAME|FILE.toml[,...]",
        help="The tactile array (palpate sensors); explore changes between several, named with commas.",
    ),
]
MaxTouches = Annotated[int, typer.Option(help="Touches after which it stops.")]
Support = Annotated[
    str, typer.Option(metavar="none|table", help="What the part lies on; none: no touch can meet its holder.")
]
Cover = Annotated[
    str | None,
    typer.Option(
        metavar="FILE", help="Another body in the way, in the part's coordinates.", show_default=False
    ),
]
Noise = Annotated[
    float | None,
    typer.Option(help="1 sigma, as a fraction of the full-contact signal.", show_default="the sensor's own"),
]
PriorCenter = Annotated[
    str | None,
    typer.Option(metavar="X,Y,Z", help="Where its middle may be [mm].", show_default="the contacts"),
]
PriorRadius = Annotated[float, typer.Option(help="How far from there [mm].")]
PoseNoise = Annotated[float, typer.Option(help="1 sigma of the stage's reported position [mm].")]
Seed = Annotated[int, typer.Option(help="Seed of everything random.")]
Out = Annotated[Path | None, typer.Option(help="Folder of the run, new or empty.", show_default="runs/PART")]
Device = Annotated[
    str | None,
    typer.Option(metavar="CONFIG.toml", help="On hardware, in PART's place.", show_default=False),
]
Library = Annotated[
    Path | None,
    typer.Option(
        "--library", metavar="DIR", help="A folder of CAD files.", show_default="the built-in parts"
    ),
]
Live = Annotated[bool, typer.Option("--live", help="Watch it in the browser while it goes on.")]
LiveAt = Annotated[
    str | None,
    typer.Option(
        metavar="HOST:PORT", help="Where --live is served.", show_default="127.0.0.1, any free port"
    ),
]
Overwrite = Annotated[bool, typer.Option("--overwrite", help="Replace the run in --out.")]
