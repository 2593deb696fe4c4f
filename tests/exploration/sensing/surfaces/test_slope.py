from dataclasses import replace

import numpy as np
import pytest

from exploration.sensing.surfaces.slope import contact_slope


def test_slope_and_force_of_a_tilted_face(frames):
    image = frames(frames.plane(0.5, (0.012, -0.006)), np.random.default_rng(0))
    slope = contact_slope(image)
    assert slope.gradient == pytest.approx([0.012, -0.006], abs=4 * slope.gradient_sigma.max())
    assert slope.force == pytest.approx(0.1 * 0.5 * 28.8 * 18.0, rel=0.01)
    assert slope.area == pytest.approx(28.8 * 18.0)
    assert slope.centroid == pytest.approx([0.0, 0.0], abs=1e-9)


def test_half_over_an_edge_the_slope_is_the_faces_own(frames):
    rng = np.random.default_rng(1)
    z = []
    for _ in range(60):
        angle = rng.uniform(0, np.pi)
        slope = contact_slope(frames(frames.edge(angle, -2.0, slope=(0.004, 0.004)), rng))
        z.append((slope.gradient - 0.004) / slope.gradient_sigma)
    assert np.sqrt(np.mean(np.square(z))) < 1.6


def test_a_thin_contact_says_that_it_does_not_know(frames):
    slope = contact_slope(frames(lambda x, y: 0.5 * (np.abs(x) < 1.0), np.random.default_rng(2)))
    assert slope
    assert slope.gradient_sigma[0] == np.inf


def test_nothing_is_false(frames):
    image = frames(frames.plane(0.0), np.random.default_rng(3))
    assert not contact_slope(image)
    assert not contact_slope(replace(image, depth=np.full_like(image.depth, np.nan)))
