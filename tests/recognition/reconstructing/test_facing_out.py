from pathlib import Path

import numpy as np
import pytest

from primitives.evidence import Contacts
from recognition.reconstructing.facing_out import facing_out
from recognition.sources import Source


def on_a_ball(sign, kind="contacts"):
    out = np.random.default_rng(0).standard_normal((200, 3))
    out /= np.linalg.norm(out, axis=1, keepdims=True)
    return Source(Path("c.csv"), kind, "c", Contacts.of(20.0 * out, sign * out, 0.1, 0.05), True)


def test_normals_that_point_in_are_turned_and_that_is_told():
    turned = facing_out(on_a_ball(-1.0))
    assert turned.contacts.normals == pytest.approx(on_a_ball(1.0).contacts.normals)
    assert "turned round" in turned.warnings[0]


@pytest.mark.parametrize("source", [on_a_ball(1.0), on_a_ball(-1.0, "run")], ids=["outward", "of a run"])
def test_other_normals_are_left_as_they_are(source):
    assert facing_out(source) is source


def test_contacts_without_normals_are_left_as_they_are():
    bare = Source(Path("c.csv"), "contacts", "c", Contacts.of(np.eye(3), None, 0.1), True)
    assert facing_out(bare) is bare
