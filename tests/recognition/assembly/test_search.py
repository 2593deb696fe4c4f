"""The search for the shortest list of primitives, over the cells of turned parts."""

import numpy as np
import pytest

from primitives.shapes import Cylinder, Plane
from recognition.assembly.exchange import exchanged
from recognition.assembly.lists import Step, Target, held_after
from recognition.assembly.pairs import rounded
from recognition.assembly.search import shortest
from recognition.assembly.steps import single_steps
from recognition.assembly.vocabulary import Candidate, Direction, Vocabulary, frame_of

Z = np.eye(3)[2]
HEIGHTS, RADII = (0.0, 6.0, 25.0, 41.0), (10.0, 13.0, 16.0, 24.0)
SHAPES = [*(Plane(h * Z, Z) for h in HEIGHTS), *(Cylinder(np.zeros(3), Z, r) for r in RADII)]
LEVELS = range(len(HEIGHTS) + 1)
OUTSIDE = np.array(
    [[level > k for k in range(4)] + [ring > k for k in range(4)] for level in LEVELS for ring in LEVELS]
)


@pytest.mark.parametrize("seed", range(180, 200))
def test_no_single_step_betters_what_the_search_ends_with(seed):
    rng = np.random.default_rng(seed)
    solid = rng.random(len(OUTSIDE)) < 0.5
    weight = rng.choice([5.0, 30.0, 200.0, 600.0], len(OUTSIDE))
    target = Target(Vocabulary(SHAPES, OUTSIDE), solid, weight)
    found = shortest(target)
    after = single_steps(found, target)
    assert min((state.cost for state in after), default=np.inf) > found.cost - 1e-9


@pytest.mark.parametrize("seed", range(5))
def test_the_round_candidates_that_hold_most_are_found_without_adding_up_each(seed):
    vocabulary, worth = Vocabulary(SHAPES, OUTSIDE), np.random.default_rng(seed).standard_normal(len(OUTSIDE))
    ranked = vocabulary.rounds(worth, 1000)
    totals = [float(worth[vocabulary.mask(candidate)].sum()) for candidate in ranked]
    assert len(ranked) == 4 * 15  # four radii, and all slabs of four planes, open ends among them
    assert (np.diff(totals) < 2e-3).all()


def test_a_counterbore_taken_to_go_through_ends_at_its_ledge_and_leaves_the_bore():
    def cylinder(radius, low, high):
        slab = (None if low is None else HEIGHTS.index(low), None if high is None else HEIGHTS.index(high))
        return Candidate("cylinder", 4 + RADII.index(radius), slabs=(slab,))

    vocabulary = Vocabulary(SHAPES, OUTSIDE)
    outside, bore = (cylinder(24.0, 0.0, 6.0), cylinder(16.0, 0.0, 41.0)), cylinder(10.0, None, None)
    steps = (*(Step("add", each) for each in outside), Step("subtract", cylinder(13.0, 25.0, None)))
    weight = np.where(vocabulary.mask(bore), 1000.0, 150.0)
    bushing = held_after((*steps, Step("subtract", bore)), vocabulary, np.zeros(25, bool))
    target = Target(vocabulary, bushing, weight)
    through = (*steps[:2], Step("subtract", cylinder(13.0, None, None)))
    stuck = target.listed(through)
    assert stuck.wrong > target.options.leaf
    assert (exchanged(stuck, target).held == bushing).all()


def test_round_bodies_are_taken_one_of_each_however_many_ends_the_widest_may_have():
    vocabulary = Vocabulary(SHAPES, OUTSIDE)
    worth = np.where(vocabulary.mask(Candidate("cylinder", 7)), 1.0, -1.0)
    ends = vocabulary.rounds(worth, 4)
    assert {candidate.body for candidate in ends} != {4, 5, 6, 7}
    each = vocabulary.of_each(worth, 4)
    assert sorted(candidate.body for candidate in each) == [4, 5, 6, 7]
    for body in each:
        alike = [c for c in vocabulary.rounds(worth, 1000) if c.body == body.body]
        assert worth[vocabulary.mask(body)].sum() == max(worth[vocabulary.mask(c)].sum() for c in alike)


def test_a_corner_that_is_rounded_is_taken_off_and_the_round_body_put_there():
    """No one step pays: the corner less the arc is no primitive, and the cylinder lies in the box."""
    x, y, z = np.eye(3)
    walls = [Plane(k * n, n) for n in (x, y) for k in (0.0, 14.0, 20.0)]
    grid = np.array([[a, b, 0.0] for a in np.arange(-1.5, 23.0) for b in np.arange(-1.5, 23.0)])
    arc = Cylinder(14.0 * (x + y), z, 6.0)
    outside = np.stack([s.signed_distance(grid) > 0 for s in (*walls, arc)], axis=1)
    box = ((grid[:, :2] > 0) & (grid[:, :2] < 20)).all(axis=1)
    corner = (grid[:, :2] > 14).all(axis=1)
    target = Target(
        Vocabulary([*walls, arc], outside), box & ~(corner & outside[:, 6]), np.full(len(grid), 40.0)
    )
    square = next(c for _, c in target.vocabulary.best(np.where(box, 1.0, -1.0), 1))
    start = target.listed((Step("add", square),))
    assert min((after.cost for after in single_steps(start, target)), default=np.inf) > start.cost
    best = min(rounded(start, target), key=lambda after: after.cost)
    assert best.wrong == 0.0
    assert [step.operation for step in best.steps] == ["add", "subtract", "add"]


def test_a_frame_of_nearly_upright_directions_is_a_rotation():
    nearly = np.array([5e-4, np.sqrt(1.0 - 25e-8), 0.0])
    none = np.empty(0, dtype=np.int64)
    directions = [Direction(axis, (), none) for axis in (np.array([1.0, 0.0, 0.0]), nearly)]
    frame = frame_of(directions, (0, 1, None))
    assert np.allclose(frame.T @ frame, np.eye(3), atol=1e-12)
    assert np.linalg.det(frame) > 0.0
    for column, direction in zip(frame.T, directions, strict=False):
        assert np.linalg.norm(column - direction.axis) < 5e-4
