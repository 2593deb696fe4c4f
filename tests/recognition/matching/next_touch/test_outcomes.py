"""What a pad would feel, against where it can lie flush."""

import numpy as np

from exploration.planning.touching.lone_touch import Approach
from models.csg import Sphere
from models.solid import Solid
from primitives.pose import pose
from recognition.matching.next_touch.outcomes import foresee

DOWN = np.diag([1.0, -1.0, -1.0])
BALLS = Sphere(14.0).at(-16.0, 0.0, 0.0) | Sphere(14.0).at(16.0, 0.0, 0.0)


def _above(x: float) -> Approach:
    return Approach(pose(DOWN, np.array([x, 0.0, 50.0])), 100.0)


def test_no_normal_is_foreseen_where_the_pad_leans_on_two_things() -> None:
    felt = foresee([_above(16.0), _above(0.0)], (Solid.from_csg(BALLS),), (10.0, 10.0))
    assert felt.hit.all()
    assert felt.flush[:, 0].tolist() == [True, False]
    assert not felt.sharp[0, 0]


def test_a_ball_alone_is_flush_even_beside_its_top() -> None:
    felt = foresee([_above(8.0)], (Solid.from_csg(Sphere(14.0).at(16.0, 0.0, 0.0)),), (10.0, 10.0))
    assert felt.flush.all()
