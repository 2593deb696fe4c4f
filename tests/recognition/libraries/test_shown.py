import json
import re

import numpy as np
import pytest
from typer.testing import CliRunner

from models import parts
from models.formats import mesh as mesh_files
from primitives.errors import PalpateError
from recognition.cli import app
from recognition.libraries.shown import show, write_page

FIELDS = {
    "name", "faces", "edges", "volume_mm3", "area_mm2", "extent_mm", "symmetry", "watertight",
    "unassigned_area_fraction", "freeform_area_fraction", "warnings",
}  # fmt: skip


def palpate(*arguments):
    return CliRunner().invoke(app, ["library", "show", *map(str, arguments)])


@pytest.fixture(scope="module")
def bracket():
    return show("bracket")


def test_json_has_the_fields_that_others_read_and_nothing_else_is_printed():
    done = palpate("plate_with_hole", "--json")
    shown = json.loads(done.stdout)
    assert set(shown) == FIELDS
    assert shown["name"] == "plate_with_hole"
    assert [face["shape"] for face in shown["faces"]].count("cylinder") == 1
    assert shown["volume_mm3"] == pytest.approx(80 * 50 * 10 - np.pi * 144 * 10, rel=1e-6)
    assert shown["extent_mm"] == pytest.approx([80, 50, 10])
    assert (shown["watertight"], shown["unassigned_area_fraction"], shown["warnings"]) == (True, 0.0, [])
    assert shown["symmetry"] == "D2"
    hole = next(face for face in shown["faces"] if face["shape"] == "cylinder")
    assert hole["parameters"]["radius_mm"] == 12
    assert not hole["convex"]


def test_the_terminal_names_every_face_its_neighbors_and_the_edges_by_kind():
    text = palpate("stepped_block").stdout
    assert "60 × 40 × 35 mm" in text
    assert "8 faces (8 planes), 18 edges" in text
    rows = [line for line in text.splitlines() if "■" in line]
    assert len(rows) == 8
    assert sum("[" in row for row in rows) == 2
    assert re.search(r"concave +line +1 +40\.0", text)


@pytest.mark.parametrize("columns", [80, 200])
def test_a_terminal_of_any_width_shows_whole_cells(columns, monkeypatch):
    monkeypatch.setenv("COLUMNS", str(columns))
    monkeypatch.setenv("FORCE_COLOR", "1")
    text = re.sub("\x1b\\[[0-9;]*m", "", palpate("pulley").stdout)
    assert "…" not in text
    row = next(line for line in text.splitlines() if "■ torus" in line)
    assert (
        row.split()
        == (
            "8 ■ torus in 23.13 × 289.03 r 46, tube 8 +z 5886.9 0 1"
            if columns < 100
            else "8 ■ torus inside 23.13 round tube, 289.03 round axis r 46, tube 8 +z 5886.9 0 1"
        ).split()
    )


def test_a_file_is_shown_as_a_built_in_part_is(tmp_path):
    from models.solid import Solid

    solid = Solid.from_csg(parts.build("block"))
    path = tmp_path / "my block.STL"
    mesh_files.save(solid, path)
    shown = show(str(path)).summary
    assert shown["name"] == "my block"
    assert [face["shape"] for face in shown["faces"]] == ["plane"] * 6
    assert shown["symmetry"] == "D2"


@pytest.mark.parametrize(
    ("arguments", "code", "says"),
    [
        (["brackett"], 1, "did you mean bracket?"),
        (["absent.step"], 1, "absent.step"),
        (["block", "--units", "miles"], 2, "miles"),
        (["block", "--scale", "-1"], 2, "scale"),
        (["block", "--out", "block.stl"], 1, "ends in .html"),
    ],
)
def test_what_is_wrong_is_one_line(arguments, code, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = palpate(*arguments)
    assert done.exit_code == code
    assert says in done.stderr
    assert len(done.stderr.splitlines()) == 1
    assert list(tmp_path.iterdir()) == []


def test_a_page_replaces_a_page_and_no_other_file(bracket, tmp_path):
    path = tmp_path / "page.html"
    write_page(bracket, path)
    write_page(bracket, path)
    other = tmp_path / "notes.html"
    other.write_text("mine")
    with pytest.raises(PalpateError, match="another name"):
        write_page(bracket, other)
    assert other.read_text() == "mine"
    (tmp_path / "folder.html").mkdir()
    with pytest.raises(PalpateError, match="folder"):
        write_page(bracket, tmp_path / "folder.html")
    with pytest.raises(PalpateError, match="cannot write"):
        write_page(bracket, tmp_path / "absent" / "page.html")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["folder.html", "notes.html", "page.html"]
