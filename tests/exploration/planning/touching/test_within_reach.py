"""Nothing asks the stage to leave its travel."""

import numpy as np
import pytest

from exploration.planning.touching.lone_touch import Approach
from exploration.planning.touching.within_reach import begun_within
from exploration.planning.ways.travel import kept_within, room_behind
from primitives.pose import frame_along, pose, random_rotation

REACH = np.array([-600.0, -600.0, -600.0, 600.0, 600.0, 600.0])


def _toward(goal: np.ndarray, start: np.ndarray, flown: float = 0.0) -> Approach:
    along = (goal - start) / np.linalg.norm(goal - start)
    return Approach(pose(frame_along(along), start), float(np.linalg.norm(goal - start)), flown)


@pytest.mark.parametrize("seed", range(20))
def test_an_approach_from_beyond_begins_on_its_line_within_reach(seed: int) -> None:
    rng = np.random.default_rng(seed)
    goal, start = rng.uniform(-300.0, 300.0, 3), 900.0 * random_rotation(rng)[:, 2]
    whole = _toward(goal, start, 100.0)
    made = begun_within(whole, REACH)
    at = made.start[:3, 3]
    assert (np.abs(at) < 600.0).all()
    assert np.allclose(at + made.length * made.direction, goal)
    late = float(np.linalg.norm(at - start))
    assert made.flown == pytest.approx(max(100.0 - late, 0.0))


def test_an_approach_within_reach_stays_as_it_is() -> None:
    near = _toward(np.zeros(3), np.array([0.0, 0.0, 500.0]))
    assert begun_within(near, REACH) is near


def test_an_approach_that_never_comes_near_stays_as_it_is() -> None:
    past = _toward(np.array([900.0, 0.0, 700.0]), np.array([-900.0, 0.0, 700.0]))
    assert begun_within(past, REACH) is past


def test_a_stop_beyond_the_border_is_moved_to_it() -> None:
    stop = pose(np.eye(3), np.array([10.0, -700.0, 601.0]))
    assert np.allclose(kept_within(stop, REACH)[:3, 3], [10.0, -598.0, 598.0])


def test_the_room_behind_an_array_ends_where_its_own_back_leads_out_of_the_travel():
    level = pose(frame_along(np.array([1.0, 0.0, 0.0])), [-590.0, 0.0, 0.0])
    down = pose(frame_along(np.array([0.0, 0.0, -1.0])), [0.0, 0.0, 599.0])
    assert room_behind(level, REACH) == pytest.approx(8.0)
    assert room_behind(down, REACH) == pytest.approx(1.0)  # in what is kept free for overshooting
    aslant = np.array([-1e-6, 0.0, -1.0]) / np.hypot(1.0, 1e-6)
    beside = pose(frame_along(aslant), [598.5, 0.0, 0.0])
    assert room_behind(beside, REACH) == pytest.approx(598.0, abs=0.1)
