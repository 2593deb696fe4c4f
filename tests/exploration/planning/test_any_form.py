"""What is left to an array that comes after others."""

from types import SimpleNamespace

import numpy as np

from exploration.planning.any_form import AnyForm
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from primitives.patch_graph import Face, PatchGraph

GRID = np.array([[x, y, 0.0] for x in (-5.0, 0.0, 5.0) for y in (-5.0, 0.0, 5.0)])


def face(number, *lots):
    """A flat face of lots of contacts, each of a sensor and a touch."""
    contacts = Contacts.concatenate(
        [Contacts.of(GRID, np.tile([0.0, 0.0, 1.0], (9, 1)), sensor=s, touch=t) for s, t in lots]
    )
    return Face(number, fit("plane", contacts), contacts)


def test_a_later_array_goes_on_over_faces_that_it_alone_has_felt_or_that_are_new():
    form = AnyForm.__new__(AnyForm)
    form._before = {0, 1, 2, 3, 4}
    floors = face(1, (1, 4)), face(2, (1, 5), (0, NOT_FELT))
    others = face(0, (0, 1)), face(3, (0, 2), (1, 6)), face(4, (0, NOT_FELT))
    form.found = SimpleNamespace(graph=PatchGraph((*floors, *others), ()))
    form.pad = SimpleNamespace(guard=SimpleNamespace(active=1))
    assert sorted(form._own_faces()) == [1, 2]
    form._before = {0, 1, 2}
    assert sorted(form._own_faces()) == [1, 2, 3, 4]
