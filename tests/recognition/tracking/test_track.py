"""Trackers in closed loop: they find, follow and say what they followed, over a stage that obeys late."""

import io
import json

import numpy as np
import pytest
from bench_track_edge import loop, straight
from rich.console import Console
from tracking.outlines import disc, prism
from tracking.plant import Start, guard_over
from typer.testing import CliRunner

from primitives.evidence import Contacts
from recognition.cli import app
from recognition.tracking.options import TrackOptions
from recognition.tracking.run import run
from recognition.tracking.surface import SurfaceTrack
from recognition.tracking.text import nothing_followed
from recognition.tracking.view import View

UPRIGHT = (0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0)  # mm, and a quaternion that turns nothing
KEYS = {"command", "trace", "normals", "dihedral_deg", "closed", "lost", "force_n", "found", "truth"}


def test_a_straight_edge_is_followed_to_its_end_and_its_dihedral_felt():
    found = straight(120.0, 60.0, seed=3)
    assert found.ended == "length"
    assert np.sqrt(np.mean(found.off**2)) < 0.06
    assert found.dihedral == pytest.approx(120.0, abs=1.0)
    assert np.mean(np.abs(found.forces - 1.0) < 0.1) > 0.95


@pytest.mark.slow
def test_a_disc_is_followed_once_round():
    found = loop(*disc(12.0), 700, seed=2)
    assert found.ended == "closed"
    assert found.radius == pytest.approx(12.0, abs=0.1)
    assert found.gap < 0.15


@pytest.mark.slow
def test_the_outline_of_a_cube_closes_over_four_corners_and_the_run_says_so(tmp_path):
    options = TrackOptions("cube", seed=1, noise=0.05, out=tmp_path / "run")
    told = run(options, View())
    assert set(told) > KEYS
    assert told["closed"]
    assert not told["lost"]
    edges = told["found"]["edges"]
    assert [edge["curve"] for edge in edges] == ["line"] * 4
    assert np.allclose([edge["length_mm"] for edge in edges], 40.0, atol=0.1)
    assert np.allclose([edge["dihedral_deg"] for edge in edges], 90.0, atol=1.0)
    assert np.allclose(told["found"]["angles_between_deg"], 90.0, atol=0.5)
    assert told["truth"]["rms_mm"] < 0.15
    assert told["latency_ms"] == pytest.approx(20.0, abs=2.0)
    assert json.loads((tmp_path / "run" / "summary.json").read_text())["closed"]
    assert (tmp_path / "run" / "contacts.csv").read_text().count("\n") == len(told["trace"]) + 1


@pytest.mark.long
def test_an_edge_shorter_than_a_third_of_the_pad_is_drawn_between_its_corners(tmp_path):
    wedge = tmp_path / "wedge.csg"
    wedge.write_text("linear_extrude(height = 30) polygon([[-30, -14], [30, -14], [30, -9], [-30, 14]]);")
    options = TrackOptions(str(wedge), seed=1, pose=UPRIGHT, out=tmp_path / "run")
    told = run(options, View())
    assert told["closed"]
    lengths = sorted(edge["length_mm"] for edge in told["found"]["edges"])
    assert np.allclose(lengths, [5.0, 28.0, 60.0, np.hypot(60.0, 23.0)], atol=0.5)


@pytest.mark.long
@pytest.mark.parametrize(("size", "told_of"), [((90.0, 60.0, 10.0), 2), ((90.0, 60.0, 6.0), 0)])
def test_sharp_edges_of_narrow_faces_are_not_rounded(size, told_of, tmp_path):
    bar = tmp_path / "bar.csg"
    bar.write_text(f"cube({list(size)}, center = true);")
    pose = (0.0, 0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5), 0.0, 0.0)  # a narrow face up
    told = run(TrackOptions(str(bar), seed=2, pose=pose, out=tmp_path / "run"), View())
    roundings = [edge["rounding_mm"] for edge in told["found"]["edges"]]
    felt = [rounding for rounding in roundings if rounding is not None]
    assert len(felt) >= told_of
    assert all(rounding < 1.2 for rounding in felt)
    assert (told_of > 0) or any("no rounding is told" in warning for warning in told["warnings"])


@pytest.mark.slow
def test_the_outline_of_a_window_is_followed_though_the_plate_ends_beside_it(tmp_path):
    part = tmp_path / "window.csg"
    part.write_text(
        "difference() { cube([90, 60, 10], center = true);"
        " multmatrix([[1, 0, 0, -8], [0, 1, 0, 4], [0, 0, 1, 0], [0, 0, 0, 1]])"
        " cube([50, 30, 20], center = true); }"
    )
    told = run(TrackOptions(str(part), seed=8, out=tmp_path / "run"), View())
    assert told["closed"]
    lengths = sorted(edge["length_mm"] for edge in told["found"]["edges"])
    assert np.allclose(lengths, [30.0, 30.0, 50.0, 50.0], atol=0.2)


@pytest.mark.slow
def test_what_was_followed_before_a_wall_is_kept(tmp_path):
    told = run(TrackOptions("bracket", seed=1, out=tmp_path / "run"), View())
    assert told["found"]["ended"] == "blocked"
    assert not told["closed"]
    assert any("ran into" in warning for warning in told["warnings"])
    assert told["found"]["length_mm"] > 20.0
    assert told["truth"]["rms_mm"] < 0.1


@pytest.mark.slow
def test_a_ball_has_no_edge_which_is_one_line_and_exit_1(tmp_path):
    out = str(tmp_path / "run")
    result = CliRunner().invoke(app, ["track", "edge", "sphere", "--seed", "1", "--json", "--out", out])
    assert result.exit_code == 1
    assert json.loads(result.stdout)["lost"]
    assert result.stderr.count("\n") == 1
    assert "no edge was followed" in result.stderr


@pytest.mark.slow
def test_the_surface_of_a_ball_is_followed_and_is_round(tmp_path):
    told = run(TrackOptions("sphere", what="surface", seed=1, out=tmp_path / "run"), View())
    assert told["found"]["order"]["name"] == "sphere"
    assert told["truth"]["rms_mm"] < 0.1
    assert len(told["normals"]) == len(told["trace"])


def test_a_surface_that_is_lost_where_the_pad_came_down_is_followed_in_another_place(tmp_path):
    told = run(TrackOptions("o_ring", what="surface", seed=2, out=tmp_path / "run"), View())
    assert not told["lost"]
    assert told["found"]["length_mm"] > 10.0


@pytest.mark.parametrize(
    ("ended", "lost", "why"),
    [
        (
            ("concavity", "edge", "concavity"),
            False,
            "strokes met a concavity and an edge where the pad came down",
        ),
        (("wall", "lost"), True, "contact was lost; touch it elsewhere"),
        (("stopped",), True, "the pad was stopped where it came down"),
        ((), True, "the pad was stopped where it came down"),
    ],
)
def test_a_surface_that_was_not_followed_is_lost_where_it_says_so_and_nowhere_else(ended, lost, why):
    track = SurfaceTrack(Contacts.of([]), None, (), ended)
    told = nothing_followed({"what": "surface", "trace": [], "found": track.found()})
    assert track.lost == lost
    assert told.startswith(f"no surface was followed: {why}")


@pytest.mark.parametrize(
    ("flags", "word"),
    [
        (["corner", "cube"], "edge or a surface"),
        (["edge", "cube", "--speed-mm-s", "0"], "--speed-mm-s"),
        (["edge", "cube", "--latency-s", "3"], "--latency-s"),
        (["edge", "cube", "--max-touches", "0"], "--max-touches"),
        (["edge", "cube", "--feature-mm", "-1"], "--feature-mm"),
    ],
)
def test_wrong_flags_are_one_line_and_exit_2(flags, word):
    result = CliRunner().invoke(app, ["track", *flags])
    assert result.exit_code == 2
    assert word in result.stderr
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize("command", [["track", "surface", "block"], ["probe", "block", "contact"]])
def test_no_more_touches_are_made_than_are_allowed(command, tmp_path):
    told = ["--pose", "150,150,0,1,0,0,0", "--max-touches", "1", "--out", str(tmp_path / "run")]
    result = CliRunner().invoke(app, [*command, *told])
    assert result.exit_code == 1
    assert (
        "nothing was found: all touches that were allowed are made (1); raise --max-touches" in result.stderr
    )
    assert result.stderr.count("\n") == 1


def test_the_picture_shows_taxels_line_force_and_what_is_done(edge_seen):
    view = View()
    view.doing("following the edge")
    console = Console(
        width=80, record=True, force_terminal=True, color_system="truecolor", file=io.StringIO()
    )
    console.print(view.picture(edge_seen))
    lines = console.export_text(styles=False).splitlines()
    assert lines[0].startswith("following the edge")
    assert [len(line.rstrip()) for line in lines[1:11]] == [32] * 10
    assert f"{edge_seen.force:.1f} N" in lines[11]


@pytest.fixture(scope="module")
def edge_seen():
    x, y, z = np.eye(3)
    return guard_over(prism(90.0), Start(np.zeros(3), -z, x, y), 0).hold()
