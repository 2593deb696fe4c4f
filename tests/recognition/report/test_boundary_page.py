import re
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

import recognition.report
from models.csg import Cube, Cylinder, Sphere
from models.part import Part
from models.solid import Solid
from recognition.libraries.shown import ShownBoundary, show, write_page
from recognition.report.boundary_words import SHAPES, counted, extent, neighbors
from recognition.report.face_graph import graph_svg

# how a color-blind eye sees linear RGB (Machado, Oliveira and Fernandes 2009, severity 1)
EYES = {
    "all cones": np.eye(3),
    "no red": [
        [0.152286, 1.052583, -0.204868],
        [0.114503, 0.786281, 0.099216],
        [-0.003882, -0.048116, 1.051998],
    ],
    "no green": [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.01182, 0.04294, 0.968881],
    ],
    "no blue": [
        [1.255528, -0.076749, -0.178779],
        [-0.078411, 0.930809, 0.147602],
        [0.004733, 0.691367, 0.3039],
    ],
}


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    path = tmp_path_factory.mktemp("boundary") / "bracket.html"
    write_page(show("bracket"), path)
    return path


@pytest.fixture
def opened(browser, page):
    browser.open(page)
    return browser


def test_the_page_names_no_other_file(page):
    assert not re.search(
        r"(src|href)\s*=|url\(|import\s*\(|fetch\(|https?://", page.read_text(encoding="utf-8")
    )


def test_what_a_file_is_called_cannot_become_markup(tmp_path):
    shown = show("block")
    hostile = dict(shown.summary) | {"name": "</script><b>{{data}}", "warnings": ["<i>"]}
    write_page(ShownBoundary(Part("x", shown.part.solid, None), shown.brep, hostile), tmp_path / "x.html")
    html = (tmp_path / "x.html").read_text(encoding="utf-8")
    assert "<h1>&lt;/script&gt;&lt;b&gt;{{data}}</h1>" in html
    assert html.count("</script>") == 2
    assert "<i>" not in html


def test_the_page_opens_without_a_complaint_and_draws(opened):
    assert opened.complaints() == []
    drawn = """(() => { const {scene} = window.palpate, gl = scene.gl, c = scene.canvas; scene.render();
      const p = new Uint8Array(c.width * c.height * 4);
      gl.readPixels(0, 0, c.width, c.height, gl.RGBA, gl.UNSIGNED_BYTE, p);
      let n = 0; for (let i = 3; i < p.length; i += 4) n += p[i] > 0; return n / (c.width * c.height); })()"""
    assert opened.evaluate(drawn) > 0.1


def test_a_face_under_the_pointer_is_marked_in_view_graph_and_table(opened):
    opened.evaluate("document.querySelector('tr[data-face=\"3\"]').dispatchEvent(new Event('mouseenter'))")
    assert opened.evaluate("window.palpate.scene.marked") == 3
    assert opened.evaluate("document.querySelectorAll('.marked').length") == 2
    opened.evaluate("document.querySelector('g[data-face=\"3\"]').dispatchEvent(new Event('mouseleave'))")
    assert opened.evaluate("window.palpate.scene.marked") == -1


def test_every_face_is_a_disc_and_every_pair_that_meets_a_line():
    summary = show("bracket").summary
    svg = graph_svg(summary)
    assert svg.count("<circle") == len(summary["faces"])
    pairs = {tuple(sorted(edge["faces"])) for edge in summary["edges"]}
    assert svg.count("<line") == len(pairs)
    assert svg.count('class="concave"') == 1
    assert svg.count("hollow") == 2


@pytest.fixture(scope="module")
def gear() -> ShownBoundary:
    return show("spur_gear")


def test_discs_do_not_hide_each_other(gear: ShownBoundary) -> None:
    svg = graph_svg(gear.summary)
    discs = np.array(re.findall(r'cx="([\d.]+)" cy="([\d.]+)" r="([\d.]+)"', svg), dtype=float)
    assert len(discs) == 72
    apart = np.linalg.norm(discs[:, None, :2] - discs[None, :, :2], axis=2) - discs[:, 2] - discs[:, None, 2]
    assert apart[np.triu_indices(72, 1)].min() > -2


def test_a_long_table_of_edges_is_folded_away(gear, tmp_path):
    write_page(gear, tmp_path / "gear.html")
    write_page(show("block"), tmp_path / "block.html")
    assert "<summary>206 edges</summary>" in (tmp_path / "gear.html").read_text(encoding="utf-8")
    assert "<summary>" not in (tmp_path / "block.html").read_text(encoding="utf-8")


def test_a_boundary_of_one_face_or_of_very_many_has_no_graph():
    assert graph_svg(show("sphere").summary) == ""
    face = show("sphere").summary["faces"][0]
    assert graph_svg({"faces": [face | {"id": i} for i in range(200)], "edges": []}) == ""


def test_faces_that_meet_twice_are_told_apart_by_the_concave_edge():
    edges = [{"faces": [0, 1], "kind": "convex"}, {"faces": [1, 0], "kind": "concave"}]
    assert neighbors({"edges": edges}) == {0: {1: "concave"}, 1: {0: "concave"}}


def test_a_face_is_described_in_words_that_name_its_lengths():
    tree = (Cube((40, 30, 20)) | Sphere(12).at(0, 0, 8)) - Cylinder(4, 60)
    solid = Solid.from_csg(tree, 0.05)
    from models.boundary import boundary

    faces = [face.as_json() for face in boundary(solid).faces]
    assert counted({"faces": faces}) == "6 planes, 1 cylinder, 1 sphere"
    words = {face["shape"]: extent(face) for face in faces}
    assert words["plane"].count("×") == 1
    assert "long" in words["cylinder"]
    assert "rim" in words["sphere"]


@pytest.mark.parametrize("eye", EYES)
@pytest.mark.parametrize("theme", [0, 1], ids=["light", "dark"])
def test_no_two_shapes_look_alike_to_any_eye(eye, theme):
    css = (Path(recognition.report.__file__).parent / "style.css").read_text()
    colors = [re.findall(rf"--{shape}: (#\w+)", css)[theme] for shape in SHAPES]
    seen = [_lab(color, np.array(EYES[eye])) for color in colors]
    assert min(np.linalg.norm(a - b) for a, b in combinations(seen, 2)) > 15


def _lab(color, eye):
    rgb = np.array([int(color[i : i + 2], 16) for i in (1, 3, 5)]) / 255
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    to_xyz = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
    xyz = to_xyz @ np.clip(eye @ linear, 0, 1) / [0.9505, 1, 1.089]
    x, y, z = np.where(xyz > 0.008856, np.cbrt(xyz), 7.787 * xyz + 16 / 116)
    return np.array([116 * y - 16, 500 * (x - y), 200 * (y - z)])
