"""Small files over the whole grammar that is read, and past it; each against a tree built in Python."""

from math import pi, radians, sqrt
from pathlib import Path

import numpy as np
import pytest

from models.csg import Cone, Csg, Cube, Cylinder, Polyhedron, Prism, Sphere, Torus
from models.formats import openscad
from models.normal.normal_form import same_tree
from models.part import load_part
from models.solid import Solid
from primitives.errors import PalpateError

FILES = Path(__file__).parent / "openscad"


def box(x: float, y: float, z: float) -> Csg:
    """With a corner at the origin, as OpenSCAD's cube."""
    return Cube((x, y, z)).at(x / 2, y / 2, z / 2)


def bar(radius: float, height: float) -> Csg:
    return Cylinder(radius, height).at(0, 0, height / 2)


def flange() -> Csg:
    tree: Csg = bar(40, 10)
    for i in range(6):
        tree = tree - Cylinder(4, 50).at(30, 0, 0).turned("z", i * pi / 3)
    return tree - Cylinder(11, 50)


def ground_off(height: float, scale: float) -> Csg:
    low, high = ([(i * s, j * s) for i, j in ((-1, -1), (1, -1), (1, 1), (-1, 1))] for s in (10, 10 * scale))
    corners = [(*p, z) for row, z in ((low, 0.0), (high, height)) for p in row]
    around = [(i, (i + 1) % 4, 4 + (i + 1) % 4, 4 + i) for i in range(4)]
    return Polyhedron(tuple(corners), ((3, 2, 1, 0), (4, 5, 6, 7), *around))


BEAM = Cube((60, 20, 10))
HEX = Prism(tuple((10 * np.cos(k * pi / 3), 10 * np.sin(k * pi / 3)) for k in range(6)), 8)
READ: dict[str, Csg] = {
    "plate.csg": Cube((80, 50, 10)) - Cylinder(6, 20).at(20, 0, 0),
    "countersink.csg": box(30, 30, 10) - Cone(2, 8, 6).at(15, 15, 8),
    "six_digits.csg": Cube((10, 20, 30)).turned("y", radians(20)).at(1, 2, 3),
    "torus.csg": Torus(20, 4).at(0, 0, 5),
    "tube.csg": bar(15, 30) - Cylinder(10, 60).at(0, 0, 15),
    "turned_profile.csg": bar(20, 10) | Cone(20, 12, 10).at(0, 0, 15) | bar(12, 20).at(0, 0, 20),
    "hexagon.csg": HEX,
    "wedge.csg": Polyhedron(
        ((0, 0, 0), (30, 0, 0), (30, 20, 0), (0, 20, 0), (0, 20, 15), (30, 20, 15)),
        ((3, 2, 1, 0), (2, 3, 4, 5), (1, 5, 4, 0), (4, 3, 0), (1, 2, 5)),
    ),
    "colored.csg": Sphere(12),
    "mirrored_cone.csg": Cone(5, 15, 30).at(0, 0, -15),
    "doubled.csg": (Sphere(10) | Cylinder(8, 40).at(20, 0, 0)).turned("z", pi / 2),
    "edited_model.csg": Cube((70, 40, 8)) - Cylinder(5, 30).at(14, 0, 0),
    "flange.scad": flange(),
    "children.scad": Cube((10, 10, 10))
    | Cube((10, 10, 10)).at(12, 0, 0)
    | Cube((10, 10, 10)).at(24, 0, 0)
    | Sphere(4).at(0, 20, 0)
    | box(2, 2, 2).at(0, 40, 0),
    "specials.scad": Sphere(12),
    "recursion.scad": Cube((30, 30, 10))
    | Cube((20, 20, 10)).at(0, 0, 10)
    | Cube((10, 10, 10)).at(0, 0, 20)
    | Cube((50, 8, 10)).at(0, 0, -10),
    "lists.scad": box(11, 22, 12),
    "arithmetic.scad": box(6, 12, 12),
    "trigonometry.scad": box(10, 5, 12),
    "strings.scad": box(16, 6, 10),
    "conditions.scad": box(20, 20, 20) | box(10, 10, 10).at(30, 0, 0) | box(5, 5, 5).at(60, 0, 0),
    "let_and_overrides.scad": box(12, 6, 4),
    "functions_as_values.scad": box(12, 12, 12),
    "modifiers.scad": Cube((20, 20, 20)) - Cube((10, 10, 10)).at(0, 0, 10),
    "root.scad": box(30, 10, 10).turned("z", pi / 2),
    "placements.scad": Cone(8, 4, 20).at(0, 0, 20).turned("x", pi / 2).turned("z", pi / 4)
    | Cube((10, 20, 30)).at(40, 0, 0).turned((1, 1, 1), 2 * pi / 3)
    | Prism(((-30, 0), (-30, 20), (-40, 0)), 5).at(0, 0, 2.5)
    | Sphere(5).at(0, 50, 0),
    "stretches.scad": bar(10, 12)
    | box(10, 20, 30).at(50, 0, 0)
    | Sphere(12).at(0, 50, 0)
    | bar(5, 30).at(50, 50, 0),
    "plate_with_slots.scad": Cube((80, 40, 6)).at(0, 0, 3)
    - Cylinder(6, 12).at(-25, 0, 3)
    - Cylinder(6, 12).at(25, 0, 3)
    - (Cube((6, 16, 12)) | Cylinder(3, 12).at(0, 8, 0) | Cylinder(3, 12).at(0, -8, 0)).at(0, 0, 3),
    "tapers.scad": ground_off(20, 0.5)
    | Polyhedron(
        ((30, -10, 0), (50, -10, 0), (40, 10, 0), (40, 0, 15)), ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
    )
    | Cone(6, 12, 10).at(80, 0, 5),
    "holes_in_polygon.scad": box(40, 30, 5)
    - Cube((10, 20, 10)).at(10, 15, 2.5)
    - Prism(((20, 5), (35, 5), (35, 25)), 10).at(0, 0, 2.5),
    "groove.scad": Cylinder(30, 20) - Cylinder(5, 40) - Torus(30, 4),
    "uses_library.scad": bar(7, 25) | (Sphere(7) - Cube((100, 100, 100)).at(0, 0, -50)).at(0, 0, 25),
    "intersections.scad": (Cube((30, 30, 30)) & Sphere(19))
    | (BEAM & BEAM.turned("z", pi / 3) & BEAM.turned("z", 2 * pi / 3)).at(60, 0, 0),
    "few_sides.scad": Prism(tuple((x, y) for x, y in HEX.outline), 5).at(0, 0, 2.5),
}
VOLUMES = {
    "sheared_box.csg": 20 * 10 * 5,
    "sector.scad": 2 * pi * 20 * pi * 25 / 4 + pi * (20**2 - 10**2) * 6 / 6,
    "hulls.scad": (40 * 20 + 2 * 5 * 60 + pi * 25) * 8
    + (400 + 10 * (400 + 100 + 200) / 3)
    + (20 * 10 + 2 * 3 * 30 + pi * 9) * 6,
    "chamfered.scad": pi * (100 * 8 + 2 * (100 + 90 + 81) / 3),
    "rounded.scad": 10 * 20 * 5
    + 3 * 2 * (200 + 50 + 100)
    + pi * 9 * 35
    + 36 * pi  # Steiner's formula
    + pi * 25 * 20
    + 4 / 3 * pi * 125
    + (200 + 2 * 2 * 30 + pi * 4) * 4
    + 8 * 18 * 4,
    "intersections.scad": 10 * 20**2 * sqrt(3) / 2 + 4 / 3 * pi * 19**3 - 6 * pi * 4**2 * (3 * 19 - 4) / 3,
}
REFUSED = {
    "ellipsoid.csg": "line 2: sphere is stretched to an ellipse",
    "sheared_cylinder.csg": "line 3: a sheared or slanting cylinder",
    "twisted.csg": "line 1: linear_extrude with twist",
    "asserted.scad": "line 1: the file's own assertion fails: x must be positive",
    "text.scad": r"line 4: text\(\) is outside the subset",
    "imported.scad": r"line 4: import\(\) is outside the subset",
    "unknown_module.scad": "line 3: no module gear",
    "unknown_name.scad": "line 3: nothing is called depth",
    "flat_at_top.scad": "line 2: circle is flat where a solid is needed",
    "solid_in_extrusion.scad": "line 3: sphere is solid where a flat shape is needed",
    "across_the_axis.scad": "line 1: rotate_extrude's shape lies on both sides of the axis",
    "hollow_offset.scad": r"line 2: offset\(\) of this",
    "minkowski.scad": r"line 1: .*minkowski\(\)",
    "missing_bracket.scad": "line 3: cannot read",
    "missing_semicolon.scad": "line 1: cube holds nothing",
    "endless.scad": "line 2: calls go more than 400 deep",
    "leaves_folder.scad": "line 2: .*outside the file's folder",
}


@pytest.mark.parametrize("name", READ)
def test_a_file_is_read_as_the_tree_that_it_draws(name: str) -> None:
    tolerance = 1e-4 if name in ("six_digits.csg", "hexagon.csg") else 1e-9
    assert same_tree(openscad.read(FILES / name).tree, READ[name], tolerance)


@pytest.mark.parametrize("name", VOLUMES)
def test_a_file_holds_the_volume_of_its_closed_form(name: str) -> None:
    assert Solid.from_csg(openscad.read(FILES / name).tree).volume == pytest.approx(VOLUMES[name], rel=1e-4)


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_outside_the_subset_is_named_with_its_line(name: str) -> None:
    with pytest.raises(PalpateError, match=f"^{name}, {REFUSED[name]}") as caught:
        openscad.read(FILES / name)
    assert "\n" not in str(caught.value)


def test_every_file_is_held_to_something() -> None:
    names = {path.name for path in FILES.iterdir() if path.is_file()}
    assert names == {*READ, *VOLUMES, *REFUSED}
    assert len(names) >= 40


def test_names_come_from_the_comment_right_above() -> None:
    tree = openscad.read(FILES / "edited_model.csg").tree
    assert tree.name == "bracket"
    assert [leaf.primitive.name for leaf in tree.leaves()] == ["base, made longer by hand", "foot hole"]


def test_a_circle_of_few_sides_is_a_polygon_and_one_of_a_dozen_round_with_a_warning() -> None:
    assert openscad.read(FILES / "few_sides.scad").warnings == ()
    twelve = openscad.read_text("cylinder(r = 10, h = 5, $fn = 12);", "part.scad")
    (warning,) = twelve.warnings
    assert "line 1" in warning
    assert "$fn = 12" in warning
    assert same_tree(twelve.tree, bar(10, 5))
    sided = openscad.read_text("cylinder(r = 10, h = 5, $fn = 12);", "part.scad", facets=True)
    assert sided.warnings == ()
    assert len(next(iter(sided.tree.leaves())).primitive.outline) == 12


@pytest.mark.parametrize(
    ("text", "faces"),
    [
        ("rotate_extrude($fn = 4) square([10, 20]);", 4),
        ("linear_extrude(20) circle(r = 10, $fn = 8);", 8),
        ("$fn = 5; cylinder(r1 = 10, r2 = 5, h = 20);", 5),
    ],
)
def test_few_sides_are_kept_where_corners_are_turned_and_circles_drawn(text: str, faces: int) -> None:
    drawing = openscad.read_text(text, "part.scad")
    assert drawing.warnings == ()
    assert len(Solid.from_csg(drawing.tree).surfaces) == faces + 2


def test_a_part_of_a_turn_and_a_ring_of_a_circle_stay_round_and_say_so() -> None:
    quarter = openscad.read_text("rotate_extrude(angle = 90, $fn = 6) square([10, 20]);", "part.scad")
    assert Solid.from_csg(quarter.tree).volume == pytest.approx(pi * 100 * 20 / 4, rel=1e-3)
    ring = openscad.read_text("rotate_extrude($fn = 6) translate([20, 0]) circle(5, $fn = 48);", "part.scad")
    assert Solid.from_csg(ring.tree).volume == pytest.approx(2 * pi * 20 * pi * 25, rel=1e-3)
    for drawing in (quarter, ring):
        (warning,) = drawing.warnings
        assert "is read as round" in warning


def test_a_turned_shape_with_an_odd_number_of_sides_has_a_corner_on_the_negative_x_axis() -> None:
    low, high = openscad.read_text("rotate_extrude($fn = 5) square([10, 20]);", "part.scad").tree.bounds()
    assert low[0] == pytest.approx(-10.0, abs=1e-9)
    assert high[0] == pytest.approx(10.0 * np.cos(pi / 5), abs=1e-9)


def test_a_cube_is_rounded_by_what_has_few_sides() -> None:
    """A square and an octagon: both areas, and for each of four sides its length times how far that reaches."""
    text = "minkowski() {{ cube(10); {}; }}"
    bar = openscad.read_text(text.format("cylinder(r = 2, h = 4, center = true, $fn = 8)"), "part.scad")
    assert bar.warnings == ()
    area = 100.0 + 4 * 10.0 * 2.0 + 8 * 0.5 * 4.0 * np.sin(pi / 4)
    assert Solid.from_csg(bar.tree).volume == pytest.approx(14.0 * area, rel=1e-6)
    ball = openscad.read_text(text.format("sphere(r = 2, $fn = 8)"), "part.scad")
    assert ball.warnings == ()
    assert 10.0 * area < Solid.from_csg(ball.tree).volume < 14.0 * area


def test_a_sum_of_what_is_not_convex_is_refused() -> None:
    cross = "linear_extrude(5) polygon([[0, 0], [20, 0], [20, 5], [5, 5], [5, 20], [0, 20]])"
    with pytest.raises(PalpateError, match="no exact form"):
        openscad.read_text(f"minkowski() {{ cube(10); {cross}; }}", "part.scad")


def test_a_part_keeps_its_tree_in_any_unit_and_case(tmp_path: Path) -> None:
    file = tmp_path / "PLATE.CSG"
    file.write_text((FILES / "plate.csg").read_text())
    part = load_part(file, "cm", 0.5)
    assert part.csg is not None
    assert same_tree(part.csg, Cube((400, 250, 50)) - Cylinder(30, 100).at(100, 0, 0))
    assert part.solid.csg is part.csg


def test_arguments_that_nothing_has_are_warned_about_and_a_new_name_is_known() -> None:
    drawing = openscad.read_text("cube(1);\nlinear_extrude(h = 5, hieght = 9) square(10);", "part.scad")
    assert drawing.warnings == ("part.scad, line 2: linear_extrude has no argument hieght; it is left out",)
    assert drawing.tree.bounds()[1].tolist() == [10, 10, 5]
