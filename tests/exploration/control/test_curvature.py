import numpy as np
import pytest

from exploration.control.dwell import dwell
from exploration.control.feel import feel
from exploration.control.procedures.curvature import four_direction_curvature
from exploration.control.procedures.land import land
from models.csg import Cube, Cylinder, Sphere
from primitives import pose as se3

DOWN = np.diag([1.0, -1.0, -1.0])


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("tree", "top", "order"),
    [
        (Cube((80.0, 60.0, 20.0)), 10.0, "plane"),
        (Cylinder(20.0, 90.0).turned("y", np.pi / 2), 20.0, "cylinder or cone"),
        (Cylinder(35.0, 90.0).turned("y", np.pi / 2).turned("z", 0.6), 35.0, "cylinder or cone"),
        (Sphere(25.0), 25.0, "sphere"),
    ],
)
def test_four_directions_name_the_order_of_the_surface(over, tree, top, order, seed):
    guard, _ = over(tree, se3.pose(DOWN, [1.0, -1.0, top + 5.0]), seed=seed)
    assert land(guard, np.array([0.0, 0.0, -1.0]), 20.0, 25.0)
    seen = dwell(guard, 16)
    found = four_direction_curvature(seen.image, feel(seen.image))
    assert found.order == order


def test_the_ridge_of_a_cylinder_is_its_axis(over):
    turn = 0.5
    tree = Cylinder(20.0, 90.0).turned("y", np.pi / 2).turned("z", turn)
    guard, _ = over(tree, se3.pose(DOWN, [0.0, 0.0, 25.0]))
    assert land(guard, np.array([0.0, 0.0, -1.0]), 20.0, 25.0)
    seen = dwell(guard, 16)
    found = four_direction_curvature(seen.image, feel(seen.image))
    axis = guard.world_from_sensor[:3, :2] @ found.ridge
    assert abs(axis @ [np.cos(turn), np.sin(turn), 0.0]) > np.cos(np.radians(8.0))
    assert 0.6 / 20.0 < found.four.k1[0] < 1.2 / 20.0
