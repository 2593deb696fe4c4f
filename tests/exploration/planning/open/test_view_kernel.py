import numpy as np

from exploration.planning.open.view_kernel import looked_into

HALF, FIRST = np.array([8.0, 5.0]), 4.0


def test_each_approach_sees_what_lies_before_the_first_place_that_stops_it():
    rng = np.random.default_rng(0)
    unseen, felt = rng.uniform(-30.0, 30.0, (400, 3)), rng.uniform(-30.0, 30.0, (40, 3))
    shown = rng.uniform(size=40) < 0.3
    x, y = np.arange(-30.0, 31.0, 10.0), np.arange(-20.0, 21.0, 10.0)
    count, stop, new = looked_into(unseen, felt, shown, x, y, HALF, FIRST)
    assert count.shape == stop.shape == new.shape == (7, 5)
    for i, j in np.ndindex(7, 5):
        met = (np.abs(felt[:, :2] - [x[i], y[j]]) < HALF).all(axis=1)
        passed = (np.abs(unseen[:, :2] - [x[i], y[j]]) < HALF).all(axis=1)
        assert stop[i, j] == felt[met, 2].min(initial=np.inf)
        assert count[i, j] == (passed & (unseen[:, 2] < stop[i, j])).sum()
        ends = met & (felt[:, 2] < stop[i, j] + FIRST)
        assert new[i, j] == (ends.any() and not shown[ends].any())
    assert new.any()
    assert (~new).any()
