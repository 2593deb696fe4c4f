"""Bits of a touch, against what information must be."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from primitives.arrays import frozen
from recognition.matching.next_touch.held import Held
from recognition.matching.next_touch.information import information
from recognition.matching.next_touch.outcomes import Outcomes


def _known(names: list[str], weights: list[float], unknown: float = 0.0) -> Held:
    h = len(names)
    share = np.array(weights) / np.sum(weights) * (1.0 - unknown)
    return Held(tuple(names), (), frozen(share), frozen(np.zeros((h, 3))), frozen(np.ones(h)), unknown)


def _outcomes(depth: np.ndarray, hit: np.ndarray | None = None) -> Outcomes:
    c, h = depth.shape
    normal = np.tile([0.0, 0.0, 1.0], (c, h, 1))
    met = np.ones((c, h), dtype=bool) if hit is None else hit
    return Outcomes(
        frozen(met, bool), frozen(depth), frozen(normal), frozen(np.zeros((c, h, 4))), frozen(0 * depth),
        frozen(np.zeros((c, h)), bool),
    )  # fmt: skip


def test_what_all_hypotheses_foresee_alike_tells_nothing() -> None:
    names, poses = information(_outcomes(np.full((1, 3), 20.0)), _known(["a", "b", "c"], [1, 1, 1]))
    assert np.allclose(names, 0.0)
    assert np.allclose(poses, 0.0)


def test_two_objects_told_apart_for_sure_are_one_bit() -> None:
    names, _ = information(_outcomes(np.array([[10.0, 40.0]])), _known(["a", "b"], [1, 1]))
    assert abs(names[0] - 1.0) < 0.01


def test_meeting_something_tells_that_it_is_there_and_missing_it_tells_nothing() -> None:
    hit = np.array([[True, False]])
    names, _ = information(_outcomes(np.array([[10.0, 0.0]]), hit), _known(["a", "b"], [1, 1]))
    assert abs(names[0] - 0.5) < 0.01


def test_few_draws_of_loose_poses_tell_less_than_poses_that_are_known() -> None:
    depth = _outcomes(np.array([[10.0, 18.0, 14.0, 22.0]]))
    sharp = _known(["a", "a", "b", "b"], [1, 1, 1, 1])
    loose = replace(sharp, doubts=frozen(np.ones(4)))
    assert information(depth, sharp)[0][0] > 0.9
    assert information(depth, loose)[0][0] < 0.1


def test_two_poses_of_one_object_say_nothing_of_its_name() -> None:
    names, poses = information(_outcomes(np.array([[10.0, 40.0]])), _known(["a", "a"], [1, 1]))
    assert abs(names[0]) < 1e-9
    assert poses[0] > 0.9


def test_an_object_that_may_be_in_no_library_keeps_bits_back() -> None:
    depth = np.array([[10.0, 40.0]])
    sure, _ = information(_outcomes(depth), _known(["a", "b"], [1, 1]))
    doubtful, _ = information(_outcomes(depth), _known(["a", "b"], [1, 1], unknown=0.8))
    assert doubtful[0] < sure[0]


@settings(max_examples=40, deadline=None)
@given(st.lists(st.floats(0.05, 1.0), min_size=2, max_size=6), st.integers(0, 1000))
def test_no_touch_tells_more_than_there_is_to_know(weights: list[float], seed: int) -> None:
    rng = np.random.default_rng(seed)
    h = len(weights)
    named = [str(k % 3) for k in range(h)]
    known = _known(named, weights)
    names, poses = information(_outcomes(rng.uniform(0.0, 4.0, (5, h))), known)
    share = np.array([known.weights[rows].sum() for rows in known.groups])
    entropy = float(-(share * np.log2(share)).sum())
    whole = float(-(known.weights * np.log2(known.weights)).sum())
    assert (names >= 0.0).all()
    assert (names + poses <= whole + 1e-6).all()
    assert (names <= entropy + 0.35).all()  # a difference of two lower bounds
