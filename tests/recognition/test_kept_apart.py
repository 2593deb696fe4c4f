"""What contacts kept apart tell of a smooth surface through the others."""

import numpy as np
import pytest

from primitives.evidence import Contacts
from recognition.kept_apart import kept_apart

SIGMA = 0.03


def bumpy(high, count=240, seed=0):
    """Contacts, six of each touch, on a ball of 30 mm with bumps so many mm high and some 10 mm apart."""
    ways = np.random.default_rng(seed).normal(size=(count, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    x, y, z = 9.0 * ways.T
    radius = 30.0 + high * np.sin(x) * np.sin(y) * np.sin(z)
    slope = (
        9.0
        * high
        * np.column_stack(
            [
                np.cos(x) * np.sin(y) * np.sin(z),
                np.sin(x) * np.cos(y) * np.sin(z),
                np.sin(x) * np.sin(y) * np.cos(z),
            ]
        )
    )
    slope -= (slope * ways).sum(axis=1, keepdims=True) * ways
    normals = ways - slope / radius[:, None]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Contacts.of(radius[:, None] * ways, normals, SIGMA, 0.02, touch=np.arange(count) // 6)


@pytest.mark.parametrize(("away", "taken"), [(0.15, False), (0.5, False), (1.2, True), (np.inf, False)])
def test_a_rough_surface_is_taken_only_where_a_body_is_far_worse(away, taken):
    """Between its contacts it is off by more than at them: what has edges would be, too."""
    assert (kept_apart(away, 0.01, bumpy(2.0), False) is not None) is taken


def test_a_smooth_one_is_taken_where_no_faces_make_a_body():
    assert kept_apart(np.inf, 0.01, bumpy(0.0), False) is not None
