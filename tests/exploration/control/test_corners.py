"""Two edges that meet are a corner, and a hollow that turns as far under the pad is a bend."""

import numpy as np
import pytest

from exploration.control.corners import CornerConfig, Meeting, is_sharp, meeting
from exploration.control.windows import window_about
from exploration.devices.guard import Observation
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.followed import Followed
from exploration.sensing.lines.hough import sure_lines
from exploration.sensing.physics.elastomer import pressure
from exploration.sensing.physics.gap import indentation
from exploration.sensing.spec import load_sensor
from models.csg import Cube, Prism
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


def block(outline):
    return Solid.from_csg(Prism(tuple(map(tuple, outline)), 20.0))


def window():
    """The corner of a window at the origin, 11 mm from where the plate about it ends."""
    return Solid.from_csg(
        Cube((90.0, 60.0, 20.0)).at(12.0, -19.0, 0.0) - Cube((50.0, 30.0, 40.0)).at(25.0, -15.0, 0.0)
    )


def quiet_frame(solid, seed, at=0.0):
    """The pad along +y, a little inside where it turns, and pressed down."""
    where = pose(frame_along([0.0, 0.0, -1.0], [0.0, 1.0, 0.0]), [-1.0, at, 9.5])
    depth = pressure(indentation(solid, where, SPEC), SPEC) / SPEC.elastomer.stiffness
    depth = depth + NOISE * np.random.default_rng(seed).standard_normal(depth.shape)
    sigma = np.full(depth.shape, NOISE)
    rubber = SPEC.elastomer
    image = TactileImage(SPEC.array, depth, sigma, rubber.spread, rubber.stiffness, 0.0, rubber.margin)
    return Observation(0.0, None, image, where, None, 0)


@pytest.mark.parametrize("seed", range(3))
def test_a_hollow_that_turns_as_far_as_a_corner_is_a_bend(seed):
    edge = Followed(np.zeros(6), np.eye(6), -1, 1.0, np.full(5, np.inf), np.zeros(3), True)
    nowhere = np.zeros(3)
    corner = Meeting(np.array([0.0, 0.0, 9.5]), nowhere, nowhere, TURN, 0.0, 0.0)
    assert is_sharp(quiet_frame(block(inside_corner()), seed), edge, corner, CornerConfig())
    assert not is_sharp(quiet_frame(block(hollow()), seed), edge, corner, CornerConfig())


def test_a_corner_is_seen_in_a_part_of_the_pad_where_the_plate_ends_farther_on():
    edge = Followed(np.zeros(6), np.eye(6), -1, 1.0, np.full(5, np.inf), np.zeros(3), True)
    seen = quiet_frame(window(), 0, -2.3)
    assert meeting(seen, edge, CornerConfig()) is None
    assert meeting(seen, edge, CornerConfig(), sure_lines(seen.image, 3)) is None
    part = window_about(seen, np.array([2.0, 1.3]), 7.0)
    met = meeting(part, edge, CornerConfig())
    assert np.allclose(met.point, [0.0, 0.0, 9.5], atol=0.1)
    assert met.along @ [1.0, 0.0, 0.0] > 0.999
    assert met.inward @ [0.0, 1.0, 0.0] > 0.999


def test_no_part_of_the_pad_lies_about_a_place_that_is_off_it():
    seen = quiet_frame(window(), 0)
    assert window_about(seen, np.array([17.0, 0.0]), 7.0) is None
