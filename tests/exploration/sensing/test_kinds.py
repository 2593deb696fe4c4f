"""Probabilities of the kinds: right as often as they say."""

import numpy as np

from exploration.sensing.touch import KINDS, perceive


def random_field(frames, kind, rng):
    angle, offset = rng.uniform(0, np.pi), rng.uniform(-4, 4)
    if kind == "flat":
        return frames.plane(0.5, tuple(rng.normal(0, 0.004, 2)))
    if kind == "edge":
        return frames.edge(angle, offset)
    if kind == "curved":
        return frames.sphere(rng.uniform(15, 80), *rng.uniform(-3, 3, 2))
    first, second = frames.half(angle, offset / 2), frames.half(angle + np.pi / 2, rng.uniform(-2, 2))
    return lambda x, y: 0.5 * first(x, y) * second(x, y)


def test_what_is_told_surely_is_right(frames):
    rng = np.random.default_rng(0)
    told, right = [], []
    for kind in ("flat", "edge", "corner", "curved"):
        for _ in range(12):
            touch = perceive(frames(random_field(frames, kind, rng), rng))
            assert tuple(touch.kinds) == KINDS
            told.append(touch.kinds[touch.kind])
            right.append(touch.kind == kind)
    assert np.mean(right) > 0.9
    assert np.mean(right) > np.mean(told) - 0.08


def test_a_narrow_wall_and_a_narrow_cylinder_are_doubted(frames):
    """Hardly wider than the blur they look alike; neither may be told for certain."""
    rng = np.random.default_rng(1)
    for field in (lambda x, y: 0.5 * (np.abs(x) < 2.5), frames.cylinder(5.0, np.pi / 2)):
        kinds = [perceive(frames(field, rng)).kinds for _ in range(8)]
        assert np.mean([k["ridge"] + k["curved"] for k in kinds]) > 0.75
        assert 0.05 < np.mean([k["ridge"] for k in kinds]) < 0.95
