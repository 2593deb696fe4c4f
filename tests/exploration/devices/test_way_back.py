import numpy as np

from exploration.devices.way_back import WayBack, WayBackConfig, leads_off
from primitives import pose as se3

LEGS = WayBackConfig(leg=20, between=5, stuck=6)


def along(x: float) -> np.ndarray:
    return se3.pose(translation=[x, 0.0, 0.0])


def came(ticks: int) -> WayBack:
    way = WayBack(LEGS)
    for k in range(ticks):
        way.add(along(float(k)))
    return way


def ends(leg: list[np.ndarray]) -> tuple[float, float]:
    return float(leg[0][0, 3]), float(leg[-1][0, 3])


def test_the_way_back_leads_over_what_was_come_last():
    way = came(100)
    leg = way.back()
    assert ends(leg) == (99.0, 80.0)
    assert [float(stop[0, 3]) for stop in way.stops(leg)] == [98.0, 93.0, 88.0, 83.0, 80.0]


def test_who_meets_something_where_it_has_just_backed_off_goes_back_farther_each_time():
    way = came(100)
    way.back()
    for end in (60.0, 40.0, 20.0):
        way.add(along(80.0))  # stopped at its first tick
        assert ends(way.back())[1] < end + 4.0  # a tick of each try counts


def test_who_came_away_from_there_goes_back_no_farther_than_to_where_it_had_backed_off():
    way = came(100)
    way.back()
    for k in range(10):
        way.add(along(79.0 - k))
    assert ends(way.back()) == (70.0, 79.0)


def test_an_array_that_never_moved_has_no_way_back():
    assert WayBack().back() == []


def test_another_array_goes_back_over_the_same_places():
    way, beside = came(30), se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 50.0, 0.0])
    way.turned_to(beside)
    assert np.allclose(way.back()[-1], along(10.0) @ beside)


def test_a_way_along_the_arrays_own_back_leads_off_what_it_touches():
    rising = [se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, z]) for z in (5.0, 3.0, 1.0)]
    assert leads_off(rising)
    assert not leads_off(rising[::-1])
