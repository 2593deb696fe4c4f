import csv
import json
import os

import numpy as np
import pytest

from primitives.errors import PalpateError
from primitives.evidence import Contacts
from recognition.running.folder import RunFolder


def test_a_new_or_an_empty_folder_is_taken(tmp_path):
    assert RunFolder.create(tmp_path / "a" / "b", "block").path.is_dir()
    (tmp_path / "c").mkdir()
    assert RunFolder.create(tmp_path / "c", "block").path == tmp_path / "c"


def test_without_out_the_first_free_folder_below_runs_is_taken(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    paths = [RunFolder.create(None, "block").path.as_posix() for _ in range(3)]
    assert paths == ["runs/block", "runs/block-2", "runs/block-3"]


def test_a_run_is_replaced_only_when_asked(tmp_path):
    folder = RunFolder.create(tmp_path, "block")
    folder.recording.write_bytes(b"")
    folder.write_text("model.csg", "cube();")
    folder.finish({"closed": True})
    with pytest.raises(PalpateError, match="--overwrite"):
        RunFolder.create(tmp_path, "block")
    RunFolder.create(tmp_path, "block", overwrite=True)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "names", [["notes.txt"], ["summary.json", "notes.txt"], ["model.stl"], ["summary.json", "src"]]
)
def test_what_is_not_a_run_is_never_replaced(tmp_path, names):
    for name in names:
        (tmp_path / name).write_text("mine")
    with pytest.raises(PalpateError):
        RunFolder.create(tmp_path, "block", overwrite=True)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(names)


def test_a_file_in_the_way_is_refused(tmp_path):
    (tmp_path / "f").write_text("mine")
    with pytest.raises(PalpateError, match="give a folder"):
        RunFolder.create(tmp_path / "f", "block", overwrite=True)
    with pytest.raises(PalpateError):
        RunFolder.create(tmp_path / "f" / "below", "block")
    assert (tmp_path / "f").read_text() == "mine"


def test_the_remains_of_a_killed_run_can_be_overwritten(tmp_path):
    (tmp_path / "episode.mcap").write_bytes(b"")
    (tmp_path / "model.partial.stl").write_bytes(b"half")
    RunFolder.create(tmp_path, "block", overwrite=True)
    assert list(tmp_path.iterdir()) == []


def test_an_error_while_writing_leaves_the_old_file_and_nothing_else(tmp_path):
    folder = RunFolder.create(tmp_path, "block")
    folder.write_text("brep.json", "old")

    def write_half():
        with folder.writing("brep.json") as path:
            path.write_text("half")
            assert path.suffix == ".json"
            raise RuntimeError("killed")

    with pytest.raises(RuntimeError):
        write_half()
    assert [path.name for path in tmp_path.iterdir()] == ["brep.json"]
    assert (tmp_path / "brep.json").read_text() == "old"


def test_a_full_disk_is_one_line_and_leaves_nothing(tmp_path):
    folder = RunFolder.create(tmp_path, "block")
    (tmp_path / "summary.partial.json").symlink_to("/dev/full")
    with pytest.raises(PalpateError, match="No space left"):
        folder.finish({"closed": True})
    assert list(tmp_path.iterdir()) == []


@pytest.mark.skipif(os.geteuid() == 0, reason="left out: root may write anywhere")
def test_a_folder_that_may_not_be_written_is_one_line(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(PalpateError, match="cannot write"):
        RunFolder.create(tmp_path / "run", "block")


def test_contacts_are_a_table_that_others_read(tmp_path):
    contacts = Contacts.of([[1, 2, 3], [4, 5, 6]], [[0, 0, 1], [np.nan] * 3], sigma=0.05)
    RunFolder.create(tmp_path, "block").write_contacts(contacts, np.array([0, -1]))
    with (tmp_path / "contacts.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["x", "y", "z", "nx", "ny", "nz", "sigma", "face"]
    assert [float(rows[0][name]) for name in rows[0]] == [1, 2, 3, 0, 0, 1, 0.05, 0]
    assert rows[1]["nx"] == ""
    assert rows[1]["face"] == "-1"


def test_a_summary_is_strict_json(tmp_path):
    value = {
        "a": np.float64("nan"),
        "b": np.arange(2),
        "c": {"d": (1, float("inf"))},
        "e": np.True_,
        "f": None,
    }
    RunFolder.create(tmp_path, "block").finish(value)
    text = (tmp_path / "summary.json").read_text()
    assert json.loads(text) == {"a": None, "b": [0, 1], "c": {"d": [1, None]}, "e": True, "f": None}
