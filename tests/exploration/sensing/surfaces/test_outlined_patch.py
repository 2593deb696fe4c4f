"""The plane of a face whose outline is known from its own picture alone."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.sensing.surfaces.outlined_patch import outlined_patch
from primitives.pose import pose, random_rotation, rotate, transform_points


@pytest.fixture
def sharp(frames):
    """Of a rubber that spreads less than the others' do."""
    return type(frames)(spread=1.2)


def notched_ring(radius, wide, turn, shift):
    """1 on a ring [mm] whose outer circle has a notch every 15 mm, as deep as half the ring is wide."""

    def there(x, y):
        x, y = x - shift[0], y - shift[1]
        away, round_it = np.hypot(x, y), np.arctan2(y, x) * radius + turn
        across = np.clip((0.5 * wide - np.abs(away - radius)) / 0.225 + 0.5, 0.0, 1.0)
        notch = np.clip((2.5 - np.abs((round_it + 7.5) % 15.0 - 7.5)) / 0.225 + 0.5, 0.0, 1.0)
        return across * (1.0 - notch * (away > radius))

    return there


def pressed(sharp, rng):
    """A ring's field, its depth at the pad's middle and its slope."""
    slope = rng.uniform(-0.01, 0.01, 2)
    there, plane = (
        notched_ring(40.0, 8.0, rng.uniform(0.0, 15.0), (0.0, -40.0)),
        sharp.plane(0.5, tuple(slope)),
    )
    return lambda x, y: there(x, y) * plane(x, y), 0.5, slope


def test_a_notched_ring_tells_its_plane_to_within_what_is_stated(sharp):
    rng = np.random.default_rng(0)
    off, turn, told = [], [], 0
    for _ in range(60):
        field, depth, slope = pressed(sharp, rng)
        found = outlined_patch(sharp(field, rng))
        if found is None:
            continue
        told += 1
        away = found.plane - np.array([depth, *slope])
        sigma = np.sqrt(np.diag(found.covariance))
        off.append(away[0] / np.hypot(sigma[0], 0.015))
        turn.extend(away[1:] / np.hypot(sigma[1:], 0.006))
    assert told > 40
    assert np.sqrt(np.mean(np.square(off))) < 1.5
    assert np.sqrt(np.mean(np.square(turn))) < 1.5


def test_its_contacts_lie_on_that_plane_and_know_it_as_well(sharp):
    rng = np.random.default_rng(1)
    at = pose(random_rotation(rng), [10.0, -20.0, 30.0])
    field, _, _ = pressed(sharp, rng)
    found = outlined_patch(sharp(field, rng))
    contacts = found.contacts(at, 3, 4, 1)
    back = transform_points(np.linalg.inv(at), contacts.points)
    assert np.allclose(-back[:, 2], found.plane[0] + back[:, :2] @ found.plane[1:])
    out = -np.append(found.plane[1:], 1.0)
    assert np.allclose(contacts.normals, rotate(at, out / np.linalg.norm(out)))
    rows = np.column_stack([np.ones(4), back[:, :2]]) / contacts.sigma[:, None]
    assert np.allclose(np.linalg.inv(rows.T @ rows), found.covariance, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("radius", [12.0, 25.0, 40.0])
def test_a_ball_has_no_flat_face(sharp, radius):
    rng = np.random.default_rng(2)
    found = [
        outlined_patch(sharp(sharp.sphere(radius, *rng.uniform(-3.0, 3.0, 2), 0.8), rng)) for _ in range(20)
    ]
    assert sum(each is not None for each in found) <= 1


def test_two_faces_that_meet_under_the_pad_are_not_one(sharp):
    rng = np.random.default_rng(3)

    def ridge(x, y):
        return np.maximum(0.0, 0.7 - 0.12 * np.abs(x - 1.0))

    assert all(outlined_patch(sharp(ridge, rng)) is None for _ in range(20))


def test_a_thin_line_a_lone_taxel_and_a_dead_pad_tell_nothing(sharp):
    rng = np.random.default_rng(4)
    line = sharp(lambda x, y: 0.5 * (np.abs(y) < 1.0), rng)
    whole = sharp(sharp.plane(), rng)
    dead = replace(whole, sigma=np.full(whole.depth.shape, np.inf))
    alone = sharp(lambda x, y: 0.5 * (np.hypot(x, y) < 1.5), rng)
    assert [outlined_patch(image) for image in (line, alone, dead)] == [None, None, None]


@pytest.mark.parametrize("count", [2, 8])
def test_dead_taxels_are_no_holes_in_the_face(sharp, count):
    rng = np.random.default_rng(5)
    off, told = [], 0
    for _ in range(30):
        field, depth, _ = pressed(sharp, rng)
        image = sharp(field, rng)
        dead = np.zeros(image.depth.size, dtype=bool)
        dead[rng.choice(dead.size, count, replace=False)] = True
        dead = dead.reshape(image.depth.shape)
        found = outlined_patch(
            replace(
                image, depth=np.where(dead, np.nan, image.depth), sigma=np.where(dead, np.inf, image.sigma)
            )
        )
        told += found is not None
        off += [] if found is None else [found.plane[0] - depth]
    assert told > 24
    assert np.sqrt(np.mean(np.square(off))) < 0.02
