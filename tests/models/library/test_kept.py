"""What is asked of a tree's solid is made once for a user, to the bit, and again by other code."""

import numpy as np

from models import parts
from models.library import Library, kept
from models.library.kept import Kept
from models.meshing import manifold
from models.solid import Solid


def test_what_is_kept_is_what_would_be_made_and_is_made_once(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    tree = parts.build("wedge")
    fresh = Library.of({"wedge": Solid.from_csg(tree)})["wedge"]

    def assert_same(source):
        for key, values in vars(fresh.samples).items():
            assert np.array_equal(getattr(source.samples(), key), values, equal_nan=True)
        assert np.array_equal(source.field().values, fresh.field.values)
        assert (source.field().spacing, source.field().step) == (fresh.field.spacing, fresh.field.step)
        assert np.array_equal(source.pairs(), fresh.pairs)
        told = source.symmetry()
        assert (told.name, told.order, told.axis) == (fresh.symmetry.name, fresh.symmetry.order, None)
        assert np.array_equal(told.rotations, fresh.symmetry.rotations)
        solid = source.solid()
        for key in ("vertices", "triangles", "face_of_triangle"):
            assert np.array_equal(getattr(solid, key), getattr(fresh.solid, key))
        assert [repr(surface) for surface in solid.surfaces] == [repr(each) for each in fresh.solid.surfaces]
        assert (solid.volume, solid.csg) == (fresh.solid.volume, tree)

    assert_same(Kept(tree))
    with monkeypatch.context() as patched:
        patched.setattr(Solid, "from_csg", None)
        assert_same(Kept(tree))
    count = len(list(tmp_path.rglob("*.npz")))
    monkeypatch.setattr(kept, "made_by", lambda: b"other code")
    assert_same(Kept(tree))
    assert len(list(tmp_path.rglob("*.npz"))) == count == 5
    assert all(b"other code" in path.read_bytes() for path in tmp_path.rglob("*.npz"))


def test_no_manifold_is_made_of_what_is_kept_until_one_is_asked_for(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    tree = parts.build("hex_nut")
    fresh = Kept(tree).solid()
    with monkeypatch.context() as patched:
        patched.setattr(manifold, "_made", None)
        solid = Kept(tree).solid()
        assert (solid.area, solid.extent.tolist()) == (fresh.area, fresh.extent.tolist())
    assert solid.volume == fresh.volume > 0.0


def test_without_a_place_to_keep_it_all_is_made_in_memory(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert Kept(parts.build("cylinder")).symmetry().name == "D_inf"
