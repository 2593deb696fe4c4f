"""A hexagonal mouth is no circle, and a round one has no corners."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from exploration.control.sighting import Sighting
from exploration.planning.known.mosaic import Picture
from exploration.planning.open.cornered import cornered, pictured_cornered
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


class Pictured:
    """A mosaic that saw the face round an opening at the rim's middle, as softly as pads do."""

    config = SimpleNamespace(step=0.5)

    def __init__(self, opens, known=lambda x, y: x > -np.inf):
        self.opens, self.known = opens, known

    def picture(self, anchor, normal, lattice):
        i, j = np.meshgrid(*(np.arange(count) for count in lattice.shape), indexing="ij")
        world = (lattice.origin + lattice.step * np.stack([i, j], axis=-1)) @ lattice.along.T
        x, y = np.moveaxis(world - RIM.center, -1, 0)[:2]
        share = gaussian_filter((~self.opens(x, y)).astype(float), 1.4 / lattice.step, mode="nearest")
        noise = 0.05 * np.random.default_rng(1).standard_normal(share.shape)
        return Picture(share + noise, self.known(x, y))


def polygon(sides, across):
    """Whether places are in a polygon, half so many mm across its flats."""
    turns = 2.0 * np.pi * (np.arange(sides) + 0.3) / sides
    return lambda x, y: np.max([x * np.cos(t) + y * np.sin(t) for t in turns], axis=0) < across


def circle(radius, aside=0.0):
    return lambda x, y: np.hypot(x - aside, y) < radius


def keyed(x, y):
    return circle(14.0)(x, y) | ((np.abs(y) < 3.0) & (x > 0.0) & (x < 17.0))


def rim(radius):
    return RoundRim(RIM.center, Z, radius, 0.3, 0)


@pytest.mark.parametrize("across", [13.0, 19.0])
@pytest.mark.parametrize("sides", [4, 6])
def test_a_picture_shows_the_corners_of_a_polygon(sides, across):
    assert pictured_cornered(rim(1.04 * across), Pictured(polygon(sides, across)))


@pytest.mark.parametrize(
    ("opens", "radius"),
    [(circle(14.0), 14.3), (circle(24.0, 1.0), 24.0), (circle(12.0), 13.5), (keyed, 14.2)],
)
def test_a_circle_has_none_in_a_picture_be_it_keyed_or_beside_its_place(opens, radius):
    assert not pictured_cornered(rim(radius), Pictured(opens))


def test_a_picture_of_a_part_or_of_nothing_tells_nothing():
    half = Pictured(polygon(6, 14.0), lambda x, y: x > 0.0)
    assert not pictured_cornered(rim(14.5), half)
    assert not pictured_cornered(rim(14.5), Pictured(lambda x, y: x > np.inf))
    assert not pictured_cornered(rim(8.0), Pictured(polygon(6, 7.8)))
