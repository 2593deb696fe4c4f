"""Ways round a ball, against the ball."""

import itertools

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from exploration.planning.round_ball import Ball, way_round
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
