"""Contacts over all of a surface speak for a small object; close together once; of one flat face not at all."""

import numpy as np

from recognition.matching.places import places_of

SMALL, LARGE = 5_000.0, 20_000.0


def _favor(points, anywhere=True):
    """How much likelier the places are on the smaller surface, in nats."""
    places, each = places_of(points, anywhere), np.ones(len(points))
    return places.log_density(SMALL, each) - places.log_density(LARGE, each)


def _square(half, many):
    rng = np.random.default_rng(0)
    return np.column_stack([rng.uniform(-half, half, (many, 2)), np.zeros(many)])


def test_many_contacts_on_one_face_say_little_of_how_large_the_rest_is():
    assert 0.0 <= _favor(_square(15, 60)) < 5.0  # of 83 if each spoke


def test_contacts_of_one_flat_face_speak_with_the_first_of_them_only():
    face = _square(25, 50)  # half of the smaller surface
    assert np.isclose(_favor(face, anywhere=False), np.log(LARGE / SMALL))
    assert _favor(face) > 5.0


def test_contacts_all_round_a_small_ball_speak_for_it():
    rng = np.random.default_rng(1)
    way = rng.normal(size=(40, 3))
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    ball = np.sqrt(SMALL / 4 / np.pi) * way
    assert _favor(ball) > 0.5
    assert _favor(ball) > 0.5 * _favor(ball[:10])


def test_one_contact_is_drawn_from_the_whole_surface():
    assert np.isclose(_favor(np.zeros((1, 3))), np.log(LARGE / SMALL))


def test_a_density_integrates_to_one_on_a_plane():
    rng = np.random.default_rng(2)
    before = np.column_stack([rng.normal(0, 10, (8, 2)), np.zeros(8)])
    x = np.linspace(-90, 90, 61)
    grid = np.stack(np.meshgrid(x, x), axis=-1).reshape(-1, 2)
    local = [places_of(np.vstack([before, [*p, 0.0]])).local[-1] for p in grid]
    assert abs(np.sum(local) * (x[1] - x[0]) ** 2 - 1.0) < 0.1
