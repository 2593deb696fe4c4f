"""A drawing in few digits hangs together as the tree does."""

import numpy as np
import pytest

from models.csg import Csg, Cylinder
from models.formats import openscad
from models.normal.kept_whole import rounded_whole
from models.normal.rounding import rounded
from models.part import load_part
from models.solid import Solid, iou
from primitives.pose import pose, random_rotation


def stacked(seed: int) -> Csg:
    """A shaft in two steps, end to end, at any pose and of sizes that are not round."""
    rng = np.random.default_rng(seed)
    wide, narrow = rng.uniform(10, 20, 2)
    steps = Cylinder(wide, 2 * narrow) | Cylinder(0.7 * wide, wide).at(0, 0, narrow + 0.5 * wide)
    return steps.placed(pose(random_rotation(rng), rng.uniform(-50, 50, 3)))


def leaves_apart(tree: Csg) -> Csg:
    """The same, each leaf at its own pose, as an assembly places what it made."""
    placed = [leaf.primitive.placed(leaf.part_from_primitive) for leaf in tree.leaves()]
    return placed[0] | placed[1]


@pytest.mark.parametrize("seed", range(12))
def test_what_ends_flush_hangs_together_when_it_is_written(seed: int, tmp_path) -> None:
    tree = leaves_apart(stacked(seed))
    made = rounded_whole(tree, 0.02)
    openscad.write(made, tmp_path / "model.csg")
    solid = load_part(tmp_path / "model.csg").solid
    assert solid.parts == 1
    assert iou(solid, Solid.from_csg(tree)) > 0.995


def test_rounding_alone_parts_some_of_these() -> None:
    parted = [
        seed for seed in range(12) if Solid.from_csg(rounded(leaves_apart(stacked(seed)), 0.02)).parts > 1
    ]
    assert parted


def test_few_digits_are_enough_where_nothing_comes_apart() -> None:
    tree = Cylinder(10.123456, 20.0).at(1.23456, 0, 0)
    assert rounded_whole(tree, 0.02) == rounded(tree, 0.02)


def test_two_bodies_may_stay_two() -> None:
    tree = Cylinder(10.123456, 20.0) | Cylinder(5.0, 20.0).at(40.00001, 0, 0)
    assert rounded_whole(tree, 0.02) == rounded(tree, 0.02)
