"""Solids that touch stay one, however they are scaled, turned or rounded."""

from __future__ import annotations

import numpy as np
import pytest

from models.csg import Csg, Cube, Cylinder, Operation, Placed, Polyhedron
from models.formats import openscad
from models.meshing.facets import facets
from models.meshing.flush import common_frame, flush, leaf_poses
from models.solid import Solid
from primitives.arrays import Floats
from primitives.pose import pose, random_rotation


def stand() -> Csg:
    points = (*((x, y, 10.0) for x, y in SQUARE), *((x / 2, y / 2, 55.0) for x, y in SQUARE))
    sides = tuple((k, (k + 1) % 4, (k + 1) % 4 + 4, k + 4) for k in range(4))
    body = Polyhedron(points, ((3, 2, 1, 0), (4, 5, 6, 7), *sides))
    return (Cube((70, 70, 10)).at(0, 0, 5) | body) - Cylinder(6, 40).at(0, 0, 50)


SQUARE = ((-25, -25), (25, -25), (25, 25), (-25, 25))


def leaf_by_leaf(tree: Csg, moved: Floats) -> Csg:
    """The tree with each leaf placed by itself, as a boundary that was felt is written."""
    if isinstance(tree, Placed):
        return leaf_by_leaf(tree.child, moved @ tree.pose)
    if isinstance(tree, Operation):
        return type(tree)(tuple(leaf_by_leaf(child, moved) for child in tree.children))
    return tree.placed(moved)


def bodies(tree: Csg) -> int:
    return len(Solid.from_csg(tree, 0.05).body.mesh.decompose())


@pytest.mark.parametrize("scale", [1 / 25.4, 0.3, 0.7, 0.790722087793867, 1.1, 2.592310285238472, 7.3])
def test_a_solid_on_another_stays_one_body_at_any_scale(scale: float) -> None:
    tree = openscad.read_text(openscad.text(stand()), scale=scale).tree
    assert bodies(tree) == 1
    assert Solid.from_csg(tree, 0.05 * scale).volume == pytest.approx(
        scale**3 * Solid.from_csg(stand(), 0.05).volume, rel=1e-9
    )


@pytest.mark.parametrize("seed", range(6))
def test_a_solid_on_another_stays_one_body_when_each_is_turned_by_itself(seed: int) -> None:
    rng = np.random.default_rng(seed)
    moved = pose(random_rotation(rng), rng.uniform(-90, 90, 3))
    assert bodies(leaf_by_leaf(stand(), moved)) == 1


def test_faces_of_six_digits_touch() -> None:
    assert bodies(Cube((30, 30, 33.3333)) | Cube((30, 30, 33.3334)).at(0, 0, 33.3334)) == 1


def test_faces_that_lie_visibly_apart_stay_apart() -> None:
    assert bodies(Cube((30, 30, 20)) | Cube((30, 30, 20)).at(0, 0, 20.001)) == 2


def test_a_face_across_an_axis_is_one_number_in_all_its_meshes() -> None:
    tree = Cube((10, 10, 0.3)) | Cylinder(3, 0.1 + 0.2).at(1, 1, 0.1 + 0.2)
    meshes = [facets(leaf.primitive, 0.01) for leaf in tree.leaves()]
    low, high = flush(meshes, list(leaf_poses(tree, np.eye(4))))
    assert low[:, 2].max() == high[:, 2].min()
    assert len(set(high[:, 2].tolist())) == 2


def test_the_frame_is_that_of_most_leaves() -> None:
    turned = pose(random_rotation(np.random.default_rng(3)), (1, 2, 3))
    tree = Cube((1, 1, 1)) | Cube((2, 2, 2)).placed(turned) | Cube((3, 3, 3)).placed(turned)
    assert common_frame(tree) == pytest.approx(pose(turned[:3, :3]))
    assert common_frame(stand()) == pytest.approx(np.eye(4))
