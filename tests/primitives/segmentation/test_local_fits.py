"""Normals from positions alone."""

import numpy as np

from primitives.segmentation.local_fits import local_normals


def corner(count, rng, sigma):
    """Three faces of a cube of 40 mm that meet in a corner, and their normals."""
    axis = rng.integers(3, size=count)
    points = rng.uniform(0, 40, (count, 3))
    points[np.arange(count), axis] = sigma * rng.standard_normal(count)
    return points, np.eye(3)[axis]


def off(found, true):
    return np.arccos(np.clip(np.abs((found * true).sum(axis=1)), 0, 1))


def test_beside_an_edge_the_side_that_a_contact_lies_on_gives_its_normal():
    points, true = corner(600, np.random.default_rng(0), 1e-3)
    found, _ = local_normals(points, np.arange(600), 1e-3)
    assert np.mean(off(found, true) < 0.01) > 0.95


def test_a_normal_is_as_sure_as_it_says_away_from_edges():
    rng = np.random.default_rng(1)
    points, true = corner(900, rng, 0.3)
    found, sigma = local_normals(points, np.arange(900), 0.3)
    inner = np.sort(points, axis=1)[:, 1] > 8.0
    assert 0.5 < np.median(off(found, true)[inner] / sigma[inner]) < 2.0


def test_a_bent_piece_follows_a_sphere_where_a_flat_one_cannot():
    rng = np.random.default_rng(2)
    true = rng.standard_normal((800, 3))
    true /= np.linalg.norm(true, axis=1, keepdims=True)
    found, _ = local_normals(20.0 * true, np.arange(800), 5e-3)
    assert np.median(off(found, true)) < 0.01
