"""Distinct objects of about 100 mm to recognize: built-in, of $PALPATE_DATA/parts, and generated."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from models import parts
from models.csg import Cube, Cylinder
from models.generate import generate
from models.library import Library
from models.part import load_part
from models.solid import Solid

DATA = Path(os.environ.get("PALPATE_DATA", Path(__file__).parents[4] / "shared"))
BUILT_IN = (
    "bracket", "wedge", "hex_nut", "stepped_shaft", "gusset_bracket", "clevis", "z_bracket", "t_plate",
    "slotted_plate", "lug", "spur_gear", "v_block", "t_slot_block", "dovetail_block", "bearing_block",
    "pocket_plate", "stepped_wedge", "pyramid_stand", "die_holder", "hex_bolt", "keyed_shaft", "pulley",
    "handwheel", "eyebolt", "funnel", "knob", "stepped_block", "flange",
)  # fmt: skip
OUTSIDE = {  # with the scale that makes them millimeters, and about 100
    "angle_block.STL": 76.0, "ariac_pipe_1.stl": 600.0, "ariac_pump_base.stl": 1000.0,
    "ariac_regulator.stl": 1000.0, "idler_riser.STL": 25.4, "featuretype.STEP": 20.0,
    "base_interface.STEP": 4.0, "blind-hole.step": 1.6,
    "nist_ctc_01.stp": 0.12,
}  # fmt: skip


def library(count: int = 50) -> Library:
    """So many, the same ones every time."""
    return Library.of(solids(count))


def solids(count: int = 50) -> dict[str, Solid]:
    """By name."""
    found = {part: sized(Solid.from_csg(parts.build(part))) for part in BUILT_IN[:count]}
    parts_of_others = DATA / "parts"
    for file, scale in OUTSIDE.items():
        if (parts_of_others / file).exists() and len(found) < count:
            found[Path(file).stem] = load_part(parts_of_others / file, "mm", scale).solid
    for k in range(count - len(found)):
        found[f"generated{k}"] = sized(Solid.from_csg(generate(np.random.default_rng(1000 + k))))
    return found


def sized(solid: Solid) -> Solid:
    """Itself, or scaled to 100 mm where its largest side is not about that."""
    largest = float(solid.extent.max())
    if 60.0 <= largest <= 160.0:
        return solid
    return Solid.from_mesh(solid.vertices * (100.0 / largest), solid.triangles)


def twins() -> dict[str, tuple[Solid, Solid]]:
    """Pairs that differ in one hole, radius or length."""
    plate, block = Cube((100.0, 70.0, 12.0)), Cube((90.0, 45.0, 30.0))
    bored = plate - Cylinder(5.0, 40.0).at(32.0, 20.0, 0.0)
    shaft = Cylinder(15.0, 60.0)
    made = {
        "hole": (bored, bored - Cylinder(5.0, 40.0).at(-32.0, -20.0, 0.0)),
        "radius": (block - Cylinder(9.0, 80.0), block - Cylinder(11.0, 80.0)),
        "length": (
            shaft | Cylinder(9.0, 30.0).at(0.0, 0.0, 44.0),
            shaft | Cylinder(9.0, 34.0).at(0.0, 0.0, 46.0),
        ),
    }
    return {key: (Solid.from_csg(a), Solid.from_csg(b)) for key, (a, b) in made.items()}
