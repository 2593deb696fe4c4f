import numpy as np

from exploration.planning.ways.search import beside_first, coarse_first, not_below, sweeps

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


def test_coarse_sweeps_and_those_between_cover_what_sweeps_do_each_going_on_where_the_one_before_it_ended():
    pad, reached = (28.8, 18.0), {}
    for start, end in coarse_first(BOX, pad):
        at = tuple(start[:2, 3])
        assert start[2, 3] == reached.get(at, 300.0)
        assert end[2, 3] < start[2, 3]
        assert tuple(end[:2, 3]) == at
        reached[at] = end[2, 3]
    assert set(reached.values()) == {-300.0}
    assert set(reached) == {tuple(start[:2, 3]) for start, _ in sweeps(BOX, pad)}


def test_an_object_of_an_eighth_of_the_box_is_come_upon_long_before_all_is_swept():
    pad = (28.8, 18.0)
    ways = [(*start[:2, 3], end[2, 3]) for start, end in coarse_first(BOX, pad)]
    x, y, bottom = np.array(ways).T
    rng = np.random.default_rng(0)
    needed = []
    for center in rng.uniform(-180.0, 180.0, (200, 3)):
        beside = np.maximum(np.abs(np.stack([x, y], axis=1) - center[:2]) - np.asarray(pad) / 2, 0.0)
        met = (np.linalg.norm(beside, axis=1) < 37.5) & (bottom < center[2])
        needed.append(int(np.flatnonzero(met)[0]))
    assert np.median(needed) < 30
    assert max(needed) < len(ways) / 6


def test_sweeps_for_what_stands_on_the_bottom_go_there_once_each():
    lines = [
        (tuple(start[:2, 3]), start[2, 3], end[2, 3])
        for start, end in coarse_first(BOX, (8.0, 8.0), standing=True)
    ]
    assert len({at for at, _, _ in lines}) == len(lines) == len(list(sweeps(BOX, (8.0, 8.0))))
    assert {(begin, end) for _, begin, end in lines} == {(300.0, -300.0)}


def test_sweeps_beside_a_place_that_stopped_one_come_first_and_none_before_the_one_it_goes_on_from():
    lines = list(coarse_first(BOX, (28.8, 18.0)))
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
    lines = list(coarse_first(BOX, (28.8, 18.0)))
    start, end = lines[0]
    stopped = 0.5 * (start[:3, 3] + end[:3, 3])
    kept = not_below(lines[1:], stopped)
    assert 0 < len(lines) - 1 - len(kept) <= 2
    assert not any(np.allclose(begin[:2, 3], stopped[:2]) for begin, _ in kept)
