import re
from math import pi
from pathlib import Path

import numpy as np
import pytest

from models import parts
from models.csg import Cone, Cube, Cylinder, Sphere
from models.formats import openscad
from primitives.errors import PalpateError


def test_a_tree_is_written_as_openscad_writes_it() -> None:
    tree = (Cube((1, 2, 3), name="base") - Sphere(0.5).at(0, 0, 1.5)).named("part")
    assert openscad.text(tree) == (
        "// part\ndifference() {\n\t// base\n\tcube(size = [1, 2, 3], center = true);\n"
        "\tmultmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 1.5], [0, 0, 0, 1]]) {\n"
        "\t\tsphere($fn = 24, $fa = 12, $fs = 2, r = 0.5);\n\t}\n}\n"
    )


def test_a_cone_keeps_both_radii() -> None:
    assert "h = 30, r1 = 20, r2 = 0, center = true" in openscad.text(Cone(20, 0, 30))


def test_circles_stay_within_the_chord() -> None:
    for radius in (3.0, 20.0, 80.0):
        sides = int(re.search(r"\$fn = (\d+)", openscad.text(Cylinder(radius, 1), 0.02))[1])  # type: ignore[index]
        assert radius * (1 - np.cos(pi / sides)) <= 0.02


def test_names_cannot_break_out_of_their_comment() -> None:
    text = openscad.text(Cube((1, 1, 1), name="a\ncube(9);"))
    assert text.splitlines()[0] == "// a cube(9);"


def test_the_file_appears_whole_or_not_at_all(tmp_path: Path) -> None:
    openscad.write(parts.build("block"), tmp_path / "block.csg")
    assert [f.name for f in tmp_path.iterdir()] == ["block.csg"]
    with pytest.raises(PalpateError, match="cannot write"):
        openscad.write(parts.build("block"), tmp_path / "gone" / "block.csg")
