import numpy as np
import pytest

from primitives.evidence import Contacts
from primitives.segmentation.scatter import likeliest_sigma


def on_a_cube(n, sigma, turn, rng):
    axis, side = rng.integers(3, size=n), rng.choice([-1.0, 1.0], n)
    normals = np.zeros((n, 3))
    normals[np.arange(n), axis] = side
    points = np.where(normals != 0, 30 * normals, rng.uniform(-30, 30, (n, 3)))
    felt = normals + turn * rng.standard_normal((n, 3))
    felt /= np.linalg.norm(felt, axis=1, keepdims=True)
    return Contacts.of(points + sigma * rng.standard_normal((n, 3)), felt, 0.1, 0.05)


@pytest.mark.parametrize("count", [40, 150])
@pytest.mark.parametrize("sigma", [0.02, 0.3])
def test_the_sigma_that_makes_the_faces_likeliest_is_the_one_that_contacts_have(count, sigma):
    contacts = on_a_cube(count, sigma, 0.05, np.random.default_rng(count))
    assert likeliest_sigma(contacts, 1.0) == pytest.approx(sigma, rel=0.3)


def test_no_sigma_above_the_largest_is_said():
    contacts = on_a_cube(40, 0.3, 0.05, np.random.default_rng(0))
    assert likeliest_sigma(contacts, 0.1) <= 0.1
