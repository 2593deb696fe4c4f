"""Radii that are one, walls that touch round ends, holes in a row or a ring, and sizes on a grid."""

from dataclasses import dataclass

import numpy as np
import pytest

from primitives.pose import pose, random_rotation
from primitives.shapes import Cylinder, Plane, Shape
from recognition.assembly.regularities import RegularityOptions, regularize

UP = np.array([0.0, 0.0, 1.0])
TILT = np.deg2rad(0.05)


@dataclass
class Given:
    shape: Shape
    covariance: np.ndarray
    convex: bool
    chi2: float = 10.0
    dof: int = 10


def given(shape, rng, offset=0.01, convex=False):
    """A shape at a random place of its own covariance."""
    sigma = np.full(shape.dof, offset)
    first = len(shape.translations)
    sigma[first : first + shape.tilts] = TILT
    return Given(shape.retract(sigma * rng.standard_normal(shape.dof)), np.diag(sigma**2), convex)


def hole(x, y, radius):
    return Cylinder(np.array([x, y, 0.0]), UP, radius)


def of(found, kind):
    return [r for r in found.relations if r.kind == kind]


def plate(rng, scale=1.0, sigma=0.01):
    """Of 60 x 40 x 12 mm with two holes of 6.5 mm, scaled, at any attitude."""
    half = scale * np.array([30.0, 20.0, 6.0])
    axes, world = np.eye(3), pose(random_rotation(rng), rng.uniform(-50, 50, 3))
    faces = [(Plane(s * h * axes[i], s * axes[i]), True) for i, h in enumerate(half) for s in (-1.0, 1.0)]
    faces += [(hole(scale * x, 0.0, scale * 3.25), False) for x in (-20.0, 20.0)]
    return [given(shape.transformed(world), rng, sigma, convex) for shape, convex in faces]


@pytest.mark.parametrize(("apart", "most"), [(0.0, 1.0), (0.1, 0.05), (0.5, 0.0)])
def test_radii_become_one_where_they_are_and_not_where_they_differ(apart, most):
    taken = []
    for seed in range(40):
        rng = np.random.default_rng(seed)
        pair = [given(hole(0, 0, 5.0), rng), given(hole(30, 7, 5.0 + apart), rng)]
        found = regularize(pair, RegularityOptions(round=False))
        taken.append(len(of(found, "equal radius")))
        same = abs(found.shapes[0].radius - found.shapes[1].radius) < 1e-9
        assert same == taken[-1]
    assert np.mean(taken) <= most
    assert apart or np.mean(taken) > 0.9


def test_what_was_measured_is_told_beside_what_stands():
    rng = np.random.default_rng(4)
    pair = [given(hole(0, 0, 5.0), rng, 0.02), given(hole(30, 7, 5.0), rng, 0.02)]
    (told,) = of(regularize(pair, RegularityOptions(round=False)), "equal radius")
    assert told.measured == pytest.approx(abs(pair[0].shape.radius - pair[1].shape.radius))
    assert told.sigma == pytest.approx(0.02 * np.sqrt(2.0), rel=0.02)
    assert told.taken == 0.0


def test_the_round_end_of_a_bar_touches_both_its_sides():
    rng = np.random.default_rng(1)
    sides = [given(Plane([0, y, 0], [0, np.sign(y), 0]), rng, convex=True) for y in (8.0, -8.0)]
    end = given(Cylinder([40.0, 0.0, 0.0], UP, 8.0), rng, 0.2, convex=True)
    found = regularize([*sides, end], RegularityOptions(round=False))
    assert len(of(found, "tangent")) == 2
    round_end = found.shapes[2]
    away = [wall.signed_distance(round_end.origin[None])[0] for wall in found.shapes[:2]]
    assert np.allclose(away, -round_end.radius, atol=1e-8)
    assert round_end.radius == pytest.approx(8.0, abs=0.03)


def test_a_boss_beside_a_wall_does_not_touch_it():
    rng = np.random.default_rng(1)
    wall = given(Plane([0, 8.05, 0], [0, -1.0, 0]), rng, convex=True)
    boss = given(Cylinder([40.0, 0.0, 0.0], UP, 8.0), rng, 0.2, convex=True)
    assert not of(regularize([wall, boss]), "tangent")


def ring(count, rng, off=0.0, sigma=0.02):
    turn = 2.0 * np.pi * np.arange(count) / count + 0.3
    places = 20.0 * np.column_stack([np.cos(turn), np.sin(turn)])
    places[0] += off
    return [given(hole(0, 0, 9.0), rng), *(given(hole(x, y, 2.5), rng, sigma) for x, y in places)]


@pytest.mark.parametrize("count", [2, 3, 6])
def test_holes_round_a_bore_are_evenly_spaced(count):
    found = regularize(ring(count, np.random.default_rng(10 + count)), RegularityOptions(round=False))
    assert of(found, "evenly spaced")
    center, *holes = found.shapes
    away = np.array([h.anchor - center.anchor for h in holes]) @ center.frame[:, :2]
    turn = np.sort(np.arctan2(away[:, 1], away[:, 0]))
    assert np.ptp(np.linalg.norm(away, axis=1)) < 1e-6
    assert np.allclose(np.diff(turn), 2.0 * np.pi / count, atol=1e-7)


@pytest.mark.parametrize("more", ["a like hole elsewhere", "a second flange"])
def test_other_holes_hide_no_ring(more):
    rng = np.random.default_rng(12)
    fits = ring(4, rng)
    if more == "a second flange":
        fits += [given(hole(*fit.shape.anchor[:2], 2.5), rng, 0.02) for fit in fits[1:]]
    else:
        fits.append(given(hole(37.0, 5.0, 2.5), rng, 0.02))
    assert len(of(regularize(fits, RegularityOptions(round=False)), "evenly spaced")) >= 4


@pytest.mark.parametrize("count", [12, 24])
def test_many_like_holes_become_one_family(count):
    rng = np.random.default_rng(count)
    fits = [given(hole(12.0 * k, 3.0 * rng.standard_normal(), 4.03), rng, 0.02) for k in range(count)]
    found = regularize(fits, RegularityOptions(round=False))
    assert np.ptp([shape.radius for shape in found.shapes]) < 1e-6


def test_a_hole_that_is_off_its_ring_stays_there():
    found = regularize(ring(4, np.random.default_rng(0), off=0.5), RegularityOptions(round=False))
    place = found.shapes[1].anchor[:2]
    assert np.linalg.norm(place - 20.0 * np.array([np.cos(0.3), np.sin(0.3)])) > 0.5


def test_three_holes_in_a_row_are_evenly_spaced():
    rng = np.random.default_rng(2)
    row = [given(hole(x, 0.3 * x, 4.0), rng) for x in (-15.0, 0.0, 15.0)]
    found = regularize(row, RegularityOptions(round=False))
    first, middle, last = (shape.anchor for shape in found.shapes)
    assert np.abs(first + last - 2 * middle)[:2].max() < 1e-7


def test_sizes_on_a_grid_are_put_there_and_keep_their_deviation():
    fits = plate(np.random.default_rng(5))
    free, found = regularize(fits, RegularityOptions(round=False)), regularize(fits)
    assert {6.5, 10.0, 12.0} <= {r.taken for r in of(found, "round")}
    for low, high, size in ((0, 1, 60.0), (2, 3, 40.0), (4, 5, 12.0)):
        a, b = found.shapes[low], found.shapes[high]
        assert abs((b.anchor - a.anchor) @ b.direction) == pytest.approx(size, abs=1e-6)
    assert found.shapes[6].radius == pytest.approx(3.25, abs=1e-6)
    assert np.array_equal(free.covariance, found.covariance)


def test_corners_of_another_radius_keep_no_other_size_from_its_number():
    for seed in range(5):
        rng = np.random.default_rng(seed)
        corners = [(sx * (30.0 - 5.05), sy * (20.0 - 5.05)) for sx in (-1, 1) for sy in (-1, 1)]
        rounded = [given(hole(x, y, 5.05), rng, convex=True) for x, y in corners]
        flat = [(Plane([0, 0, z], [0, 0, np.sign(z)])) for z in (-6.0, 6.0)]
        flat += [Plane([x, 0, 0], [np.sign(x), 0, 0]) for x in (-30.0, 30.0)]
        flat += [Plane([0, y, 0], [0, np.sign(y), 0]) for y in (-20.0, 20.0)]
        fits = [given(plane, rng, convex=True) for plane in flat] + rounded
        fits += [given(hole(x, 0.0, 3.25), rng) for x in (-20.0, 20.0)]
        assert {12.0, 40.0, 60.0} <= {r.taken for r in of(regularize(fits), "round")}


def test_what_was_scaled_at_random_is_on_no_grid():
    rng = np.random.default_rng(6)
    found = [regularize(plate(rng, scale)) for scale in rng.uniform(0.9, 1.1, 30)]
    assert sum(bool(of(one, "round")) for one in found) <= 1


def test_what_is_poorly_measured_is_on_no_grid():
    rng = np.random.default_rng(7)
    assert not any(of(regularize(plate(rng, sigma=0.5)), "round") for _ in range(20))
