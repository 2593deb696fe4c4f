"""On which side of each face the material is, from positions and lines of normals alone."""

import numpy as np
import pytest

from primitives.segmentation.neighbors import lifted, linked, nearest
from primitives.segmentation.senses import senses


def box_with_slot(count, rng):
    """A block of 60 x 40 x 30 with a slot of 20 x 15 along its length: contacts, outward normals, faces."""
    walls = [  # axis, place, sense, low and high of the other two
        (0, 0, -1, (0, 0), (40, 30)), (0, 60, 1, (0, 0), (40, 30)),
        (1, 0, -1, (0, 0), (60, 30)), (1, 40, 1, (0, 0), (60, 30)),
        (2, 0, -1, (0, 0), (60, 40)), (2, 30, 1, (0, 0), (60, 10)), (2, 30, 1, (0, 30), (60, 40)),
        (2, 15, 1, (0, 10), (60, 30)), (1, 10, 1, (0, 15), (60, 30)), (1, 30, -1, (0, 15), (60, 30)),
    ]  # fmt: skip
    points, normals, face = [], [], []
    for k, (axis, at, sense, low, high) in enumerate(walls):
        n = int(count * np.prod(np.subtract(high, low)) / 13_000)
        p = np.insert(rng.uniform(low, high, (n, 2)), axis, at, axis=1)
        points.append(p)
        normals.append(np.tile(sense * np.eye(3)[axis], (n, 1)))
        face += [k] * n
    points, normals, face = np.concatenate(points), np.concatenate(normals), np.array(face)
    kept = ~((face < 2) & (points[:, 2] > 15) & (points[:, 1] > 10) & (points[:, 1] < 30))
    return points[kept], normals[kept], face[kept]


@pytest.mark.parametrize("seed", range(4))
def test_slots_and_outer_walls_look_out_whatever_sense_they_came_with(seed):
    rng = np.random.default_rng(seed)
    points, true, face = box_with_slot(600, rng)
    given = rng.choice([-1.0, 1.0], 10)
    lines = true * given[face][:, None]
    links = linked(nearest(lifted(points, lines), 9)[1])
    assert (senses(points, lines, face, np.zeros(10), links) * given > 0).all()


def test_a_sense_that_was_felt_stands():
    points, true, face = box_with_slot(400, np.random.default_rng(9))
    known = np.where(np.arange(10) == 3, -1.0, 0.0)
    links = linked(nearest(lifted(points, true), 9)[1])
    assert senses(points, true, face, known, links)[3] == -1.0
