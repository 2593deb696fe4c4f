"""What was read twice at one place is one contact."""

import numpy as np

from primitives.evidence import Contacts
from recognition.sources.places import one_a_place, written_once

SPOTS = np.random.default_rng(0).uniform(-40.0, 40.0, (200, 3))


def test_only_what_repeats_another_to_the_last_digit_is_passed_over():
    points = np.array([[1.0, 2, 3], [1.0, 2, 3], [1.0, 2, 3], [-0.0, 2, 3], [0.0, 2, 3]])
    normals = np.array([[0, 0, 1.0], [0, 0, -1.0], [0, 0, 1.0], [np.nan] * 3, [np.nan] * 3])
    assert written_once(Contacts.of(points, normals, 0.1)).tolist() == [0, 1, 3]
    assert written_once(Contacts.of(points[:3], normals[:3], [0.1, 0.1, 0.2])).tolist() == [0, 1, 2]


def test_readings_that_shake_at_a_place_become_its_middle():
    rng = np.random.default_rng(1)
    read = np.repeat(SPOTS, 25, axis=0) + 0.002 * rng.standard_normal((5000, 3))
    normals = np.tile([0.0, 0.0, 1.0], (5000, 1)) + 0.01 * rng.standard_normal((5000, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    order = rng.permutation(5000)
    placed = one_a_place(Contacts.of(read[order], normals[order], 0.1, touch=np.arange(5000)))
    assert len(placed) == len(SPOTS)
    nearest = np.linalg.norm(placed.points[:, None] - SPOTS, axis=2).min(axis=1)
    assert nearest.max() < 0.002
    assert np.linalg.norm(placed.normals, axis=1).max() < 1.0 + 1e-9
    assert (np.diff(placed.touch) > 0).all()


def test_both_sides_of_a_foil_and_contacts_without_a_normal_stay_as_they_are():
    up = np.tile([0.0, 0.0, 1.0], (200, 1))
    flat = SPOTS * [1.0, 1.0, 0.0]
    foil = Contacts.of(np.concatenate([flat, flat - 0.01 * up]), np.concatenate([up, -up]))
    assert one_a_place(foil) is foil
    bare = Contacts.of(SPOTS)
    assert one_a_place(bare) is bare
    assert len(one_a_place(Contacts.of(np.zeros((50, 3))))) == 1
    assert len(one_a_place(Contacts.of(np.empty((0, 3))))) == 0


def test_a_stroke_that_is_read_ever_so_often_is_thinned_and_not_one_place():
    along = np.column_stack([np.linspace(0.0, 100.0, 20_000), np.zeros((20_000, 2))])
    kept = one_a_place(Contacts.of(np.concatenate([along, SPOTS])))
    on = np.sort(kept.points[np.abs(kept.points[:, 1:]).max(axis=1) == 0.0, 0])
    assert len(on) > 3000
    assert np.diff(on).max() < 0.05
