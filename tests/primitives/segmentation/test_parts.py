import numpy as np
import pytest

from primitives.segmentation.parts import density, parts
from primitives.shapes import Plane

FLOOR = Plane(np.zeros(3), [0, 0, 1.0])


def on_floor(places):
    return np.column_stack([places, np.zeros(len(places))])


def fallen(face, n, rng):
    """Contacts on a face, one on each mm^2 of it."""
    if face == "disc" or face == "ring":
        inner = 0.64 if face == "ring" else 0.0
        r = np.sqrt(n / np.pi * (inner + (1 - inner) * rng.random(n)) / (1 - inner))
        turn = rng.uniform(0, 2 * np.pi, n)
        return np.stack([r * np.cos(turn), r * np.sin(turn)], axis=1)
    wide = {"square": 1.0, "strip": 0.25}[face]
    return rng.random((n, 2)) * np.sqrt([n / wide, n * wide])


@pytest.mark.parametrize("face", ["square", "strip", "disc", "ring"])
@pytest.mark.parametrize("count", [6, 20, 60, 300])
def test_one_face_stays_whole(face, count):
    rng = np.random.default_rng(count)
    several = sum(len(parts(FLOOR, on_floor(fallen(face, count, rng)), 1.0)) > 1 for _ in range(40))
    assert several <= 1


def test_the_density_of_contacts_that_fill_a_surface_is_theirs():
    points = on_floor(np.random.default_rng(0).random((800, 2)) * 40)
    assert 0.35 < density(points) < 0.65


def test_gaps_between_strokes_part_no_face():
    rows = np.repeat(np.arange(5) * 8.0, 60)
    along = np.tile(np.arange(60) * 0.5, 5)
    points = on_floor(np.stack([rows, along], axis=1))
    assert len(parts(FLOOR, points, density(points))) == 1


def test_narrow_lands_are_parted():
    rng = np.random.default_rng(0)
    both = rng.random((50, 2)) * [15, 12]
    both[25:, 0] += 45
    assert len(parts(FLOOR, on_floor(both), 25 / 180)) == 2


def test_an_island_in_a_ring_is_parted():
    rng = np.random.default_rng(0)
    r = np.sqrt(np.concatenate([rng.uniform(0, 64, 60), rng.uniform(900, 1600, 700)]))
    turn = rng.uniform(0, 2 * np.pi, 760)
    found = parts(FLOOR, on_floor(np.stack([r * np.cos(turn), r * np.sin(turn)], axis=1)), 0.3)
    assert sorted(map(len, found)) == [60, 700]
