"""A ball's place before the pad, and the array's place on its flange, from presses made with known poses."""

import numpy as np
import pytest

from exploration.sensing.calibrating.ball import BallPress, ball_of
from exploration.sensing.calibrating.mount import BallTouch, PlaneTouch, mount_of
from exploration.sensing.calibrating.rest import mean_frame
from exploration.sensing.calibration import Calibration
from models.csg import Sphere
from models.solid import Solid
from primitives import pose as se3
from primitives.errors import PalpateError

RADIUS, SIZE = 15.0, (28.8, 18.0)


def test_a_ball_is_found_to_hundredths_of_a_millimeter(specimen):
    made = specimen("lts210", 0, gain_spread=0.0, dead=0.0)
    ball = Solid.from_csg(Sphere(RADIUS))
    known = Calibration.nominal(made.spec)
    for x, y, depth in ((0.0, 0.0, 0.5), (4.1, -2.3, 0.7), (-6.2, 3.0, 0.4)):
        sensor = se3.pose(np.diag([1.0, -1.0, -1.0]), [-x, y, RADIUS - depth])
        found = ball_of(mean_frame(made.press(ball, sensor, 16)), RADIUS, known, made.spec.array)
        assert found
        assert found.place == pytest.approx([x, y, depth], abs=0.02)


def test_a_pad_that_touches_nothing_sees_no_ball(specimen):
    made = specimen("lts210", 0)
    found = ball_of(mean_frame(made.press(None)), RADIUS, Calibration.nominal(made.spec), made.spec.array)
    assert not found
    assert "not felt" in found.reason


def touches(rng, mount, ratio, turning=True):
    """What an array at `mount` reports of a ball and a table, depths too great by `ratio`."""
    center, balls, planes = np.array([50.0, -20.0, 30.0]), [], []
    down = np.diag([1.0, -1.0, -1.0])
    for _ in range(12):
        turn = down @ se3.rotation_exp(rng.uniform(-0.4, 0.4, 3) * [1, 1, 6] if turning else np.zeros(3))
        place = np.array([*rng.uniform(-4.0, 4.0, 2), rng.uniform(0.3, 0.7)])
        sensor = se3.pose(turn, center - turn @ [place[0], place[1], RADIUS - place[2]])
        seen = place * [1.0, 1.0, ratio] + rng.normal(0.0, 0.005, 3)
        balls.append(BallTouch(sensor @ se3.inverse(mount), BallPress(seen, np.full(3, 0.005), RADIUS)))
    for depth in rng.uniform(0.2, 0.6, 10):
        turn = down @ se3.rotation_exp([0.0, 0.0, rng.uniform(-3.0, 3.0) if turning else 0.0])
        sensor = se3.pose(turn, [10.0, 5.0, -depth])
        plane = np.array([ratio * depth, 0.0, 0.0])
        planes.append(PlaneTouch(sensor @ se3.inverse(mount), plane, 0.005))
    return balls, planes


@pytest.mark.parametrize("seed", range(4))
def test_the_mount_is_found_with_the_scale_of_depths_and_within_its_sigma(seed):
    rng = np.random.default_rng(seed)
    mount = se3.pose(se3.rotation_exp(rng.normal(0.0, 0.05, 3)), rng.normal(0.0, 2.0, 3))
    found = mount_of(*touches(rng, mount, 1.06), np.eye(4), SIZE, 0.1)
    off = se3.log(se3.inverse(mount) @ found.flange_from_sensor)
    assert np.linalg.norm(off[:3]) < min(0.1, 5.0 * found.translation_sigma)
    assert np.linalg.norm(off[3:]) < min(np.radians(0.2), 5.0 * found.rotation_sigma)
    assert found.depth_ratio == pytest.approx(1.06, abs=5.0 * found.depth_ratio_sigma)


def test_a_stage_that_does_not_turn_leaves_the_translation_open_and_says_so():
    rng = np.random.default_rng(0)
    mount = se3.pose(se3.rotation_exp([0.02, -0.01, 0.03]), [1.0, 2.0, -1.0])
    found = mount_of(*touches(rng, mount, 1.0, turning=False), np.eye(4), SIZE, 0.1)
    assert found.translation_sigma > 5.0
    off = se3.log(se3.inverse(mount) @ found.flange_from_sensor)
    assert np.linalg.norm(off[3:]) < np.radians(0.2)


def test_too_few_touches_are_refused():
    balls, planes = touches(np.random.default_rng(0), np.eye(4), 1.0)
    with pytest.raises(PalpateError, match="too few"):
        mount_of(balls[:3], planes, np.eye(4), SIZE, 0.1)
