import numpy as np

from exploration.planning.known.places import Places


def test_of_all_places_in_one_cell_the_first_stays():
    places = Places(2)
    places.add(np.array([[0, 1], [2, 3], [0, 1]]), np.array([[0.1, 1.0], [2.0, 3.0], [0.2, 1.1]]))
    places.add(np.array([[2, 3], [4, 5]]), np.array([[2.2, 3.3], [4.0, 5.0]]))
    assert places.rows.tolist() == [[0.1, 1.0], [2.0, 3.0], [4.0, 5.0]]
    assert len(places) == 3


def test_what_was_remembered_keeps_its_row():
    places = Places()
    places.add(np.zeros((1, 3), dtype=int), np.full((1, 3), 0.5))
    before = places.rows
    places.add(np.ones((1, 3), dtype=int), np.ones((1, 3)))
    assert np.array_equal(places.rows[:1], before)
    assert len(before) == 1
