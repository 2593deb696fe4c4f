"""The best boxes over a grid of bins, against all of them summed one by one."""

from itertools import combinations, product

import numpy as np
import pytest

from recognition.assembly.box_kernel import greatest_boxes


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
