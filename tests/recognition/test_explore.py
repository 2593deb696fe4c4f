"""Whole runs of the conductor, on small parts; and what it does when exploration goes wrong."""

import csv
import itertools
import json
import shutil
import tomllib
from collections import Counter

import numpy as np
import pytest
import trimesh

from exploration.planning.explorer import Explorer
from exploration.recordings.mcap import RecordedEvent, RecordedFrame, Recorder, read
from primitives.errors import NotWritten, PalpateError
from recognition.config import ExploreOptions, from_toml
from recognition.console.bugs import Bug
from recognition.explore import run
from recognition.reconstructing.options import ReconstructSourceOptions
from recognition.reconstructing.run import run as run_again
from recognition.running.folder import json_text
from recognition.running.summary import fault_of
from recognition.sources import read_source

SMALL = (-60.0, -60.0, -60.0, 60.0, 60.0, 60.0)
FILES = {
    "episode.mcap", "contacts.csv", "brep.json", "model.csg", "model.stl", "model.glb", "report.html",
    "summary.json", "config.toml",
}  # fmt: skip


def without_time(summary):
    return json_text({key: value for key, value in summary.items() if key != "wall_seconds"})


@pytest.fixture(scope="module")
def sphere(tmp_path_factory):
    """One run on a ball, watched."""
    folder, seen = tmp_path_factory.mktemp("runs") / "ball", []
    summary = run(ExploreOptions("sphere", workspace=SMALL, seed=3, noise=0.05, out=folder), seen.append)
    return folder, summary, seen


@pytest.mark.slow
def test_a_ball_becomes_a_ball(sphere):
    _, summary, _ = sphere
    assert summary["closed"]
    assert summary["ended"] == "closed"
    assert [face["shape"] for face in summary["faces"]] == ["sphere"]
    assert [(p["kind"], p["operation"]) for p in summary["primitives"]] == [("sphere", "add")]
    assert summary["csg"] == {"leaves": 1}
    assert summary["truth"]["iou"] > 0.99
    assert summary["volume_mm3"] == pytest.approx(4 / 3 * np.pi * 25**3, rel=0.01)


@pytest.mark.slow
def test_a_block_on_a_table_is_whole_and_the_hidden_face_is_inferred(tmp_path):
    options = ExploreOptions("block", support="table", noise=0.05, out=tmp_path / "run")
    summary = run(options, lambda _: None)
    assert summary["truth"]["iou"] > 0.99
    assert [face["status"] for face in summary["faces"]].count("inferred") == 1
    assert any("table" in warning for warning in summary["warnings"])
    assert summary["ended"] == "nothing reachable is open"


@pytest.mark.slow
def test_the_folder_holds_what_a_run_holds(sphere):
    folder, summary, _ = sphere
    assert {entry.name for entry in folder.iterdir()} == FILES
    assert json.loads((folder / "summary.json").read_text()) == json.loads(json_text(summary))
    assert set(summary["files"].values()) <= FILES


@pytest.mark.slow
def test_the_mesh_is_where_the_object_is(sphere):
    folder, summary, _ = sphere
    center = summary["truth"]["world_from_part"]["translation_mm"]
    for name in ("model.stl", "model.glb"):
        mesh = trimesh.load(folder / name, force="mesh")
        assert mesh.bounds.mean(axis=0) == pytest.approx(center, abs=0.1)
        assert np.ptp(mesh.bounds, axis=0) == pytest.approx([50.0] * 3, abs=0.2)


@pytest.mark.slow
def test_every_contact_names_the_face_that_it_lies_on(sphere):
    folder, summary, _ = sphere
    with (folder / "contacts.csv").open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) > 50
    faces = Counter(row["face"] for row in rows)
    assert faces["0"] > 0.95 * len(rows)
    center = np.array(summary["truth"]["world_from_part"]["translation_mm"])
    points = np.array([[float(row[k]) for k in "xyz"] for row in rows])
    assert np.median(np.abs(np.linalg.norm(points - center, axis=1) - 25.0)) < 0.1


@pytest.mark.slow
def test_the_recording_holds_every_frame_and_every_move(sphere):
    folder, summary, _ = sphere
    items = list(read(folder / "episode.mcap"))
    assert sum(isinstance(item, RecordedFrame) for item in items) == summary["frames"]
    kinds = Counter(item.kind for item in items if isinstance(item, RecordedEvent))
    assert kinds["move"] >= 1
    assert kinds["ended"] == 1


@pytest.mark.slow
def test_run_and_recording_give_the_explorations_own_model_again(sphere, tmp_path):
    folder, _, _ = sphere
    for number, source in enumerate((folder, folder / "episode.mcap")):
        again = tmp_path / str(number)
        run_again(ReconstructSourceOptions(source, out=again), lambda _: None)
        assert (again / "model.csg").read_text() == (folder / "model.csg").read_text()
    edited = tmp_path / "edited"
    shutil.copytree(folder, edited)
    lines = (folder / "contacts.csv").read_text().splitlines(keepends=True)
    (edited / "contacts.csv").write_text("".join(lines[:-1]))
    assert read_source(folder).explored is not None
    assert read_source(edited).explored is None


@pytest.mark.slow
def test_run_and_recording_cost_the_same_wherever_the_recording_lies(sphere, tmp_path):
    folder, summary, _ = sphere
    (tmp_path / "alone.mcap").write_bytes((folder / "episode.mcap").read_bytes())
    for source in (folder, folder / "episode.mcap", tmp_path / "alone.mcap"):
        cost = read_source(source).felt
        assert (cost.touches, cost.strokes) == (summary["touches"], summary["strokes"])
        assert cost.frames == summary["frames"]
        assert cost.travel == pytest.approx(summary["travel_mm"])
        assert cost.seconds == pytest.approx(summary["device_seconds"])


@pytest.mark.slow
def test_the_config_repeats_the_run(sphere, tmp_path):
    folder, summary, _ = sphere
    resolved = tomllib.loads((folder / "config.toml").read_text())["resolved"]
    assert resolved["world_from_part"] == summary["truth"]["world_from_part"]
    assert resolved["sensor"]["electronics"]["noise"] == 0.05
    told = from_toml(folder / "config.toml")
    again = run(ExploreOptions(**{**vars(told), "out": tmp_path / "again"}), lambda _: None)
    assert without_time(again) == without_time(summary)
    assert (tmp_path / "again" / "contacts.csv").read_text() == (folder / "contacts.csv").read_text()


@pytest.mark.slow
def test_progress_is_told_in_order(sphere):
    folder, summary, seen = sphere
    assert list(dict.fromkeys(p.phase for p in seen)) == ["exploring", "reconstructing", "writing"]
    assert all(a.frames <= b.frames for a, b in itertools.pairwise(seen))
    assert {p.folder for p in seen} == {folder}
    assert seen[-1].touches == summary["touches"]


def replaced_run(monkeypatch, tmp_path, moves):
    monkeypatch.setattr(Explorer, "run", moves)
    return run(ExploreOptions("cube", out=tmp_path / "run"), lambda _: None)


def test_a_fault_ends_a_run_that_is_still_told(monkeypatch, tmp_path):
    def moves(explorer):
        explorer.guard.hold(5)
        yield explorer.found
        raise np.linalg.LinAlgError("singular matrix")

    summary = replaced_run(monkeypatch, tmp_path, moves)
    assert summary["ended"] == "fault: LinAlgError: singular matrix"
    assert not summary["closed"]
    assert summary["csg"] is summary["truth"]["iou"] is summary["volume_mm3"] is None
    assert set(summary["truth"]["world_from_part"]) == {"translation_mm", "quaternion_wxyz"}
    assert any("no closed body" in warning for warning in summary["warnings"])
    assert any("bug in palpate" in warning for warning in summary["warnings"])
    assert "Traceback" in (tmp_path / "run" / "bug.txt").read_text()
    left = {entry.name for entry in (tmp_path / "run").iterdir()}
    assert left == {f for f in FILES if "model" not in f} | {"bug.txt"}


def test_a_device_that_fails_is_a_fault_and_no_bug(monkeypatch, tmp_path):
    def moves(explorer):
        yield explorer.found
        raise PalpateError("the stage does not answer; plug it in")

    summary = replaced_run(monkeypatch, tmp_path, moves)
    assert summary["ended"] == "fault: the stage does not answer; plug it in"
    assert fault_of(summary) == "the stage does not answer; plug it in"
    assert not (tmp_path / "run" / "bug.txt").exists()


def test_a_bug_after_exploration_leaves_the_recording_whole_and_its_details(monkeypatch, tmp_path):
    def moves(explorer):
        explorer.guard.hold(5)
        yield explorer.found

    def broken(*_, **__):
        raise ValueError("no such thing")

    monkeypatch.setattr("recognition.explore.reconstruct", broken)
    with pytest.raises(Bug, match=r"bug in palpate.*ValueError: no such thing.*bug\.txt"):
        replaced_run(monkeypatch, tmp_path, moves)
    assert {entry.name for entry in (tmp_path / "run").iterdir()} == {
        "config.toml",
        "episode.mcap",
        "bug.txt",
    }
    assert sum(isinstance(item, RecordedFrame) for item in read(tmp_path / "run" / "episode.mcap")) == 5


def test_a_disk_that_fills_up_ends_the_run_in_one_line(monkeypatch, tmp_path):
    def moves(explorer):
        yield explorer.found
        explorer.guard.hold(64)

    def full(recorder):
        raise NotWritten("cannot write episode.mcap (No space left on device); choose another folder")

    monkeypatch.setattr(Recorder, "_encode", full)
    monkeypatch.setattr(Recorder, "close", lambda recorder: recorder._file.close())
    with pytest.raises(NotWritten, match="No space left"):
        replaced_run(monkeypatch, tmp_path, moves)
    assert not (tmp_path / "run" / "summary.json").exists()


def test_an_object_of_which_nothing_is_learned_is_taken_for_convex_no_longer(monkeypatch, tmp_path):
    def moves(explorer):
        while not explorer.found.hollow and explorer.guard.cost.touches < 500:
            explorer.guard.cost.touches += 1
            yield explorer.found
        explorer.found.ended = "nothing reachable is open"

    summary = replaced_run(monkeypatch, tmp_path, moves)
    assert summary["ended"] == "nothing reachable is open"
    assert 30 < summary["touches"] < 100


def test_closed_is_claimed_of_a_body_only(monkeypatch, tmp_path):
    def moves(explorer):
        explorer.found.ended = "closed"
        yield explorer.found

    summary = replaced_run(monkeypatch, tmp_path, moves)
    assert (summary["closed"], summary["ended"]) == (False, "nothing reachable is open")


def test_an_interrupt_leaves_the_recording_whole_and_no_summary(monkeypatch, tmp_path):
    def moves(explorer):
        explorer.guard.hold(50)
        yield explorer.found
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        replaced_run(monkeypatch, tmp_path, moves)
    assert {entry.name for entry in (tmp_path / "run").iterdir()} == {"config.toml", "episode.mcap"}
    assert sum(isinstance(item, RecordedFrame) for item in read(tmp_path / "run" / "episode.mcap")) == 50


def test_on_a_stage_that_errs_a_block_is_one_cube_and_its_contacts_say_how_far_they_err(tmp_path):
    options = ExploreOptions("block", pose_noise=0.05, noise=0.05, seed=3, out=tmp_path / "run")
    summary = run(options, lambda _: None)
    sigma = np.loadtxt(tmp_path / "run" / "contacts.csv", delimiter=",", skiprows=1, usecols=6)
    assert summary["closed"]
    assert summary["csg"]["leaves"] == 1
    assert (tmp_path / "run" / "model.csg").read_text().count("cube(") == 1
    assert 0.03 < np.median(sigma) < 0.12  # of a contact and its reading together 0.056
