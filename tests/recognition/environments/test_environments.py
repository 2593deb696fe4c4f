"""Environments: what Gymnasium asks of them, actions that mean approaches, and our planner as a policy."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

gymnasium = pytest.importorskip("gymnasium", reason="left out: gymnasium is not installed (palpate[gym])")

from gymnasium.utils.env_checker import check_env  # noqa: E402

import recognition.environments  # noqa: E402, F401
from exploration.planning.ways.round_ball import Ball  # noqa: E402
from models import parts  # noqa: E402
from models.formats.openscad.writer import write  # noqa: E402
from primitives.errors import PalpateError  # noqa: E402
from recognition.environments.actions import ASIDE, action_of, approach_of  # noqa: E402
from recognition.environments.asked import checked_action  # noqa: E402
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


IDENTIFY, EXPLORE = "palpate/Identify-v0", "palpate/Explore-v0"


@pytest.mark.parametrize(
    ("name", "told", "said"),
    [
        (EXPLORE, {"part": "blok"}, "did you mean block"),
        (EXPLORE, {"part": "missing.stl"}, "missing.stl"),
        (EXPLORE, {"part": []}, "empty list"),
        (EXPLORE, {"enough": 1.5}, "from 0 to 1"),
        (IDENTIFY, {"library": ("block", "cylindre")}, "did you mean cylinder"),
        (IDENTIFY, {"library": ("block",)}, "fewer than two"),
        (IDENTIFY, {"library": "missing"}, "missing"),
        (IDENTIFY, {"unknown": 2.0}, "from 0 to 1"),
        *(
            (name, told, said)
            for name in (IDENTIFY, EXPLORE)
            for told, said in (
                ({"sensor": "lts211"}, "did you mean lts210"),
                ({"max_touches": 0}, "max_touches"),
                ({"max_touches": 2.5}, "max_touches"),
                ({"noise": float("nan")}, "noise"),
                ({"noise": -0.1}, "noise"),
                ({"render_mode": "human"}, "render_mode"),
            )
        ),
    ],
)
def test_what_is_wrong_is_told_when_it_is_made(name, told, said):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # gymnasium's own, of what cannot be rendered
        with pytest.raises(PalpateError, match=said) as error:
            gymnasium.make(name, **told)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("action", [[np.nan] * 6, np.zeros(5), np.zeros((2, 3)), "up", None, [np.inf] * 6])
def test_an_action_that_is_none_is_one_line(action):
    with pytest.raises(PalpateError, match="6 finite numbers") as error:
        checked_action(action, 6)
    assert "\n" not in str(error.value)


@pytest.mark.slow
def test_a_library_may_be_a_folder_and_nothing_is_rendered(tmp_path):
    for name in FEW:
        write(parts.build(name), tmp_path / f"my_{name}.csg")
    env = gymnasium.make(IDENTIFY, library=tmp_path, max_touches=2, render_mode=None).unwrapped
    observation, info = env.reset(seed=3)
    assert info["names"] == ["my_block", "my_cylinder", "unknown"]
    assert observation["belief"].sum() == pytest.approx(1.0, abs=1e-5)
    with pytest.raises(PalpateError, match="7 finite numbers"):
        env.step(np.full(7, np.nan))


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
