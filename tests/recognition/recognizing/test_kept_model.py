"""The model that `locate` is given is prepared once."""

import trimesh

from models import parts
from models.solid import Solid
from recognition.recognizing import kept_model as kept


def test_a_file_is_prepared_once_and_again_when_it_changes(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    file = tmp_path / "part.stl"
    made = []
    original = kept.make
    monkeypatch.setattr(kept, "make", lambda *a: made.append(a) or original(*a))
    for name in ("wedge", "wedge", "block"):
        solid = Solid.from_csg(parts.build(name))
        trimesh.Trimesh(solid.vertices, solid.triangles).export(file)
        entry, _ = kept.kept_model(str(file), "mm", 1.0, None)
        assert entry.name == "part"
        assert abs(entry.solid.volume - solid.volume) < 1e-3 * solid.volume
    assert len(made) == 2


def test_a_cache_that_cannot_be_written_is_done_without(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    entry, _ = kept.kept_model("wedge", "auto", 1.0, None)
    assert entry.name == "wedge"
    assert entry.symmetry.name == "C1"
