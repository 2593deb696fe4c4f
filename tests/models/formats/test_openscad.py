import re
import shutil
import subprocess
from collections.abc import Iterator
from math import pi
from pathlib import Path

import numpy as np
import pytest

from models import parts
from models.csg import Cone, Csg, Cube, Cylinder, Operation, Placed, Polyhedron, Prism, Sphere, Torus
from models.formats import openscad
from models.normal.normal_form import same_tree
from models.part import load_part
from models.solid import Solid, iou
from primitives.errors import PalpateError


def names(tree: Csg) -> Iterator[str]:
    """Every name in the tree, from the root down."""
    if tree.name:
        yield tree.name
    children = (
        tree.children if isinstance(tree, Operation) else (tree.child,) if isinstance(tree, Placed) else ()
    )
    for child in children:
        yield from names(child)


def test_a_turned_outline_whose_heights_differ_by_rounding_alone_is_read(tmp_path):
    file = tmp_path / "can.scad"
    file.write_text(
        "$fn = 64; rotate_extrude() hull() { square([1, 60]); translate([24, 8]) circle(r = 8); }"
    )
    turned = load_part(file).solid
    assert turned.volume > pi * 24.0**2 * 16.0
    exact = tmp_path / "bar.scad"
    exact.write_text(
        "rotate_extrude() polygon([[0, 0], [9, 0.1 + 0.2 - 0.3], [9, 5], [4, 5 + 1e-15], [0, 5]]);"
    )
    assert load_part(exact).solid.volume == pytest.approx(pi * 81.0 * 5.0, rel=1e-3)


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


@pytest.mark.parametrize("name", parts.names())
def test_every_part_comes_back_as_the_same_tree(name: str) -> None:
    tree = parts.build(name)
    back = openscad.read_text(openscad.text(tree))
    assert same_tree(back.tree, tree, 1e-9)
    assert back.warnings == ()
    assert list(names(back.tree)) == list(names(tree))


@pytest.mark.parametrize("name", ["bracket", "hex_nut", "o_ring", "pyramid_stand", "wedge"])
def test_a_part_comes_back_as_the_same_solid(name: str) -> None:
    tree = parts.build(name)
    back = openscad.read_text(openscad.text(tree)).tree
    assert iou(Solid.from_csg(back), Solid.from_csg(tree)) >= 0.9999


@pytest.mark.parametrize(
    "tree",
    [
        Torus(20, 3, name="ring").at(1, 2, 3),
        Prism(((0, 0), (10, 0), (10, 4), (4, 4), (4, 10), (0, 10)), 1 / 3, name="ell"),
        Polyhedron(
            ((0, 0, 0), (9, 0, 0), (0, 8, 0), (0, 0, 7)), ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
        ),
        (Cone(1 / 3, 0, 0.1) | Sphere(pi)).turned("x", 0.1).named("pair").turned("y", 0.2),
        Cube((1, 2, 3)) - (Sphere(1) | Cylinder(0.5, 9, name="pin")) - (Cube((9, 9, 9)) & Sphere(0.2)),
    ],
)
def test_a_tree_comes_back_to_the_last_digit(tree: Csg) -> None:
    assert openscad.read_text(openscad.text(tree)).tree == tree


def test_a_ring_is_a_turned_circle_as_freecad_reads_it() -> None:
    assert openscad.text(Torus(20, 3)) == (
        "rotate_extrude(angle = 360, convexity = 2, $fn = 108, $fa = 12, $fs = 2) {\n"
        "\tmultmatrix([[1, 0, 0, 20], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) {\n"
        "\t\tcircle($fn = 40, $fa = 12, $fs = 2, r = 3);\n\t}\n}\n"
    )


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("openscad") is None, reason="OpenSCAD is not installed")
@pytest.mark.parametrize("name", ["bracket", "hex_nut", "o_ring", "pyramid_stand", "pulley"])
def test_openscad_draws_what_was_written(name: str, tmp_path: Path) -> None:
    tree = parts.build(name)
    openscad.write(tree, tmp_path / "part.csg", chord=0.05)
    command = ["openscad", "-o", str(tmp_path / "part.stl"), str(tmp_path / "part.csg")]
    subprocess.run(command, check=True, capture_output=True, timeout=100)
    drawn, ours = load_part(tmp_path / "part.stl").solid, Solid.from_csg(tree)
    assert drawn.volume == pytest.approx(ours.volume, rel=0.01)
    np.testing.assert_allclose(drawn.bounds, ours.bounds, atol=0.06)


def test_the_file_appears_whole_or_not_at_all(tmp_path: Path) -> None:
    openscad.write(parts.build("block"), tmp_path / "block.csg")
    assert [f.name for f in tmp_path.iterdir()] == ["block.csg"]
    with pytest.raises(PalpateError, match="cannot write"):
        openscad.write(parts.build("block"), tmp_path / "gone" / "block.csg")


@pytest.mark.parametrize(
    "scale", [0.001, 1 / 25.4, 0.2353191876, 0.9998369552449521, 3.565590880990549, 25.4]
)
def test_a_tree_comes_back_at_any_scale(scale: float) -> None:
    tree = Cylinder(20, 40).turned("x", 0.7).at(1, 2, 3) - Sphere(5).at(0, 0, 20) | Torus(30, 4).turned(
        "y", 1
    )
    back = openscad.read_text(openscad.text(tree), scale=scale).tree
    radii = [leaf.primitive.support(np.eye(3))[0] for leaf in back.leaves()]
    assert radii == pytest.approx([scale * 20, scale * 5, scale * 34], rel=1e-11)
    drawn = openscad.read_text(f"scale({scale!r}) {{\n{openscad.text(tree)}}}").tree
    assert same_tree(drawn, back, 1e-9 * scale)


def test_six_digits_of_a_turned_and_stretched_bar_give_its_size() -> None:
    c, s = 3 * np.cos(0.5), 3 * np.sin(0.5)
    rows = f"[[{c:.6g}, 0, {s:.6g}, 0], [0, 3, 0, 0], [{-s:.6g}, 0, {c:.6g}, 0], [0, 0, 0, 1]]"
    tree = openscad.read_text(f"multmatrix({rows}) cylinder(r = 2, h = 7, center = true);").tree
    assert next(tree.leaves()).primitive == Cylinder(6.0, 21.0)
