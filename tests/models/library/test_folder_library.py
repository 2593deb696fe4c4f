import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
import trimesh

from models.csg import Csg, Cube, Cylinder
from models.formats.openscad.writer import write
from models.library import Library, build
from models.library.packed import map_arrays, write_arrays
from models.solid import Solid
from primitives.errors import PalpateError

PLATE = Cube((60, 40, 10)) - Cylinder(6, 30).at(10, 5, 0)
PARTS: dict[str, Csg] = {"plate": PLATE, "bar": Cylinder(10, 50), "box": Cube((30, 20, 10))}


def stored(folder: Path) -> dict[str, int]:
    return {path.name: path.stat().st_mtime_ns for path in (folder / ".palpate").glob("*.npz")}


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("made")
    for name, tree in PARTS.items():
        write(tree, folder / f"{name}.csg")
    build(folder)
    return folder


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(made, tmp_path / "library"))


def test_what_is_stored_is_what_the_solid_is(folder: Path) -> None:
    entry, fresh = Library.open(folder)["plate"], Library.of({"plate": Solid.from_csg(PLATE)})["plate"]
    assert entry.solid.volume == pytest.approx(fresh.solid.volume, rel=1e-4)
    assert [face.kind for face in entry.brep.faces] == [face.kind for face in fresh.brep.faces]
    assert not entry.brep.check()
    assert entry.symmetry.name == fresh.symmetry.name
    np.testing.assert_allclose(entry.samples.points, fresh.samples.points, atol=1e-4)
    points = np.random.default_rng(0).uniform(-25, 25, (500, 3))
    np.testing.assert_allclose(
        entry.field.signed_distance(points), fresh.field.signed_distance(points), atol=1e-9
    )
    np.testing.assert_allclose(
        entry.solid.signed_distance(points), fresh.solid.signed_distance(points), atol=0.03
    )


def test_an_entry_takes_less_than_200_kilobytes(folder: Path) -> None:
    assert max(path.stat().st_size for path in (folder / ".palpate").glob("*.npz")) < 200_000


def test_only_what_changed_is_made_again(folder: Path) -> None:
    before = stored(folder)
    write(Cube((35, 20, 10)), folder / "box.csg")
    write(Cube((5, 5, 50)), folder / "new.csg")
    (folder / "bar.csg").unlink()
    built = build(folder)
    assert (set(built.made), built.kept, built.removed) == ({"box", "new"}, ("plate",), ("bar",))
    after = stored(folder)
    assert len(after) == 3
    assert len(set(before.items()) & set(after.items())) == 1


def test_a_renamed_file_is_not_made_again(folder: Path) -> None:
    (folder / "bar.csg").rename(folder / "shaft.csg")
    built = build(folder)
    assert built.made == ()
    assert set(built.kept) == {"box", "plate", "shaft"}


def test_settings_of_one_file_make_that_one_again(folder: Path) -> None:
    (folder / "library.toml").write_text('["box.csg"]\nscale = 2.0\nname = "big box"\nmaterial = "steel"\n')
    built = build(folder)
    assert built.made == ("big box",)
    entry = Library.open(folder)["big box"]
    np.testing.assert_allclose(entry.solid.extent, [60, 40, 20], atol=1e-4)
    assert entry.material == "steel"


def test_opening_notices_a_change_and_reads_no_object(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[Path] = []
    monkeypatch.setattr("models.library.stored.map_arrays", lambda path: opened.append(path))
    assert list(Library.open(folder)) == ["bar", "box", "plate"]
    assert opened == []
    write(Cube((5, 5, 50)), folder / "new.csg")
    assert "new" in Library.open(folder)


def test_a_broken_file_is_named_and_the_rest_is_built(folder: Path) -> None:
    (folder / "torn.stl").write_text("solid torn\n facet normal 0 0 1\n")
    built = build(folder)
    assert list(built.failed) == ["torn.stl"]
    assert "export it again" in built.failed["torn.stl"]
    library = Library.open(folder)
    assert list(library) == ["bar", "box", "plate"]
    assert any("torn.stl" in warning for warning in library.warnings)


def test_a_file_of_several_bodies_is_left_out_with_the_setting_that_chooses_one(folder: Path) -> None:
    write(Cube((20, 20, 20)) | Cube((20, 30, 10)).at(40, 0, 0), folder / "pair.csg")
    built = build(folder)
    assert 'choose one with body = N under ["pair.csg"] in library.toml: 1 (' in built.failed["pair.csg"]
    (folder / "library.toml").write_text('["pair.csg"]\nbody = 2\n')
    build(folder)
    assert Library.open(folder)["pair"].solid.extent.max() == pytest.approx(30.0)


def test_two_files_of_one_stem_keep_their_whole_names(folder: Path) -> None:
    shutil.copy(folder / "box.csg", folder / "box.scad")
    assert set(Library.open(folder)) == {"bar", "box.csg", "box.scad", "plate"}


def test_a_changed_include_makes_its_file_again(folder: Path) -> None:
    (folder / "sizes.scad").write_text("w = 10;")
    (folder / "peg.scad").write_text("include <sizes.scad>\ncube([w, 10, 30]);")
    build(folder)
    (folder / "sizes.scad").write_text("w = 14;")
    np.testing.assert_allclose(sorted(Library.open(folder)["peg"].solid.extent), [10, 14, 30], atol=1e-4)


@pytest.mark.parametrize("harm", ["index", "no index", "entry", "no entry"])
def test_a_half_built_or_harmed_store_is_mended(folder: Path, harm: str) -> None:
    home = folder / ".palpate"
    entry = next(home.glob("*.npz"))
    victim = home / "index.json" if "index" in harm else entry
    if harm.startswith("no"):
        victim.unlink()
    else:
        victim.write_bytes(victim.read_bytes()[:100])
    built = build(folder)
    assert len(built.made) == (0 if "index" in harm else 1)
    assert all(entry.brep for entry in Library.open(folder).values())


def test_an_entry_that_vanished_is_read_from_its_file(folder: Path) -> None:
    library = Library.open(folder)
    for path in (folder / ".palpate").glob("*.npz"):
        path.unlink()
    assert len(library["box"].brep.faces) == 6


def test_a_folder_that_may_not_be_written_is_read_in_memory(folder: Path) -> None:
    shutil.rmtree(folder / ".palpate")
    (folder / ".palpate").write_text("in the way")
    with pytest.raises(PalpateError, match="cannot be written; copy the folder"):
        build(folder)
    assert len(Library.open(folder)["box"].brep.faces) == 6


@pytest.mark.parametrize(
    ("name", "fix"), [("none", "give a folder"), ("file", "give the folder that it is in")]
)
def test_no_folder_is_one_line(tmp_path: Path, name: str, fix: str) -> None:
    (tmp_path / "file").write_text("")
    for call in (build, Library.open):
        with pytest.raises(PalpateError, match=fix):
            call(tmp_path / name)


def test_an_empty_folder_says_what_to_put_in(tmp_path: Path) -> None:
    with pytest.raises(PalpateError, match="holds no CAD files"):
        Library.open(tmp_path)


def test_an_unknown_object_suggests_a_near_one(folder: Path) -> None:
    with pytest.raises(PalpateError, match="did you mean plate"):
        Library.open(folder)["plat"]


def test_arrays_come_back_as_they_were_and_aligned(tmp_path: Path) -> None:
    arrays = {"a": np.arange(7, dtype=np.int16), "bc": np.eye(3), "none": np.empty((0, 3), np.float32)}
    write_arrays(tmp_path / "x.npz", arrays)
    mapped = map_arrays(tmp_path / "x.npz")
    assert mapped is not None
    with np.load(tmp_path / "x.npz") as plain:
        for name, array in arrays.items():
            np.testing.assert_array_equal(mapped[name], array)
            np.testing.assert_array_equal(plain[name], array)
            assert mapped[name].flags.aligned
            assert not mapped[name].flags.writeable


@pytest.mark.slow
def test_two_builders_and_a_killed_one_leave_a_whole_library(tmp_path: Path) -> None:
    for k in range(5):
        write(PLATE | Cube((10, 10, 20 + k)), tmp_path / f"part{k}.csg")
    command = [sys.executable, "-c", f"from models.library import build; build({str(tmp_path)!r})"]
    killed = subprocess.Popen(command, env=os.environ | {"OMP_NUM_THREADS": "1"})
    deadline = time.monotonic() + 30
    while not list((tmp_path / ".palpate").glob("*.npz")) and time.monotonic() < deadline:
        time.sleep(0.01)
    killed.send_signal(signal.SIGKILL)
    killed.wait()
    assert not (tmp_path / ".palpate" / "index.json").exists()
    both = [subprocess.Popen(command, env=os.environ | {"OMP_NUM_THREADS": "1"}) for _ in range(2)]
    assert [process.wait() for process in both] == [0, 0]
    told = json.loads((tmp_path / ".palpate" / "index.json").read_text())
    assert len(told["rows"]) == 5
    assert build(tmp_path).made == ()
    assert not list((tmp_path / ".palpate").glob(".*partial"))


def test_what_was_mended_in_a_file_is_told_by_the_build_that_makes_it_and_by_later_ones(folder: Path) -> None:
    box = trimesh.creation.box((30.0, 20.0, 10.0))
    box.invert()
    box.export(folder / "inward.stl")
    box.invert()
    box.update_faces(np.arange(len(box.faces)) > 0)
    box.export(folder / "open.stl")
    first, second = build(folder), build(folder)
    assert first.made == ("inward", "open")
    assert [text for text in first.warnings if "faced inward" in text and "inward.stl" in text]
    assert [text for text in first.warnings if "had 1 hole" in text and "open.stl" in text]
    assert len(first.warnings) == 2
    assert second.warnings == first.warnings
