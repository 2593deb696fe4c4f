import numpy as np

from primitives.evidence import Contacts
from primitives.segment import segment


def noisy(points, normals, rng, sigma=0.1, turn=0.05):
    points = points + sigma * normals * rng.standard_normal((len(points), 1))
    normals = normals + turn * rng.standard_normal(normals.shape)
    return Contacts.of(points, normals / np.linalg.norm(normals, axis=1, keepdims=True), sigma, turn)


def cube(n, rng):
    axis, side = rng.integers(3, size=n), rng.choice([-1.0, 1.0], n)
    normals = np.zeros((n, 3))
    normals[np.arange(n), axis] = side
    points = np.where(normals != 0, 20 * normals, rng.uniform(-20, 20, (n, 3)))
    return noisy(points, normals, rng), 2 * axis + (side > 0)


def rod(n, rng):
    face = np.maximum(rng.integers(4, size=n) - 1, 0)
    phi, r = rng.uniform(0, 2 * np.pi, n), np.where(face == 0, 15.0, 15 * np.sqrt(rng.uniform(size=n)))
    z = np.select([face == 0, face == 1], [rng.uniform(-20, 20, n), 20.0], -20.0)
    up = np.select([face == 0, face == 1], [0.0, 1.0], -1.0)
    out = (face == 0).astype(float)
    points = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)
    return noisy(points, np.stack([out * np.cos(phi), out * np.sin(phi), up], axis=1), rng), face


def purity(patches, labels):
    return sum(np.bincount(labels[p.rows]).max() for p in patches) / len(labels)


def test_a_cube_is_six_patches():
    contacts, labels = cube(120, np.random.default_rng(0))
    patches = segment(contacts)
    assert len(patches) == 6
    assert purity(patches, labels) > 0.95


def test_a_rod_is_a_wall_and_two_caps():
    contacts, labels = rod(120, np.random.default_rng(1))
    patches = segment(contacts)
    assert len(patches) == 3
    assert purity(patches, labels) > 0.95


def test_patches_share_no_contact_and_say_where_theirs_came_from():
    contacts, _ = cube(80, np.random.default_rng(2))
    patches = segment(contacts)
    rows = np.concatenate([p.rows for p in patches])
    assert len(rows) == len(set(rows.tolist()))
    assert all(np.median(np.abs(p.fit.shape.signed_distance(contacts.points[p.rows]))) < 0.2 for p in patches)


def test_nothing_comes_of_nothing():
    assert segment(Contacts.of(np.empty((0, 3)))) == ()
    assert segment(Contacts.of([[0, 0, 0.0], [1, 0, 0]])) == ()


def test_exact_contacts_on_a_ring_are_one_torus():
    rng = np.random.default_rng(3)
    turn, round_ = rng.uniform(0, 2 * np.pi, (2, 300))
    out = np.stack([np.cos(turn), np.sin(turn), np.zeros(300)], axis=1)
    normals = np.cos(round_)[:, None] * out + np.sin(round_)[:, None] * np.array([0, 0, 1.0])
    found = segment(Contacts.of(20.0 * out + 6.0 * normals, normals, 1e-3, 1e-3))
    assert [one.fit.kind for one in found] == ["torus"]
    assert len(found[0].rows) == 300


def test_six_contacts_on_a_small_face_are_one_among_a_thousand_on_large_ones():
    contacts, _ = cube(1000, np.random.default_rng(4))
    turn = np.arange(6) * 1.1
    floor = np.stack([4 * np.cos(turn), 4 * np.sin(turn), np.full(6, 11.0)], axis=1)
    up = np.tile([0.0, 0.0, 1.0], (6, 1))
    few = noisy(floor, up, np.random.default_rng(5), sigma=0.3)
    table = Contacts.of(
        np.concatenate([contacts.points, few.points]),
        np.concatenate([contacts.normals, few.normals]),
        0.3,
        0.05,
    )
    found = segment(table)
    assert len(found) == 7
    assert set(found[-1].rows.tolist()) == set(range(1000, 1006))
