"""The yardstick itself: scenes lie where they say, and the bound is that of textbooks where there is one."""

import numpy as np
import pytest
from perception import presses, told_apart
from perception.arrays import OTHERS, PAD, PRESS
from perception.bound import ZERO, fisher
from perception.nearest_dome import nearest_dome
from perception.noise import Noise, observe
from perception.scene import clean
from perception.score import line_error, paired
from perception.told_apart import apart, findable
from scipy.special import ndtr

from exploration.sensing.surfaces.smooth_fit import smooth_contact

MAKERS = (presses.edge, presses.corner, presses.wall, presses.slot, presses.vertex, presses.bar_end)


def far_from_others(scene, which, points):
    """Points of a line that lie more than three blurs from every other line."""
    clear = np.ones(len(points), dtype=bool)
    for k, (angle, offset) in enumerate(scene.found):
        if k != which:
            clear &= np.abs(points @ [-np.sin(angle), np.cos(angle)] - offset) > 5.4
    return points[clear]


@pytest.mark.parametrize("maker", MAKERS)
def test_every_true_line_runs_where_the_clean_frame_is_at_half_height(maker):
    from scipy.ndimage import map_coordinates

    compared = 0
    for seed in range(8):
        scene = maker(np.random.default_rng(seed))
        depth = clean(scene)
        for k, (angle, offset) in enumerate(scene.found):
            along = np.linspace(-12, 12, 60)[:, None] * [np.cos(angle), np.sin(angle)]
            points = far_from_others(scene, k, along + offset * np.array([-np.sin(angle), np.cos(angle)]))
            points = points[(np.abs(points) < [11.0, 6.0]).all(axis=1)]
            seen = map_coordinates(depth, (points / 1.8 + [7.5, 4.5]).T[::-1], order=3)
            half = seen[(seen > 0.1 * PRESS) & (seen < 0.9 * PRESS)]
            compared += len(half)
            np.testing.assert_allclose(half, PRESS / 2, atol=0.03 * PRESS)
    assert compared > 20 or maker is presses.vertex


def test_the_bound_of_three_unknowns_is_that_of_the_blurred_step():
    noise = Noise()
    x, y = np.meshgrid(PAD.array.x, PAD.array.y)
    width = np.sqrt(1.8**2 + 1.8**2 / 12)
    for seed in range(5):
        scene = presses.edge(np.random.default_rng(seed))
        (angle, offset), h = scene.found[0], 1e-4

        def step(p):
            return p[2] * ndtr((y * np.cos(p[0]) - x * np.sin(p[0]) - p[1]) / width)

        at = np.array([angle, offset, PRESS])
        slopes = np.array([(step(at + e) - step(at - e)).ravel() / (2 * h) for e in np.eye(3) * h])
        least = np.diag(np.linalg.inv(slopes @ slopes.T))[:2] * noise.sigma**2
        found = fisher(scene, noise, ("turn", "offset", "depth")).variances()[0]
        np.testing.assert_allclose(found, least, rtol=0.05)


def test_the_bound_grows_with_noise_and_with_what_is_not_known():
    scene = presses.corner(np.random.default_rng(3))
    quiet, loud = fisher(scene, Noise(0.05, 1e6)), fisher(scene, Noise(0.10, 1e6))
    np.testing.assert_allclose(loud.variances(), 4 * quiet.variances(), rtol=1e-6)
    assert np.all(quiet.variances(ZERO) <= quiet.variances() * (1 + 1e-9))


@pytest.mark.parametrize("maker", [presses.disc, presses.hole])
@pytest.mark.parametrize("radius", [3.0, 10.0, 60.0])
def test_a_clean_frame_changes_smoothly_with_the_radius(maker, radius):
    scene = maker(np.random.default_rng(1), radius)
    h = 0.02
    one, two = (
        (clean(scene.moved(radius=k * h)) - clean(scene.moved(radius=-k * h))) / (2 * k * h) for k in (1, 2)
    )
    assert np.abs(one - two).max() < 0.05 * np.abs(one).max()


def test_the_same_generator_gives_the_same_frame():
    first, second = (np.random.default_rng(4) for _ in range(2))
    a, b = presses.wall(first), presses.wall(second)
    np.testing.assert_array_equal(observe(a, Noise(), first).depth, observe(b, Noise(), second).depth)


def test_errors_of_a_line_do_not_depend_on_which_way_it_is_said():
    truth = np.array([0.01, 2.0])
    for said in ((0.02, 2.1), (0.02 + np.pi, -2.1), (0.02 - np.pi, -2.1)):
        np.testing.assert_allclose(line_error(said, truth), [0.01, 0.1], atol=1e-12)


def test_a_line_found_once_stands_for_one_true_line_only():
    scene = presses.wall(np.random.default_rng(0))

    class Said:
        angle, offset = scene.found[0]

    errors = paired((Said(),), scene.found, np.ones((2, 2)), 1.8)
    assert [e is None for e in errors] == [False, True]


@pytest.mark.parametrize("maker", MAKERS)
def test_the_bound_does_not_depend_on_where_angles_are_counted_from(maker):
    scene = maker(np.random.default_rng(5))
    seam = np.pi - scene.numbers["turn"]
    here, there = (fisher(scene.moved(turn=seam + d), Noise()).variances() for d in (-0.0001, 0.0001))
    np.testing.assert_allclose(here, there, rtol=0.05)


def test_a_smooth_surface_is_not_told_from_itself():
    rng = np.random.default_rng(6)
    kinds = (1 / 57.6, presses.bar(rng, 57.6)), (1 / 90, presses.ball(rng, 90.0)), (0.0, presses.flat(rng))
    for sharp, scene in kinds:
        assert apart(scene, Noise()) < 1.0
        contact = smooth_contact(told_apart.quiet(scene, Noise()))
        for sharpest in (1 / 28.8, 0.6 * sharp):
            limits = max(sharpest, 1e-6), told_apart.AWAY, told_apart.DEEPEST, told_apart.STEEPEST
            assert (nearest_dome(contact, *limits) < 1.0) == (sharpest >= sharp)


def test_an_edge_across_the_pad_can_be_found_and_one_under_so_few_taxels_cannot():
    rng = np.random.default_rng(7)
    edges = [presses.edge(rng) for _ in range(3)]
    middle = [edge.moved(offset=-edge.numbers["offset"]) for edge in edges]
    assert findable(middle, Noise()) > 0.999
    assert findable([presses.edge(rng, OTHERS["4x4 at 2 mm"]) for _ in range(3)], Noise()) < 0.1
