"""What pairs of touched places say of objects before any pose is known."""

import numpy as np
import pytest

from models import parts
from models.csg import Cube, Cylinder, Sphere
from models.library import Library, build, surface_samples
from models.library.pair_table import BINS, pair_bins, pair_scores, table_of
from models.solid import Solid
from primitives.pose import pose, random_rotation, rotate, transform_points

SHAPES = {"cube": Cube((60.0, 60.0, 60.0)), "rod": Cylinder(8.0, 90.0), "ball": Sphere(35.0)}


@pytest.fixture(scope="module")
def samples():
    return {name: surface_samples(Solid.from_csg(tree, 0.05)) for name, tree in SHAPES.items()}


def test_no_motion_changes_a_bin(samples):
    some = samples["rod"]
    motion = pose(random_rotation(np.random.default_rng(0)), [10.0, -40.0, 7.0])
    felt = np.ones(40, dtype=bool)
    here = pair_bins(some.points[:40], some.normals[:40], felt)
    there = pair_bins(transform_points(motion, some.points[:40]), rotate(motion, some.normals[:40]), felt)
    assert (here == there).mean() > 0.97
    assert here.max() < BINS


@pytest.mark.parametrize("felt", [True, False])
def test_contacts_rank_their_own_object_first(samples, felt):
    table = table_of(list(samples), [pair_scores(s) for s in samples.values()])
    for name, some in samples.items():
        ranks = table.rank(some.points[500:530], some.normals[500:530], np.full(30, felt))
        assert table.names[int(np.argmax(ranks))] == name


def test_one_contact_ranks_nothing(samples):
    table = table_of(list(samples), [pair_scores(s) for s in samples.values()])
    assert (table.rank(np.zeros((1, 3)), np.zeros((1, 3)), np.ones(1, dtype=bool)) == 0.0).all()


def test_a_stored_library_has_the_table_of_its_objects(tmp_path):
    import trimesh

    for name in ("wedge", "block"):
        solid = Solid.from_csg(parts.build(name))
        trimesh.Trimesh(solid.vertices, solid.triangles).export(tmp_path / f"{name}.stl")
    build(tmp_path)
    table = Library.open(tmp_path).pair_table
    assert table.names == ("block", "wedge")
    for name in table.names:
        column = table.scores[:, table.names.index(name)]
        assert (column == Library.open(tmp_path)[name].pairs).all()
    (tmp_path / "block.stl").unlink()
    assert Library.open(tmp_path).pair_table.names == ("wedge",)
