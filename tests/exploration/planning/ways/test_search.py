import numpy as np

from exploration.planning.ways.search import beside_first, deepening_sweeps, not_below, sweeps

BOX = np.array([-300.0, -300.0, -300.0, 300.0, 300.0, 300.0])


def test_sweeps_begin_in_the_middle_and_leave_no_gap_that_hides_a_small_object():
    pad = (28.8, 18.0)
    lines = np.array([start[:2, 3] for start, _ in sweeps(BOX, pad, feature=10.0)])
    np.testing.assert_allclose(lines[0], 0.0)
    assert (np.diff(np.linalg.norm(lines, axis=1)) > -1e-9).all()
    rng = np.random.default_rng(0)
    for center in rng.uniform(-290.0, 290.0, (200, 2)):
        reach = np.asarray(pad) / 2 + 10.0
        assert (np.abs(lines - center) < reach).all(axis=1).any()


def test_every_sweep_goes_from_the_top_of_the_box_to_its_bottom_facing_down():
    for start, end in list(sweeps(BOX, (8.0, 8.0)))[:20]:
        assert (start[2, 3], end[2, 3]) == (300.0, -300.0)
        np.testing.assert_allclose(start[:3, 2], [0.0, 0.0, -1.0])


def test_deepening_sweeps_cover_what_sweeps_do_each_going_on_where_the_one_before_it_ended():
    pad, reached = (28.8, 18.0), {}
    for start, end in deepening_sweeps(BOX, pad):
        at = tuple(start[:2, 3])
        assert start[2, 3] == reached.get(at, 300.0)
        assert end[2, 3] < start[2, 3]
        assert tuple(end[:2, 3]) == at
        reached[at] = end[2, 3]
    assert set(reached.values()) == {-300.0}
    assert set(reached) == {tuple(start[:2, 3]) for start, _ in sweeps(BOX, pad)}


def test_deepening_sweeps_stay_shallow_near_the_middle_at_first():
    depths = [end[2, 3] for _, end in deepening_sweeps(BOX, (28.8, 18.0))]
    assert sorted(depths, reverse=True) == depths
    assert depths[0] == -75.0


def test_sweeps_beside_a_place_that_stopped_one_come_first_and_none_before_the_one_it_goes_on_from():
    lines = list(deepening_sweeps(BOX, (28.8, 18.0)))
    for done, high in ((6, 0.5), (30, -0.2), (60, -0.6)):
        at = lines[done - 1][0][:2, 3]
        place = np.array([at[0] + 12.0, at[1], 300.0 * high])
        told = beside_first(lines[done:], place)
        far = np.array([np.linalg.norm(start[:2, 3] - place[:2]) for start, _ in told])
        first = (far < 60.0) & np.array([start[2, 3] >= place[2] for start, _ in told])
        near = int(np.argmin(first))
        assert near > 0
        assert not first[near:].any()
        assert (np.diff(far[:near]) > -1e-9).all()
        reached = {tuple(start[:2, 3]): end[2, 3] for start, end in lines[:done]}
        for start, end in told:
            assert start[2, 3] == reached.get(tuple(start[:2, 3]), 300.0)
            reached[tuple(start[:2, 3])] = end[2, 3]
        assert len(told) == len(lines) - done


def test_no_sweep_goes_on_below_where_one_was_stopped():
    lines = list(deepening_sweeps(BOX, (28.8, 18.0)))
    start, end = lines[0]
    stopped = 0.5 * (start[:3, 3] + end[:3, 3])
    kept = not_below(lines[1:], stopped)
    assert 0 < len(lines) - 1 - len(kept) <= 2
    assert not any(np.allclose(begin[:2, 3], stopped[:2]) for begin, _ in kept)
