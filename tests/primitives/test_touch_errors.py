"""What touches err by together, told by their disagreement, and the fits that heed it."""

from dataclasses import dataclass, replace

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
        sigma.extend(distance_sigma(found, at))
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
    sigma = np.concatenate([distance_sigma(f, ring) for f in fits])
    assert 0.6 < np.sqrt(np.mean((off / sigma) ** 2)) < 1.4
    plain = np.concatenate([f.fit.shape.signed_distance(ring) for f in faces])
    assert np.mean(off**2) < 0.5 * np.mean(plain**2)


@pytest.mark.parametrize("angle", [0.1, 0.01, 1.5e-3])
def test_cones_that_are_nearly_cylinders_are_known_as_well(angle):
    rng = np.random.default_rng(7)
    cone = Cone([0, 0, 15.0 / np.tan(angle)], [0, 0, -1], angle)
    turn, high = rng.uniform(0, 2 * np.pi, 120), rng.uniform(-10, 10, 120)
    on = cone.project(np.column_stack([15 * np.cos(turn), 15 * np.sin(turn), high]))
    normals = cone.normals(on)
    touch = np.repeat(np.arange(30), 4)
    contacts = Contacts.of(
        on + 0.01 * rng.standard_normal((120, 1)) * normals, normals, 0.01, 0.01, touch=touch
    )
    found = Face(fit("cone", contacts), contacts)
    again = fits_of_touches([found, *(plate(rng, 4) for _ in range(6))])[0]
    ring = cone.project(np.array([[15.0, 0.0, 0.0], [0.0, 15.0, 5.0], [-15.0, 0.0, -5.0]]))
    assert np.abs(again.shape.signed_distance(ring)).max() < 0.02
    assert distance_sigma(again, ring).max() < 4 * distance_sigma(found.fit, ring).max()


def test_what_a_fit_knows_beside_its_contacts_it_keeps_and_no_other_suffers():
    rng = np.random.default_rng(8)
    turn = np.arange(0, 2 * np.pi, np.pi / 4)
    ring = np.column_stack([10 * np.cos(turn), 10 * np.sin(turn), np.zeros(8)])
    felt = Contacts.of(ring + 0.005 * rng.standard_normal((8, 3)), sigma=0.01, touch=0)
    up = np.array([0.0, 0.0, 30.0])
    drawn = fit(
        "cylinder", Contacts.of(np.concatenate([felt.points, felt.points + up, felt.points - up]), sigma=0.01)
    )
    assert isinstance(drawn, Fit)
    hole = Face(replace(drawn, inliers=np.ones(8, dtype=bool)), felt)
    plates = [plate(rng, 5, 0.05, 0.02) for _ in range(6)]
    alone, beside = touch_errors(plates), touch_errors([hole, *plates])
    assert beside.reading == pytest.approx(alone.reading, rel=0.1)
    assert beside.touch == pytest.approx(alone.touch, rel=0.3)
    again = fits_of_touches([hole, *plates])[0]
    assert abs(again.shape.axis @ drawn.shape.axis) > np.cos(np.radians(0.05))
    assert (np.linalg.eigvalsh(again.covariance) > 0).all()


@pytest.mark.parametrize("stage", [0.0, 0.05])
def test_a_low_ring_that_was_drawn_out_stays_upright(stage):
    rng = np.random.default_rng(10)
    tilts = []
    for _ in range(12):
        turn, high = rng.uniform(0, 2 * np.pi, 8), rng.uniform(-1, 1, 8)
        out = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(8)])
        off = rng.normal(0, np.hypot(0.01, stage), (8, 1))
        points = (10.0 + off) * out + high[:, None] * [0.0, 0.0, 1.0]
        leaning = out + rng.normal(0, 0.03, (8, 3))
        leaning /= np.linalg.norm(leaning, axis=1, keepdims=True)
        felt = Contacts.of(points, leaning, 0.01, 0.03, touch=np.repeat(np.arange(4), 2))
        sigma = np.full(24, np.hypot(0.01, stage))
        lots = [felt.points + step * np.array([0.0, 0.0, 1.0]) for step in (0.0, 15.0, -15.0)]
        drawn = Contacts.of(np.concatenate(lots), np.tile(leaning, (3, 1)), sigma, 0.03)
        made = fit("cylinder", drawn)
        assert isinstance(made, Fit)
        face = Face(replace(made, inliers=np.ones(8, dtype=bool)), felt)
        found = fits_of_touches([face, *(plate(rng, 4, stage) for _ in range(4))])[0]
        tilts.append(np.arccos(min(1.0, abs(found.shape.axis @ made.shape.axis))))
    assert np.degrees(np.mean(tilts)) < 0.15


def test_normals_that_lean_alike_in_a_touch_count_as_one():
    rng = np.random.default_rng(9)
    leans = []
    for _ in range(60):
        at = rng.uniform(-3, 3, (40, 2))
        lean = rng.normal(0, 0.004, 2)
        n = np.column_stack([np.tile(lean, (40, 1)) + rng.normal(0, 0.001, (40, 2)), np.ones(40)])
        n /= np.linalg.norm(n, axis=1, keepdims=True)
        contacts = Contacts.of(np.column_stack([at, rng.normal(0, 0.05, 40)]), n, 0.05, 0.006, touch=0)
        face = Face(fit("plane", contacts), contacts)
        found = fits_of_touches([face])[0]
        turned = np.arccos(min(1.0, abs(found.shape.normal[2])))
        leans.append(turned / np.sqrt(np.trace(found.covariance[1:, 1:])))
    assert 0.5 < np.sqrt(np.mean(np.square(leans))) < 1.3


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


def test_what_was_inferred_of_a_felt_face_moves_it_nowhere_and_makes_it_neither_surer_nor_less_sure():
    """It says how far the face goes: of one felt in one touch, 200 of these told of 0.95 mm for 0.04."""
    rng = np.random.default_rng(9)
    for touches in (1, 4):
        face = plate(rng, touches, 0.03, most=3)
        aside = face.contacts.points[rng.integers(0, len(face.contacts), 200)] + [0.0, 0.0, 0.08]
        more = Contacts.of(aside, np.tile([0.0, 0.0, 1.0], (200, 1)), 0.1, 0.02, touch=NOT_FELT)
        both = Face(face.fit, Contacts.concatenate([face.contacts, more]))
        (alone,), (found,) = fits_of_touches([face]), fits_of_touches([both])
        assert np.allclose(found.covariance, alone.covariance)
        assert np.allclose(found.shape.origin, alone.shape.origin)
        assert np.allclose(found.shape.direction, alone.shape.direction)


def test_no_faces_have_no_fits():
    assert fits_of_touches([]) == []


def test_a_hole_that_was_seen_from_its_ends_lies_as_far_off_as_it_says():
    rng, reading, touch = np.random.default_rng(12), 0.05, 0.02
    turn = np.arange(0, 2 * np.pi, np.pi / 8)
    out = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(16)])
    plates = [plate(rng, 5, reading, touch) for _ in range(6)]
    holes = []
    for _ in range(40):
        ends = [
            5.0 * out
            + rng.normal(0, 0.01, (16, 3))
            + rng.normal(0, np.hypot(reading, touch), 3) * [1, 1, 0]
            + high
            for high in ([0.0, 0.0, 0.0], [0.0, 0.0, 20.0])
        ]
        seen = Contacts.of(np.concatenate(ends), np.tile(out, (2, 1)), 0.02, 0.05, touch=NOT_FELT)
        holes.append(Face(fit("cylinder", seen), seen))
    found = fits_of_touches([*holes, *plates])[: len(holes)]
    axis = np.array([f.shape.anchor - f.shape.direction * (f.shape.anchor[2] - 10.0) for f in found])[:, :2]
    sigma = np.array([np.sqrt(f.covariance[0, 0]) for f in found])
    assert 0.6 < np.sqrt(np.mean((axis / sigma[:, None]) ** 2)) < 1.4
    plain = np.array([np.sqrt(with_shared_error(h.fit, h.contacts).covariance[0, 0]) for h in holes])
    assert np.sqrt(np.mean((axis / plain[:, None]) ** 2)) > 2.0


def test_a_wall_drawn_between_two_rims_leans_as_far_as_it_says():
    rng, reading, touch = np.random.default_rng(13), 0.05, 0.02
    plates = [plate(rng, 5, reading, touch) for _ in range(6)]
    along, walls = np.linspace(-20.0, 20.0, 9), []
    for _ in range(40):
        rims = [
            np.column_stack([np.full(9, rng.normal(0, np.hypot(reading, touch))), along, np.full(9, high)])
            for high in (0.0, 10.0)
        ]
        points = np.concatenate(rims) + rng.normal(0, 0.01, (18, 3)) * [1, 0, 0]
        seen = Contacts.of(points, sigma=0.08, touch=NOT_FELT)
        walls.append(Face(fit("plane", seen), seen))
    found = fits_of_touches([*walls, *plates])[: len(walls)]
    up = np.array([0.0, 0.0, 1.0])
    lean = np.array([f.shape.normal @ up for f in found])
    tilts = [
        (f.shape.frame[:, :2].T @ up) @ f.covariance[1:, 1:] @ (f.shape.frame[:, :2].T @ up) for f in found
    ]
    assert 0.6 < np.sqrt(np.mean(lean**2 / np.array(tilts))) < 1.4
