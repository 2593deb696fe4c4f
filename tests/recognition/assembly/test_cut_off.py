"""Where a body ends that its faces leave open."""

from dataclasses import dataclass

import numpy as np

from primitives.evidence import Contacts
from primitives.fit import Fit, fit
from recognition.assembly.cut_off import cut_off


@dataclass
class Felt:
    fit: Fit
    contacts: Contacts


def sides_of_a_block(half=(30.0, 20.0, 10.0), but=()):
    """Faces of a block that were felt all over, but those whose outward axis is named, as +1 or -3."""
    faces = []
    for axis in range(3):
        for side in (1, -1):
            if side * (axis + 1) in but:
                continue
            grid = np.array(np.meshgrid(*[np.linspace(-h, h, 5) for h in half])).reshape(3, -1).T
            points = grid[np.abs(grid[:, axis] - side * half[axis]) < 1e-9]
            normals = np.zeros_like(points)
            normals[:, axis] = side
            contacts = Contacts.of(points, normals, touch=np.arange(len(points)))
            faces.append(Felt(fit("plane", contacts), contacts))
    return faces


def ways(ends):
    return sorted(tuple(int(v) for v in np.round(end.normals[0])) for end in ends)


def test_a_block_that_is_felt_all_round_needs_no_end():
    assert cut_off(sides_of_a_block()) == []


def test_where_nothing_was_felt_it_ends_at_the_last_contact():
    (end,) = cut_off(sides_of_a_block(but=(1,)))
    assert ways([end]) == [(1, 0, 0)]
    assert np.allclose(end.points[:, 0], 30.0, atol=1e-6)


def test_a_body_that_runs_past_its_contacts_is_ended_though_they_look_that_way():
    runs_on = np.array([[-30.0, -20.0, -10.0], [80.0, 20.0, 10.0]])
    assert ways(cut_off(sides_of_a_block(), runs_on)) == [(1, 0, 0)]
    just = np.array([[-30.0, -20.0, -10.0], [40.0, 20.0, 10.0]])
    assert cut_off(sides_of_a_block(), just) == []
