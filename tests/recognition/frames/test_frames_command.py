"""`palpate frames` as a user meets it: what it prints, what it writes, what it refuses."""

import json
import os

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from recognition.cli import app

TOML = """
[array]
rows = 9
columns = 7
pitch = [2.5, 2.5]
[elastomer]
stiffness = 0.1
thickness = 3.0
spread = 1.5
[housing]
size = [20, 25, 30]
proud = 2.0
"""


def frames(*arguments):
    return CliRunner().invoke(app, ["frames", *map(str, arguments)])


def stack(rows=10, columns=16, count=30, rest=20):
    """A straight edge along the columns, pressed from frame `rest` on."""
    rng = np.random.default_rng(5)
    share = np.clip((np.arange(columns) - columns / 2 + 1.2) / 2.5, 0, 1)
    pressed = np.where(np.arange(count) >= rest, 1.0, 0.0)[:, None, None] * share
    return np.round(
        10 + 120 * np.broadcast_to(pressed, (count, rows, columns)) + rng.normal(size=(count, rows, columns))
    )


@pytest.fixture
def saved(tmp_path):
    np.save(tmp_path / "a.npy", stack())
    return tmp_path / "a.npy"


def test_json_has_one_entry_per_frame_with_the_promised_fields(saved):
    done = frames(saved, "--sensor", "lts210", "--json")
    assert done.exit_code == 0
    result = json.loads(done.stdout)
    assert result["sensor"] == "lts210"
    assert [row["index"] for row in result["frames"]] == list(range(30))
    for row in result["frames"]:
        assert {
            "index",
            "time_ms",
            "pad",
            "kind",
            "kinds",
            "lines",
            "arcs",
            "curvatures_per_mm",
            "force_n",
        } <= set(row)
        assert bool(row["lines"]) == (row["index"] >= 20)
    line = result["frames"][25]["lines"][0]
    assert {
        "angle_deg",
        "offset_mm",
        "angle_sigma_deg",
        "offset_sigma_mm",
        "length_mm",
        "material_side",
    } <= set(line)
    assert abs(line["angle_deg"] - 90) < 2


def test_what_is_not_known_is_null_and_said(saved):
    result = json.loads(frames(saved, "--json").stdout)
    row = result["frames"][-1]
    assert row["force_n"] is row["curvatures_per_mm"] is row["time_ms"] is None
    assert any("--sensor lts210" in warning for warning in result["warnings"])
    assert any("frames only" in warning for warning in result["warnings"])


def test_one_index_is_shown_in_full(saved):
    done = frames(saved, "--sensor", "lts210", "--index", 25)
    assert done.exit_code == 0
    assert "frame 25" in done.stdout
    assert "line 0: at" in done.stdout
    assert "│" in done.stdout
    rows = json.loads(frames(saved, "--index", 25, "--json").stdout)["frames"]
    assert [row["index"] for row in rows] == [25]


def test_the_overview_of_many_frames_stays_short(tmp_path):
    many = np.tile(stack(6, 6, 40, 20), (50, 1, 1))
    np.savez(tmp_path / "a.npz", frames=np.stack([many, many[:, ::-1], many * 0], axis=1))
    done = frames(tmp_path / "a.npz")
    assert done.exit_code == 0
    assert len(done.stdout.splitlines()) < 45
    assert "pad 2: nothing felt" in done.stdout
    assert "shorter touches" in done.stdout


def test_pictures_are_one_per_frame_in_contact(saved):
    folder = saved.parent / "pictures"
    done = frames(saved, "--png", folder, "--json")
    names = sorted(path.name for path in folder.iterdir())
    assert names == [f"frame-0000{i}-pad0.png" for i in range(20, 30)]
    assert [row.get("png", "") for row in json.loads(done.stdout)["frames"]][-10:] == names
    with Image.open(folder / names[0]) as image:
        assert len(image.convert("RGB").getcolors(1 << 20)) > 50


def test_a_sensor_of_ones_own_is_a_toml_file(tmp_path):
    (tmp_path / "mine.toml").write_text(TOML)
    np.save(tmp_path / "a.npy", stack(9, 7))
    result = json.loads(frames(tmp_path / "a.npy", "--sensor", tmp_path / "mine.toml", "--json").stdout)
    assert result["pads"][0]["pitch_mm"] == [2.5, 2.5]
    assert result["frames"][-1]["force_n"] > 0


@pytest.mark.parametrize(
    ("flags", "says"),
    [
        (["--index", "30"], "has frames 0 to 29"),
        (["--index", "-1"], "counted from 0"),
        (["--sensor", "lts211"], "did you mean lts210"),
        (["--sensor", "dsa"], "--sensor lts210"),
        (["--png", "."], "not empty"),
        (["--png", "a.npy"], "is a file"),
    ],
)
def test_what_is_wrong_is_one_line_and_leaves_nothing(flags, says, saved, monkeypatch):
    monkeypatch.chdir(saved.parent)
    done = frames("a.npy", *flags)
    assert done.exit_code == 1
    assert done.stdout == ""
    assert done.stderr.startswith("palpate: ")
    assert done.stderr.count("\n") == 1
    assert says in done.stderr
    assert os.listdir() == ["a.npy"]


def test_a_damaged_end_leaves_no_picture(tmp_path):
    np.savez(tmp_path / "a.npz", frames=stack())
    data = bytearray((tmp_path / "a.npz").read_bytes())
    data[-2000] ^= 0xFF
    (tmp_path / "a.npz").write_bytes(data)
    done = frames(tmp_path / "a.npz", "--png", tmp_path / "pictures")
    assert done.exit_code == 1
    assert "damaged" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["a.npz"]
