"""Which cells a box passes through, beside every cell looked at one by one."""

import numpy as np
import pytest

from exploration.planning.known.swept_cells import SweptCells
from primitives.pose import pose, random_rotation, transform_points

BOX = np.array([-40.0, -40.0, -40.0, 40.0, 40.0, 40.0])
LOW, HIGH = np.array([-16.0, -11.0, -60.0]), np.array([16.0, 11.0, 0.0])


@pytest.mark.parametrize("seed", range(12))
def test_just_the_cells_within_the_box_count_as_swept(seed):
    rng = np.random.default_rng(seed)
    there = pose(random_rotation(rng), rng.uniform(-60.0, 60.0, 3))
    swept = SweptCells(BOX)
    swept.pass_through(there, LOW, HIGH)
    steps = np.arange(-40.0, 41.0, swept.cell)
    cells = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    local = transform_points(np.linalg.inv(there), cells)
    inside = ((local > LOW + 1.0) & (local < HIGH - [1.0, 1.0, 1.6])).all(axis=1)
    assert (swept.holds(cells) == inside).all()


def test_what_hardly_moved_is_not_noted_again_and_a_turn_is():
    swept = SweptCells(BOX)
    swept.pass_through(pose(None, [0.0, 0.0, 0.0]), LOW, HIGH)
    beyond = np.array([[16.0, 0.0, -20.0]])
    swept.pass_through(pose(None, [2.5, 0.0, 0.0]), LOW, HIGH)
    assert not swept.holds(beyond).any()
    swept.pass_through(pose(None, [3.5, 0.0, 0.0]), LOW, HIGH)
    assert swept.holds(beyond).all()
    turned = np.array([[8.0, 12.0, -20.0]])
    assert not swept.holds(turned).any()
    swept.pass_through(pose([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], [3.5, 0.0, 0.0]), LOW, HIGH)
    assert swept.holds(turned).all()


def test_what_lies_ahead_needs_no_pose_before_it():
    assert len(SweptCells(BOX).ahead(pose(None, [0.0, 0.0, 0.0]), LOW, HIGH)) > 0
