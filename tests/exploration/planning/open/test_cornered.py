"""A hexagonal mouth is no circle, and a round one has no corners."""

import numpy as np
import pytest

from exploration.control.sighting import Sighting
from exploration.planning.open.cornered import cornered
from exploration.planning.open.round_rims import RoundRim

Z = np.eye(3)[2]
RIM = RoundRim(np.array([3.0, -2.0, 10.0]), Z, 38.0, 0.3, 0)


def edges(sides, rng, count=20):
    """Seen along the sides of a polygon about the middle of the rim, as far from it as the circle."""
    out = []
    for turn in rng.uniform(0.0, 2.0 * np.pi, count):
        facing = turn if sides is None else np.round(turn * sides / (2 * np.pi)) * 2 * np.pi / sides
        way = np.array([np.cos(facing), np.sin(facing), 0.0])
        place = 38.0 / np.cos(turn - facing) * np.array([np.cos(turn), np.sin(turn), 0.0])
        lean = 0.05 * rng.standard_normal() * np.cross(Z, way)
        out.append(Sighting(RIM.center + place, np.cross(Z, way), -way + lean, Z, 0.05, 8.0))
    return out


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("sides", [4, 6])
def test_a_polygon_has_corners_and_a_circle_none(sides, seed):
    rng = np.random.default_rng(seed)
    assert cornered(RIM, edges(sides, rng))
    assert not cornered(RIM, edges(None, rng))


def test_the_outer_rim_of_a_lug_gives_its_eye_no_corners():
    rng = np.random.default_rng(0)
    eye = RoundRim(RIM.center, Z, 12.0, 0.3, 0)
    seen = []
    for turn in rng.uniform(0.0, 2.0 * np.pi, 12):
        way = np.array([np.cos(turn), np.sin(turn), 0.0])
        seen.append(Sighting(RIM.center + 12.0 * way, np.cross(Z, way), -way, Z, 0.05, 6.0))
        seen.append(Sighting(RIM.center + 15.0 * way, np.cross(Z, way), way, Z, 0.05, 6.0))
    assert not cornered(eye, seen)


def test_few_edges_or_those_of_another_face_tell_nothing():
    rng = np.random.default_rng(0)
    seen = edges(6, rng)
    below = RoundRim(RIM.center, -Z, RIM.radius, RIM.sigma, 1)
    assert not cornered(RIM, seen[:2])
    assert not cornered(below, seen)
    assert not cornered(RoundRim(RIM.center, Z, 8.0, 0.3, 0), seen)
