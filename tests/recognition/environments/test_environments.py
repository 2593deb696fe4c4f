"""Environments: what Gymnasium asks of them, actions that mean approaches, and our planner as a policy."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

gymnasium = pytest.importorskip("gymnasium", reason="left out: gymnasium is not installed (palpate[gym])")

from gymnasium.utils.env_checker import check_env  # noqa: E402

import recognition.environments  # noqa: E402, F401
from exploration.planning.round_ball import Ball  # noqa: E402
from recognition.environments.actions import ASIDE, action_of, approach_of  # noqa: E402
from recognition.environments.policies import EvenPolicy, InformationPolicy  # noqa: E402

FEW = ("block", "cylinder")
units = st.floats(-1.0, 1.0, width=32)


@given(way=st.tuples(units, units, units), aside=st.tuples(units, units), turn=st.floats(-0.99, 0.99))
@settings(max_examples=60, deadline=None)
def test_an_action_and_its_approach_mean_each_other(way, aside, turn):
    if np.linalg.norm(way) < 0.1:
        return
    ball = Ball(np.array([3.0, -8.0, 20.0]), 70.0)
    action = np.array([*way, *aside, turn])
    approach = approach_of(action, ball)
    again = approach_of(action_of(approach, ball), ball)
    np.testing.assert_allclose(again.start, approach.start, atol=2e-3)
    np.testing.assert_allclose(approach.direction, np.array(way) / np.linalg.norm(way), atol=1e-9)
    off = np.cross(approach.start[:3, 3] - ball.center, approach.direction)
    assert np.linalg.norm(off) == pytest.approx(ASIDE * ball.radius * np.linalg.norm(aside), abs=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "told"),
    [("palpate/Identify-v0", {"library": FEW}), ("palpate/Explore-v0", {"part": "block"})],
)
def test_gymnasium_has_nothing_to_say_against_it(name, told):
    env = gymnasium.make(name, max_touches=4, **told)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.filterwarnings("ignore", message=".*render.*")
        check_env(env.unwrapped, skip_render_check=True)


@pytest.mark.slow
def test_our_planner_names_the_part():
    env = gymnasium.make("palpate/Identify-v0", library=FEW)
    policy, total = InformationPolicy(), 0.0
    observation, info = env.reset(seed=1, options={"part": "cylinder"})
    for _ in range(25):
        assert env.observation_space.contains(observation)
        observation, reward, terminated, truncated, info = env.step(policy(env))
        total += reward
        if terminated or truncated:
            break
    assert info["answer"] == info["decision"] == "cylinder"
    assert total > 0.5


@pytest.mark.slow
def test_touches_cover_more_and_more():
    env = gymnasium.make("palpate/Explore-v0", part="block", max_touches=6)
    _, info = env.reset(seed=2)
    policy, covered = EvenPolicy("largest-gap"), [info["covered"]]
    truncated = False
    while not truncated:
        _, reward, _, truncated, info = env.step(policy(env))
        covered.append(info["covered"])
        assert reward == pytest.approx(covered[-1] - covered[-2] - 0.005)
    assert covered == sorted(covered)
    assert covered[-1] > 0.1
