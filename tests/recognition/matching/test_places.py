"""Contacts spread over all of a surface speak for a small object, many close together speak once."""

import numpy as np

from recognition.matching.places import places_of

SMALL, LARGE = 5_000.0, 20_000.0


def _favor(points):
    """How much likelier the places are on the smaller surface, in nats."""
    places, each = places_of(points), np.ones(len(points))
    return places.log_density(SMALL, each) - places.log_density(LARGE, each)


def test_many_contacts_on_one_face_say_little_of_how_large_the_rest_is():
    rng = np.random.default_rng(0)
    face = np.column_stack([rng.uniform(-15, 15, (60, 2)), np.zeros(60)])
    assert 0.0 <= _favor(face) < 5.0  # of 83 if each spoke


def test_contacts_all_round_a_small_ball_speak_for_it():
    rng = np.random.default_rng(1)
    way = rng.normal(size=(40, 3))
    ball = np.sqrt(SMALL / 4 / np.pi) * way / np.linalg.norm(way, axis=1, keepdims=True)
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
