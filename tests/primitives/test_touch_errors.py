"""What touches err by together, told by their disagreement, and the fits that heed it."""

from dataclasses import dataclass

import numpy as np
import pytest

from primitives.cone import Cone
from primitives.cylinder import Cylinder
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import Fit, fit
from primitives.shared_error import with_shared_error
from primitives.surface_sigma import distance_sigma
from primitives.touch_errors import fits_of_touches, touch_errors

FOOT = np.array([[6.0, 0.0], [-6.0, 0.0], [0.0, 6.0], [0.0, -6.0]])  # [mm] where a flat frame yields contacts


@dataclass
class Face:
    """A fit and its contacts."""

    fit: Fit
    contacts: Contacts


def plate(rng, touches, reading=0.0, touch=0.0, turn=0.0, most=14):
    """Touches of the plane z = 0, each of a few readings, on a stage that errs."""
    points, normals, of = [], [], []
    for t in range(touches):
        middle, lift, lean = rng.uniform(-30, 30, 2), rng.normal(0, touch), rng.normal(0, turn, 2)
        for _ in range(rng.integers(1, most + 1)):
            at = middle + rng.uniform(-12, 12, 2) + FOOT
            off = lift + rng.normal(0, reading) + (at - middle) @ lean + rng.normal(0, 0.007, 4)
            points.append(np.column_stack([at, off]))
            normals.append(np.tile(np.append(rng.normal(0, 0.003, 2) - lean, 1.0), (4, 1)))
            of += [t] * 4
    n = np.concatenate(normals)
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    contacts = Contacts.of(np.concatenate(points), n, 0.01, 0.004, touch=np.array(of))
    return Face(fit("plane", contacts), contacts)


@pytest.mark.parametrize(("reading", "touch"), [(0.05, 0.02), (0.025, 0.05)])
def test_what_the_stage_errs_by_is_found(reading, touch):
    rng = np.random.default_rng(0)
    found = touch_errors([plate(rng, rng.integers(2, 7), reading, touch, 3e-4) for _ in range(12)])
    assert found.reading == pytest.approx(reading, rel=0.15)
    assert found.touch == pytest.approx(touch, rel=0.4)


def test_an_exact_stage_is_found_to_err_by_next_to_nothing():
    rng = np.random.default_rng(1)
    found = touch_errors([plate(rng, 4) for _ in range(8)])
    assert max(found.reading, found.touch) < 0.004
    assert found.turn < 3e-4


def heights(faces, fits):
    """(n,) how far planes lie off z = 0 over their contacts [mm], and their standard deviations there."""
    off, sigma = [], []
    for face, found in zip(faces, fits, strict=True):
        at = face.contacts.points[[0, len(face.contacts) // 2]]
        off.extend(found.shape.project(at)[:, 2])
        sigma.extend(distance_sigma(found, at) / np.sqrt(max(1.0, found.chi2 / found.dof)))
    return np.array(off), np.array(sigma)


def test_planes_lie_as_far_off_as_they_say():
    rng = np.random.default_rng(2)
    faces = [plate(rng, rng.integers(1, 6), 0.05, 0.02, 3e-4) for _ in range(60)]
    off, sigma = heights(faces, fits_of_touches(faces))
    assert 0.75 < np.sqrt(np.mean((off / sigma) ** 2)) < 1.3
    plain, said = heights(faces, [with_shared_error(f.fit, f.contacts) for f in faces])
    assert np.sqrt(np.mean((plain / said) ** 2)) > 1.5


def test_a_long_stroke_does_not_outvote_short_touches():
    rng = np.random.default_rng(3)
    faces = []
    for _ in range(40):
        long, short = plate(rng, 1, 0.0, 0.05, most=60), plate(rng, 5, 0.0, 0.05, most=1)
        contacts = Contacts.concatenate([long.contacts, short.contacts])
        touch = np.concatenate([long.contacts.touch, short.contacts.touch + 1])
        contacts = Contacts.of(contacts.points, contacts.normals, 0.01, 0.004, touch=touch)
        faces.append(Face(fit("plane", contacts), contacts))
    fair, _ = heights(faces, fits_of_touches(faces))
    plain, _ = heights(faces, [f.fit for f in faces])
    assert np.mean(fair**2) < 0.8 * np.mean(plain**2)


@pytest.mark.parametrize("shape", [Cylinder([0, 0, 0], [0, 0, 1], 15.0), Cone([0, 0, 60], [0, 0, -1], 0.3)])
def test_round_faces_move_to_where_their_touches_put_them(shape):
    rng = np.random.default_rng(4)
    faces = []
    for _ in range(10):
        points, normals, of = [], [], []
        for t in range(6):
            lift, at = rng.normal(0, 0.05, 3), rng.uniform(0, 2 * np.pi)
            for _ in range(rng.integers(1, 20)):
                turn, high = at + rng.normal(0, 0.2), rng.uniform(0, 30)
                on = shape.project(np.array([[20 * np.cos(turn), 20 * np.sin(turn), high]]))
                normals.append(shape.normals(on))
                points.append(on + lift + rng.normal(0, 0.01, 3))
                of.append(t)
        contacts = Contacts.of(
            np.concatenate(points), np.concatenate(normals), 0.01, 0.01, touch=np.array(of)
        )
        faces.append(Face(fit(shape.kind, contacts), contacts))
    ring = shape.project(20 * np.column_stack([np.cos(t := np.arange(0, 6, 0.5)), np.sin(t), np.ones(12)]))
    fits = fits_of_touches(faces)
    off = np.concatenate([f.shape.signed_distance(ring) for f in fits])
    sigma = np.concatenate([distance_sigma(f, ring) / np.sqrt(max(1.0, f.chi2 / f.dof)) for f in fits])
    assert 0.7 < np.sqrt(np.mean((off / sigma) ** 2)) < 1.4


def test_contacts_that_are_each_their_own_touch_say_nothing_of_touches():
    face = plate(np.random.default_rng(5), 1, 0.05)
    own = Contacts.of(
        face.contacts.points, face.contacts.normals, 0.01, 0.004, touch=np.arange(len(face.contacts))
    )
    alone = Face(fit("plane", own), own)
    (found,) = fits_of_touches([alone])
    assert np.allclose(found.covariance, with_shared_error(alone.fit, own).covariance)


def test_what_was_not_felt_stays_where_it_was_put():
    felt = plate(np.random.default_rng(6), 4, 0.02)
    told = Contacts.of(felt.contacts.points, felt.contacts.normals, 0.01, 0.004, touch=NOT_FELT)
    inferred = Face(fit("plane", told), told)
    found = fits_of_touches([felt, inferred])
    assert np.allclose(found[1].shape.origin, inferred.fit.shape.origin)
    assert not np.allclose(found[0].covariance, with_shared_error(felt.fit, felt.contacts).covariance)


def test_no_faces_have_no_fits():
    assert fits_of_touches([]) == []
