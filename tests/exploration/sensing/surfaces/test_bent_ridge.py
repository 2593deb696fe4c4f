"""What a pad on the crest of a ring feels, beside the ring itself."""

import numpy as np
import pytest

from exploration.sensing.contacts import contacts_of
from exploration.sensing.surfaces.bent_ridge import dome, fit_bent_ridge
from exploration.sensing.surfaces.flank import crest_of
from exploration.sensing.surfaces.local_surface import fit_surface
from exploration.sensing.touch import perceive
from primitives import pose as se3

RING, TUBE, DEPTH, ANGLE = 33.0, 6.6, 0.5, 0.4


def lying(depth=DEPTH, angle=ANGLE, middle=0.7):
    """Depth under a ring that lies flat, whose crest runs at an angle through a point beside the pad's center."""

    def field(x, y):
        u, w = np.cos(angle) * x + np.sin(angle) * y, np.cos(angle) * y - np.sin(angle) * x
        v = RING - np.hypot(u, RING - (w - middle))
        return np.maximum(0.0, depth - TUBE + np.sqrt(np.maximum(0.0, TUBE**2 - v**2)))

    return field


def aslant(ring_from_pad):
    """Depth under the ring z = 0 wherever the pad is: along its z axis, from 3 mm behind it."""

    def field(x, y):
        start = np.stack([x, y, np.zeros_like(x), np.ones_like(x)]).reshape(4, -1)
        point, way = (ring_from_pad @ start)[:3], ring_from_pad[:3, 2:3]
        height = np.full(point.shape[1], 3.0)
        for _ in range(60):
            at = point - height * way
            height -= np.hypot(np.hypot(at[0], at[1]) - RING, at[2]) - TUBE
        return np.maximum(0.0, height).reshape(x.shape)

    return field


def on_tube(around, rng):
    """(4, 4) of a pad on the tube, `around` [rad] from its crest, leaning and turned at random."""
    out = np.array([np.sin(around), 0.0, np.cos(around)])
    frame = se3.frame_along(-out + [*rng.normal(0.0, 0.03, 2), 0.0], rng.normal(size=3))
    pad = se3.pose(frame, RING * np.array([1.0, 0.0, 0.0]) + (TUBE - rng.uniform(0.3, 0.7)) * out)
    return pad @ se3.pose(translation=[*rng.uniform(-3.0, 3.0, 2), 0.0])


def test_a_clean_frame_tells_the_ring(make_frames):
    frame = make_frames(noise=0.001)(lying())
    ridge = fit_bent_ridge(frame, np.array([0.4, 0.0, 0.1, ANGLE + 0.1, 0.0, 0.0, 0.0]), fine=True)
    depth, slope, across, angle, along, middle, turn = ridge.parameters
    assert ridge.converged
    assert 1.0 / turn == pytest.approx(RING, rel=0.01)
    assert 1.0 / across == pytest.approx(TUBE, rel=0.02)
    assert angle == pytest.approx(ANGLE, abs=0.002)
    assert [depth, slope, along, middle] == pytest.approx([DEPTH, 0.0, 0.0, 0.7], abs=0.003)


def test_parameters_miss_by_what_is_stated(frames):
    rng, truth = np.random.default_rng(0), np.array([DEPTH, 0.0, 1 / TUBE, ANGLE, 0.0, 0.7, 1 / RING])
    start, field = truth * [0.9, 0.0, 0.8, 1.1, 0.0, 1.0, 0.0], lying()
    pulls = []
    for _ in range(60):
        ridge = fit_bent_ridge(frames(field, rng), start, fine=True)
        pulls.append((ridge.parameters - truth) / np.sqrt(np.diag(ridge.covariance)))
    assert np.std(pulls, axis=0) == pytest.approx(np.ones(7), abs=0.35)
    assert np.abs(np.mean(pulls, axis=0)).max() < 0.6


def test_the_dome_on_its_ridge_touches_it_in_second_order(make_frames):
    ridge = fit_bent_ridge(make_frames(noise=0.001)(lying()), np.array([0.4, 0.0, 0.1, 0.5, 0.0, 0.0, 0.0]))
    d0, gx, gy, kxx, kxy, kyy = dome(ridge, 8.0).parameters
    u, w = 8.0, RING + 0.7 - np.sqrt(RING**2 - 64.0)
    along, across = np.array([np.cos(ANGLE), np.sin(ANGLE)]), np.array([-np.sin(ANGLE), np.cos(ANGLE)])
    place = u * along + w * across
    bent = np.array([[kxx, kxy], [kxy, kyy]])
    assert d0 + np.array([gx, gy]) @ place - 0.5 * place @ bent @ place == pytest.approx(DEPTH, abs=0.01)
    assert np.array([gx, gy]) - bent @ place == pytest.approx([0.0, 0.0], abs=0.01)
    toward = (u * along - RING * across + (w - 0.7) * across) / RING  # from the ring's center
    assert toward @ bent @ toward == pytest.approx(ridge.parameters[2], rel=0.01)


def test_a_ridge_that_does_not_turn_is_no_rings_crest(frames):
    rng = np.random.default_rng(1)
    for radius in (6.6, 15.0, 40.0):
        for _ in range(20):
            field = frames.cylinder(radius, rng.uniform(0.0, np.pi), rng.uniform(-4.0, 4.0))
            image = frames(field, rng)
            assert crest_of(image, fit_surface(image)) is None
    image = frames(lying(), rng)
    assert crest_of(image, fit_surface(image)) is not None


@pytest.mark.parametrize("around", [0.2, 0.0, -0.2, -0.4])
def test_contacts_of_a_ring_lie_on_it_and_face_as_it_does(make_frames, around):
    """All round the tube, the inner side of the ring too, where its ridge bends away along itself."""
    frames, rng = make_frames(margin=3.0), np.random.default_rng(2)
    off, turned = [], []
    for _ in range(20):
        pad = on_tube(around, rng)
        contacts = contacts_of(perceive(frames(aslant(pad), rng)), pad)
        x, y, z = contacts.points.T
        far = np.hypot(x, y)
        tube = np.column_stack([x * (1.0 - RING / far), y * (1.0 - RING / far), z])
        size = np.linalg.norm(tube, axis=1)
        off.append(np.abs(size - TUBE).max())
        turned.append(
            np.degrees(np.arccos(np.clip((tube / size[:, None] * contacts.normals).sum(axis=1), -1, 1))).max()
        )
    assert np.quantile(off, 0.8) < 0.1
    assert np.median(turned) < 2.5
