"""Ways round a ball, against the ball."""

import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from exploration.planning.ways.round_ball import Ball, way_out, way_round
from primitives import pose as se3


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000))
def test_no_leg_of_a_way_enters_the_ball(seed: int) -> None:
    rng = np.random.default_rng(seed)
    ball = Ball(rng.normal(size=3) * 50.0, float(rng.uniform(20.0, 120.0)))
    ends = []
    for _ in range(2):
        way = rng.normal(size=3)
        way *= (ball.radius + 1.0 + rng.exponential(60.0)) / np.linalg.norm(way)
        ends.append(se3.pose(se3.random_rotation(rng), ball.center + way))
    stops = way_round(ends[0], ends[1], ball)
    assert np.allclose(stops[-1], ends[1])
    for a, b in itertools.pairwise([ends[0], *stops]):
        share = np.linspace(0.0, 1.0, 60)[:, None]
        points = a[:3, 3] + share * (b[:3, 3] - a[:3, 3])
        assert np.linalg.norm(points - ball.center, axis=1).min() > ball.radius - 1e-6


def test_the_way_past_a_ball_that_is_not_between_is_straight() -> None:
    a, b = se3.pose(translation=[0.0, 0.0, 100.0]), se3.pose(translation=[30.0, 0.0, 100.0])
    assert len(way_round(a, b, Ball(np.zeros(3), 50.0))) == 1


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 10_000))
def test_the_way_out_ends_where_the_next_way_round_begins(seed: int) -> None:
    rng = np.random.default_rng(seed)
    ball = Ball(rng.normal(size=3) * 50.0, float(rng.uniform(20.0, 120.0)))
    turn, way = se3.random_rotation(rng), rng.normal(size=3)
    way /= np.linalg.norm(way)
    start = se3.pose(turn, ball.center + way * (ball.radius + rng.uniform(0.0, 300.0)))
    here = se3.pose(se3.random_rotation(rng), ball.center + rng.normal(size=3) * 0.2 * ball.radius)
    out = way_out(here, start, ball)
    a, b, c = (p[:3, 3] for p in (here, out, start))
    assert np.allclose(out[:3, :3], turn)
    assert np.isclose(np.linalg.norm(b - a) + np.linalg.norm(c - b), np.linalg.norm(c - a))
    away = float(np.linalg.norm(b - ball.center))
    assert np.isclose(away, min(ball.radius + 8.0, float(np.linalg.norm(c - ball.center))))
