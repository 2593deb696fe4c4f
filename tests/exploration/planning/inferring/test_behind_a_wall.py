"""What is missing beside a step is missing on the floor's side of a wall, and not behind it."""

import numpy as np
from scipy.ndimage import distance_transform_edt

from exploration.planning.inferring.plates import _behind
from exploration.planning.known.mosaic import Picture


def test_a_bore_lies_behind_the_wall_of_its_tube_and_a_step_in_the_open_does_not():
    i, j = np.indices((80, 80)) - 40.0
    away = np.hypot(i, j)
    wall = (away > 14.0) & (away < 18.0)
    floor = (away > 20.0) & (away < 36.0)
    nearest = distance_transform_edt(~floor, return_distances=False, return_indices=True).astype(np.int64)
    behind = _behind(Picture(wall.astype(float), np.ones_like(wall)), nearest)
    assert behind[away < 12.0].mean() > 0.95
    assert not behind[floor].any()
    assert not behind[away > 37.0].any()
