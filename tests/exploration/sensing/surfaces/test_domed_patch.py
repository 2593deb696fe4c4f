"""The domed inside of a small round contact."""

import numpy as np
import pytest

from exploration.control.feel import feel
from exploration.sensing.surfaces.domed_patch import domed_patch
from primitives.pose import pose, random_rotation, transform_points

RADIUS, PRESS = 36.0, 1.2  # [mm]


@pytest.fixture
def sharp(frames):
    """Of a rubber that spreads less than the others' do."""
    return type(frames)(spread=1.2)


def tip(sharp, rim=8.0):
    """A ball's cap that ends in a sharp round rim [mm]."""
    ball = sharp.sphere(RADIUS, depth=PRESS)
    return lambda x, y: ball(x, y) * np.clip((rim - np.hypot(x, y)) / 0.225 + 0.5, 0.0, 1.0)


def contacts(image, at):
    return domed_patch(image, feel(image).inner, at, 1, 1, 0)


def test_contacts_lie_on_the_ball_that_was_touched_and_face_away_from_its_center(sharp):
    rng = np.random.default_rng(0)
    at = pose(random_rotation(rng), [10.0, -20.0, 30.0])
    center = transform_points(at, np.array([[0.0, 0.0, RADIUS - PRESS]]))[0]
    off, turn = [], []
    for _ in range(30):
        found = contacts(sharp(tip(sharp), rng), at)
        if not len(found):
            continue
        assert len(found) == 5
        away = found.points - center
        distance = np.linalg.norm(away, axis=1)
        off.append((distance - RADIUS) / found.sigma)
        turn.append(np.arccos(np.clip((found.normals * away).sum(axis=1) / distance, -1, 1)))
    assert len(off) > 15
    assert np.abs(np.mean(off)) < 1.0
    assert np.sqrt(np.mean(np.square(off))) < 1.6
    assert np.median(turn) < 0.05


def test_a_plateau_with_an_edge_through_it_is_no_dome(sharp):
    image = sharp(sharp.edge(0.4, 0.0), np.random.default_rng(1))
    whole = np.ones(image.array.shape, dtype=bool)
    assert len(domed_patch(image, whole, np.eye(4), 1, 1, 0)) == 0


def test_a_few_taxels_are_no_dome(sharp):
    image = sharp(sharp.sphere(RADIUS), np.random.default_rng(2))
    few = np.zeros(image.array.shape, dtype=bool)
    few[4:6, 6:9] = True
    assert len(domed_patch(image, few, np.eye(4), 1, 1, 0)) == 0
