"""What steps are chosen by, against all boxes summed one by one and sides dropped one by one."""

from itertools import combinations, product

import numpy as np
import pytest

from recognition.assembly.step_kernels import cumulative, greatest_boxes, kept_sides


@pytest.mark.parametrize("most", [1, 7, 40, 10_000])
@pytest.mark.parametrize("shape", [(1, 1, 1), (3, 1, 4), (4, 5, 3)])
def test_the_boxes_kept_are_those_that_come_to_the_most(shape, most):
    worth = np.random.default_rng(5).integers(-3, 4, shape).astype(float)  # so that many boxes are equal
    sums = np.pad(worth, ((1, 0),) * 3).cumsum(0).cumsum(1).cumsum(2)
    ends = [np.array(list(combinations(range(n + 1), 2))) for n in shape]
    told = np.array([worth[a:b, c:d, e:f].sum() for (a, b), (c, d), (e, f) in product(*ends)])
    kept, totals = greatest_boxes(sums, *ends, most)
    least = np.sort(told)[-min(most, len(told))]
    assert sorted(kept) == np.flatnonzero(told >= least).tolist()
    assert np.allclose(totals, told[kept])


def test_sums_are_of_all_bins_before():
    rng, counts = np.random.default_rng(6), (3, 1, 4)
    cells, worth = np.stack([rng.integers(0, n, 60) for n in counts], axis=1), rng.normal(size=60)
    table = np.zeros(counts)
    np.add.at(table, tuple(cells.T), worth)
    assert np.allclose(
        cumulative(cells, worth, counts), np.pad(table, ((1, 0),) * 3).cumsum(0).cumsum(1).cumsum(2)
    )


@pytest.mark.parametrize("seed", range(20))
def test_sides_are_dropped_that_let_in_what_is_worth_most(seed):
    rng = np.random.default_rng(seed)
    beyond = rng.random((rng.integers(1, 40), rng.integers(1, 8))) < rng.uniform(0.1, 0.6)
    worth = rng.normal(rng.normal(), 1.0, len(beyond))
    kept = set(range(beyond.shape[1]))
    while len(kept) > 1:
        let_in = {
            side: sum(worth[c] for c in range(len(beyond)) if {k for k in kept if beyond[c, k]} == {side})
            for side in sorted(kept)
        }
        best = max(let_in, key=lambda side: round(let_in[side], 6))
        if round(let_in[best], 6) < 0.0:
            break
        kept.remove(best)
    assert set(np.flatnonzero(kept_sides(beyond, worth))) == kept
