import numpy as np
import pytest

from primitives.evidence import Contacts
from recognition.reconstructing.scatter import scatter
from recognition.sources.noise import estimated_sigma

SIZE = np.array([60.0, 40.0, 12.0])


def on_a_block(count, sigma, rng, normals=True):
    area = np.repeat([SIZE[1] * SIZE[2], SIZE[0] * SIZE[2], SIZE[0] * SIZE[1]], 2)
    face = rng.choice(6, count, p=area / area.sum())
    points, out = (rng.random((count, 3)) - 0.5) * SIZE, np.zeros((count, 3))
    out[np.arange(count), face // 2] = 2.0 * (face % 2) - 1
    points = np.where(out != 0, 0.5 * out * SIZE, points) + sigma * rng.standard_normal((count, 3))
    return Contacts.of(points, out if normals else None, 0.1, 0.05)


def test_sixty_contacts_scatter_as_their_faces_say_where_neighbors_mislead():
    contacts = on_a_block(60, 0.2, np.random.default_rng(0))
    assert estimated_sigma(contacts) > 1.0
    assert scatter(contacts) == pytest.approx(0.2, rel=0.4)


@pytest.mark.parametrize("sigma", [0.002, 0.05])
def test_many_contacts_on_bends_scatter_as_their_faces_say_where_neighbors_mislead(sigma):
    rng, count = np.random.default_rng(1), 2000
    turn, height = rng.uniform(0.0, 2 * np.pi, count), rng.uniform(0.0, 40.0, count)
    outward = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])
    rods = [(np.array([40.0 * k, 0.0, 0.0]), radius) for k, radius in enumerate((3.0, 6.0, 9.0))]
    points = np.concatenate(
        [middle + radius * outward + height[:, None] * np.eye(3)[2] for middle, radius in rods]
    )
    normals = np.tile(outward, (3, 1))
    points += sigma * rng.standard_normal(points.shape)
    contacts = Contacts.of(points, normals, 0.1, 0.05)
    assert estimated_sigma(contacts) > 1.1 * sigma
    assert scatter(contacts) == pytest.approx(sigma, rel=0.15)


@pytest.mark.parametrize("normals", [True, False])
def test_exact_contacts_on_faces_along_the_axes_have_a_sigma(normals):
    contacts = on_a_block(1500, 0.0, np.random.default_rng(3), normals)
    assert 0.0 < scatter(contacts) < 1e-3 * np.linalg.norm(SIZE)
    rounded = Contacts.of(np.round(contacts.points, 2), contacts.normals if normals else None, 0.1, 0.05)
    assert 0.0 < scatter(rounded) < 0.02


@pytest.mark.long
@pytest.mark.parametrize("shake", [0.0, 0.002])
@pytest.mark.parametrize("normals", [True, False])
def test_places_that_are_read_ten_times_over_scatter_as_if_read_once(shake, normals):
    rng = np.random.default_rng(4)
    once = on_a_block(200, 0.05, rng, normals)
    again = once.select(np.repeat(np.arange(200), 10))
    points = again.points + shake * rng.standard_normal((2000, 3))
    read = Contacts.of(points, again.normals if normals else None, 0.1, 0.05)
    assert estimated_sigma(read) == pytest.approx(estimated_sigma(once), rel=0.05)
    assert scatter(read) == pytest.approx(scatter(once), rel=0.2)


def test_a_handful_and_contacts_at_one_place_have_a_sigma():
    assert scatter(on_a_block(5, 0.05, np.random.default_rng(2))) > 0.0
    assert scatter(Contacts.of(np.zeros((50, 3)))) > 0.0
