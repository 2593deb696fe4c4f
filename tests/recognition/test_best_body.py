"""The best body that a few faces allow."""

import numpy as np
import pytest

from primitives.evidence import Contacts
from primitives.fit import Fit, fit
from recognition.assembly import NotClosed
from recognition.best_body import Body as Best
from recognition.best_body import FeltFace, _less_poor, best_body

BOX = np.array([[-300.0] * 3, [300.0] * 3])
TURN = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)


def round_face(radius, heights, turns=TURN):
    """The side of a cylinder about z, felt at heights."""
    out = np.column_stack([np.cos(turns), np.sin(turns), np.zeros(len(turns))])
    points = np.concatenate([radius * out + [0.0, 0.0, z] for z in heights])
    felt = Contacts.of(points, np.tile(out, (len(heights), 1)), 0.02, 0.01)
    found = fit("cylinder", felt)
    assert isinstance(found, Fit)
    return FeltFace(found, felt)


def flat_face(points, normal):
    felt = Contacts.of(points, np.tile(normal, (len(points), 1)), 0.06, 0.1)
    found = fit("plane", felt)
    assert isinstance(found, Fit)
    return FeltFace(found, felt)


def test_a_body_that_reaches_far_past_all_that_was_felt_is_none():
    """As a ring of wire, felt at one place, passes for a drum of a hundred millimeters."""
    seen = round_face(100.0, np.arange(0.0, 12.0, 2.0), np.linspace(-0.05, 0.05, 4))
    body = best_body([seen], BOX, None, 15.0)
    assert isinstance(body.assembly, NotClosed)
    assert "far past all that was felt" in body.assembly.reason
    bar = round_face(10.0, np.arange(0.0, 60.0, 5.0))
    assert not isinstance(best_body([bar], BOX, None, 15.0).assembly, NotClosed)


@pytest.mark.parametrize(("count", "kept"), [(5, False), (12, True)])
def test_flat_faces_of_few_contacts_are_left_out_of_a_bar_that_they_leave_open(count, kept):
    bar = round_face(1.5, np.arange(0.0, 60.0, 5.0))
    along = np.column_stack(
        [np.full(count, 1.4), np.tile([-0.3, 0.3], count)[:count], np.linspace(5, 50, count)]
    )
    flat = flat_face(along, [1.0, 0.0, 0.0])

    def make(faces):
        if any(face is flat for face in faces):
            return NotClosed("they contradict each other")
        return best_body(faces, BOX, None, 15.0).assembly

    first = Best(NotClosed("they contradict each other"), (bar, flat))
    found = _less_poor(first, make, 15.0)
    assert isinstance(found.assembly, NotClosed) == kept
    if not kept:
        assert found.left_out == (flat,)
        assert any("left out" in line for line in found.told())
