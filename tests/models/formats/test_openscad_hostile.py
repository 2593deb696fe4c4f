"""Files that ask for too much, reach too far or make no sense end in one line that names their line."""

from pathlib import Path

import pytest

from models.csg import Sphere
from models.formats import drawn, openscad
from models.formats.openscad.limits import Limits
from models.part import load_part
from primitives.errors import PalpateError

FEW = Limits(steps=20_000, length=2_001, solids=700)
DOUBLING = "function f(s, n) = n == 0 ? s : f([s, s], n - 1); x = f([1], 60); "
ENDLESS = {
    "module a() { a(); } a();": "line 1: calls go more than 400 deep",
    "function f(x) = f(x + 1) + 1;\ncube(f(1));": "line 1: calls go more than 400 deep",
    "function f(x) = f(x + 1); cube(f(1));": "computes too long",
    "f = function (x) f(x); cube(f(1));": "computes too long",
    "\nfor (i = [0 : 1e12]) cube(i);": "line 2: a loop has more than",
    "for (i = [0 : 0 : 5]) cube(1);": "a loop has more than",
    "for (i = [0 : 1e-9 : 5]) cube(1);": "a loop has more than",
    "for (i = [0 : 1500]) translate([i, 0, 0]) cube(1);": "draws more than 700 shapes",
    "for (i = [0 : 1500], j = [0 : 1500]) if (false) cube(1);": "draws more than|computes too long",
    "module a(n) { if (n > 0) { a(n - 1); a(n - 1); } else cube(1); } a(40);": "draws more than|computes too long",
    "module a(n) { if (n > 0) difference() { cube(9); a(n - 1); } else cube(1); } a(170);": "nests more than 150",
    "x = [for (i = [0 : 1999]) for (j = [0 : 1999]) i]; cube(1);": "a list has more than|computes too long",
    "x = [for (i = 0; true; i = i + 1) if (false) i]; cube(1);": "computes too long",
    'function f(s, n) = n == 0 ? s : f(str(s, s), n - 1); cube(len(f("ab", 60)));': "a string has more than",
    "function f(s, n) = n == 0 ? s : f(concat(s, s), n - 1); cube(len(f([1], 60)));": "a list has more than",
    DOUBLING + "cube(x == x ? 1 : 2);": "computes too long",
    DOUBLING + "y = -x; cube(1);": "computes too long",
    DOUBLING + "y = x + x; cube(1);": "computes too long",
    DOUBLING + "cube(len(str(x)));": "a string has more than|computes too long",
    "x = " + "[" * 3000 + "1" + "]" * 3000 + "; cube(1);": "more than 64 brackets",
    "\n" + "union() {" * 3000 + "cube(1);" + "}" * 3000: "line 2: more than 64 brackets",
    "x = " + "-" * 20_000 + "1; cube(1);": "nested too deeply",
    "translate([1, 0, 0]) " * 2_000 + "cube(1);": "nested too deeply|too deep",
    "cube(1);" * 260_000: "more than 2 MB",
    "linear_extrude(1) polygon([for (i = [0 : 1999]) [i, i * i], [0, 1], [-1, 0]]);": "more than 2000 points",
}
SENSELESS = {
    "cube([1, 2, 3);": "line 1: cannot read",
    "union() {\ncube(1);\n": "line 2: the file ends in the middle",
    'cube(1); x = "abc;': "line 1: cannot read",
    "cube(1);\n/* abc": "line 2: cannot read",
    "/*" * 100_000: "line 1",
    '"' * 100_001: "line 1",
    "\x01\x02": "line 1",
    "// nothing": "draws nothing",
    "\ncube(-1);": "line 2: cube's size must be greater than zero",
    "cube([0 / 0, 1, 1]);": "line 1: cube's size",
    "cube([1 / 0, 1, 1]);": "line 1: cube's size",
    "cube(undef);": "line 1: cube's size",
    'cube("big");': "line 1: cube's size",
    "sphere(r = undef);": "line 1: sphere's radius is undefined",
    "cylinder(h = 0, r = 1);": "line 1: cylinder's h must be greater than zero",
    "scale([0, 1, 1]) cube(1);": "line 1: scale flattens",
    "multmatrix([[1, 2], [3]]) sphere(1);": "line 1",
    'rotate("x") cube(1);': "line 1: rotate needs an angle",
    "linear_extrude(3) polygon([[0, 0], [10, 10], [10, 0], [0, 10.5]]);": "line 1: a prism's outline crosses",
    "polyhedron([[0,0,0],[1,0,0],[0,1,0],[0,0,1]], [[0,1,2],[0,1,9]]);": "line 1: polyhedron names points",
    "polyhedron([[0,0,0],[1,0,0],[0,1,0],[0,0,1]], [[0,1,2],[0,1,3],[1,2,3],[0,3,2]]);": "line 1: a polyhedron's",
    "x = 5 | 2;\ncube(x);": "line 1: no BitwiseOrOp",
    "cube(rands(1, 2, 1)[0]);": "line 1: no function rands",
    "rotate_extrude() translate([1, 0]) circle(2);": "line 1: rotate_extrude's shape",
    "include <x.scad>": "line 1: <x.scad> is another file",
    'cube(1);\nlinear_extrude(file = "x.dxf", height = 3);': "line 2: linear_extrude with file is outside",
    "rotate_extrude(start = 30, angle = 90) translate([9, 0]) circle(2);": "line 1: rotate_extrude with start",
}


@pytest.mark.parametrize("text", ENDLESS, ids=range(len(ENDLESS)))
def test_work_without_end_is_stopped_in_one_line(text: str) -> None:
    with pytest.raises(PalpateError, match=ENDLESS[text]) as caught:
        openscad.read_text(text, "part.scad", limits=FEW)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith("part.scad")


@pytest.mark.parametrize("text", SENSELESS, ids=range(len(SENSELESS)))
def test_what_makes_no_sense_is_named(text: str, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(PalpateError, match=SENSELESS[text]) as caught:
        openscad.read_text(text, "part.scad")
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("command", ["include", "use"])
@pytest.mark.parametrize(
    "wanted", ["../out.scad", "/etc/hostname", "link.scad", "deep/../../out.scad", "inner/link.scad"]
)
def test_nothing_outside_the_folder_is_opened(tmp_path: Path, command: str, wanted: str) -> None:
    home = tmp_path / "home"
    (home / "deep").mkdir(parents=True)
    (tmp_path / "out.scad").write_text("module out() { cube(1); }")
    (home / "link.scad").symlink_to(tmp_path / "out.scad")
    (home / "inner").symlink_to(tmp_path)
    (home / "part.scad").write_text(f"cube(10);\n{command} <{wanted}>\n")
    with pytest.raises(PalpateError, match=r"^part.scad, line 2: .*outside the file's folder"):
        openscad.read(home / "part.scad")


def test_files_that_include_each_other_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.scad").write_text("include <b.scad>\n")
    (tmp_path / "b.scad").write_text("\nuse <a.scad>\n")
    with pytest.raises(PalpateError, match=r"^b.scad, line 2: <a.scad> includes itself"):
        openscad.read(tmp_path / "a.scad")


def test_files_that_fan_out_are_refused(tmp_path: Path) -> None:
    for i in range(12):
        (tmp_path / f"{i}.scad").write_text(f"include <{i + 1}.scad>\n" * 2)
    (tmp_path / "12.scad").write_text("cube(1);")
    with pytest.raises(PalpateError, match="more than 100 files"):
        openscad.read(tmp_path / "0.scad")


def test_what_a_library_uses_stays_its_own(tmp_path: Path) -> None:
    (tmp_path / "inner.scad").write_text("module ball() { sphere(9); }")
    (tmp_path / "outer.scad").write_text("use <inner.scad>\nmodule two() { ball(); }")
    (tmp_path / "part.scad").write_text("use <outer.scad>\ntwo();")
    assert openscad.read(tmp_path / "part.scad").tree == Sphere(9)
    (tmp_path / "part.scad").write_text("use <outer.scad>\nball();")
    with pytest.raises(PalpateError, match="line 2: no module ball"):
        openscad.read(tmp_path / "part.scad")


def test_text_that_is_none_is_refused(tmp_path: Path) -> None:
    for data, words in (
        (b"cube(1);\n\xff\xfe", "line 2: not text in UTF-8"),
        (b"cube(1);\0", "binary zeros"),
    ):
        (tmp_path / "part.scad").write_bytes(data)
        with pytest.raises(PalpateError, match=words):
            openscad.read(tmp_path / "part.scad")


@pytest.mark.parametrize(("size", "words"), [("1e300", "more than 10 m"), ("1e-9", "less than 1 mm")])
def test_sizes_that_no_part_has_are_refused(tmp_path: Path, size: str, words: str) -> None:
    (tmp_path / "part.scad").write_text(f"cube({size});")
    with pytest.raises(PalpateError, match=words):
        load_part(tmp_path / "part.scad")


def test_one_of_several_bodies_is_chosen(tmp_path: Path) -> None:
    file = tmp_path / "part.scad"
    file.write_text(
        "cube(10); translate([20, 0, 0]) difference() { cube([40, 10, 10]); translate([10, -1, -1]) cube(20); }"
    )
    with pytest.raises(PalpateError, match="3 bodies, choose one with --body"):
        load_part(file)
    parts = [load_part(file, body=i) for i in (1, 2, 3)]
    assert [part.solid.volume for part in parts] == pytest.approx([1000, 1000, 1000])
    assert all(part.csg is not None for part in parts)
    with pytest.raises(PalpateError, match="no body 4"):
        load_part(file, body=4)


def test_splinters_that_a_cut_leaves_are_no_bodies(tmp_path: Path) -> None:
    """A corner cut off by a wedge that reaches 2 um too little at one end."""
    file = tmp_path / "cut.scad"
    file.write_text(
        "difference() { cube([60, 40, 20]); translate([50, -1, -1]) cube([9.998, 50, 50]); translate([59, 10, -1])"
        " cube([9, 50, 50]); }"
    )
    part = load_part(file)
    assert part.solid.volume == pytest.approx(50 * 40 * 20, rel=1e-3)


def test_a_body_far_smaller_than_another_can_be_chosen(tmp_path: Path) -> None:
    """A ten-millionth of the volume of the block that it was cut off."""
    file = tmp_path / "cut.scad"
    file.write_text(
        "difference() { cube([200, 200, 200]); difference() { translate([-1, -1, 150]) cube([300, 300, 99]);"
        " translate([1, 1, 198.5]) cube(1.2); } }"
    )
    assert load_part(file, body=2).solid.volume == pytest.approx(1.2**3, rel=1e-3)


@pytest.mark.parametrize(
    ("limit", "told"), [("_MOST", "more than 2 bodies"), ("_MOST_SHELLS", "more than 2 closed surfaces")]
)
def test_a_drawing_of_too_many_bodies_says_which_limit_it_passes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, limit: str, told: str
) -> None:
    monkeypatch.setattr(drawn, limit, 2)
    path = tmp_path / "many.scad"
    path.write_text("for (i = [0 : 2]) translate([3 * i, 0, 0]) cube(1);")
    with pytest.raises(PalpateError, match=told):
        load_part(path)
