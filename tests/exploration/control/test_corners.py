"""Two edges that meet are a corner, and a hollow that turns as far under the pad is a bend."""

from types import SimpleNamespace

import numpy as np
import pytest

from exploration.control.corners import CornerConfig, Meeting, is_sharp
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.followed import Followed
from exploration.sensing.physics.elastomer import pressure
from exploration.sensing.physics.gap import indentation
from exploration.sensing.spec import load_sensor
from models.csg import Prism
from models.solid import Solid
from primitives.pose import frame_along, pose

SPEC = load_sensor("lts210")
NOISE = 0.009  # [mm] of eight frames
TURN = 0.93  # [rad]


def hollow():
    """(n, 2) of a clover, one of whose four hollows of 7 mm radius has its bottom at the origin."""
    t = np.linspace(0, 2 * np.pi, 1001)[:-1]
    r = 40.0 + 10.0 * np.cos(4.0 * (t - 0.25 * np.pi))
    return np.column_stack([r * np.cos(t) - 30.0, r * np.sin(t)])


def inside_corner():
    """(6, 2) of a block that two edges enter as far as the origin."""
    ahead = 60.0 * np.array([np.sin(0.5 * TURN), np.cos(0.5 * TURN)])
    return np.array([[0.0, 0.0], ahead, [-80.0, 60.0], [-80.0, -60.0], ahead * [1.0, -1.0]])


def quiet_frame(outline, seed):
    """The pad along +y, a little inside where it turns, and pressed down."""
    solid = Solid.from_csg(Prism(tuple(map(tuple, outline)), 20.0))
    where = pose(frame_along([0.0, 0.0, -1.0], [0.0, 1.0, 0.0]), [-1.0, 0.0, 9.5])
    depth = pressure(indentation(solid, where, SPEC), SPEC) / SPEC.elastomer.stiffness
    depth = depth + NOISE * np.random.default_rng(seed).standard_normal(depth.shape)
    sigma = np.full(depth.shape, NOISE)
    rubber = SPEC.elastomer
    image = TactileImage(SPEC.array, depth, sigma, rubber.spread, rubber.stiffness, 0.0, rubber.margin)
    return SimpleNamespace(image=image, world_from_sensor=where)


@pytest.mark.parametrize("seed", range(3))
def test_a_hollow_that_turns_as_far_as_a_corner_is_a_bend(seed):
    edge = Followed(np.zeros(6), np.eye(6), -1, 1.0, np.full(5, np.inf), np.zeros(3), True)
    nowhere = np.zeros(3)
    corner = Meeting(np.array([0.0, 0.0, 9.5]), nowhere, nowhere, TURN, 0.0, 0.0)
    assert is_sharp(quiet_frame(inside_corner(), seed), edge, corner, CornerConfig())
    assert not is_sharp(quiet_frame(hollow(), seed), edge, corner, CornerConfig())
