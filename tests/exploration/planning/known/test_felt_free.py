"""Free space that the skin felt, against what the faces predict."""

import numpy as np

from exploration.planning.known.felt_free import FeltFree
from primitives.half_spaces import HalfSpaces
from primitives.shapes import Plane

BOX = HalfSpaces.of([Plane(15.0 * s * np.eye(3)[a], s * np.eye(3)[a]) for a in range(3) for s in (-1.0, 1.0)])
TIP = 14.5 - 1.5 * np.stack(np.meshgrid(*[np.arange(3)] * 2, [0.0]), axis=-1).reshape(-1, 3)


def test_free_places_inside_the_prediction_open_what_lies_beside_them():
    free = FeltFree()
    free.add(TIP)
    there, far = np.array([15.0, 15.0, 15.0]), np.array([-15.0, 15.0, 15.0])
    assert free.opened(np.array([there, far]), BOX).tolist() == [True, False]


def test_free_places_outside_or_just_inside_contradict_nothing():
    free = FeltFree()
    free.add(TIP + 1.0)
    free.add(TIP + 0.4)
    assert not len(free.contradictions(BOX))


def test_one_free_place_alone_is_a_dead_taxel():
    free = FeltFree()
    free.add(TIP[:1] - 2.0)
    assert not len(free.contradictions(BOX))
