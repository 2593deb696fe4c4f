from dataclasses import replace

import numpy as np
import pytest

from exploration.sensing.lines.hough import find_lines, sure_lines
from exploration.sensing.lines.outline import find_outline


def error(line, angle, offset, side):
    """Angle [rad] and offset [mm] off, with the wrap; the material must be on the right side."""
    inward = side * np.array([-np.sin(angle), np.cos(angle)])
    turn = float(np.cross(np.append(inward, 0), np.append(line.inward, 0))[2])
    assert line.inward @ inward > 0.9
    return turn, line.material_side * line.offset - side * offset


def test_every_edge_is_found_once_within_its_own_uncertainty(frames):
    rng = np.random.default_rng(3)
    z = []
    for _ in range(150):
        angle, offset, side = rng.uniform(0, np.pi), rng.uniform(-4.0, 4.0), int(rng.choice([-1, 1]))
        lines = find_lines(frames(frames.edge(angle, offset, side), rng))
        assert len(lines) == 1
        z.append(np.array(error(lines[0], angle, offset, side)) / np.sqrt(np.diag(lines[0].covariance)))
    assert np.sqrt(np.mean(np.square(z), axis=0)) == pytest.approx([1.0, 1.0], abs=0.2)
    assert np.abs(z).max() < 5.0


@pytest.mark.parametrize("angle", [0.0, 1e-4, np.pi - 1e-4, np.pi / 2])
@pytest.mark.parametrize("side", [-1, 1])
def test_lines_wrap_round_at_zero_and_a_half_turn(frames, angle, side):
    (line,) = find_lines(frames(frames.edge(angle, 2.0, side), np.random.default_rng(4)))
    assert 0.0 <= line.angle < np.pi
    turn, off = error(line, angle, 2.0, side)
    assert abs(turn) < 0.05
    assert abs(off) < 0.3


def test_a_turned_pad_sees_the_turned_line(frames):
    image = frames(frames.edge(0.6, 1.7), np.random.default_rng(5))
    turned = replace(image, depth=image.depth[::-1, ::-1].copy(), sigma=image.sigma[::-1, ::-1].copy())
    (line,), (other,) = find_lines(image), find_lines(turned)
    assert other.angle == pytest.approx(line.angle, abs=2e-3)
    assert other.offset == pytest.approx(-line.offset, abs=0.02)
    assert other.material_side == -line.material_side


def test_a_corner_gives_its_two_edges(frames):
    rng = np.random.default_rng(6)
    a, b = (0.7, -1.0, 1), (0.7 + np.pi / 2, 1.0, 1)
    found = 0
    for _ in range(20):
        image = frames(lambda x, y: 0.5 * frames.half(*a)(x, y) * frames.half(*b)(x, y), rng)
        lines = find_lines(image)
        if len(lines) == 2:
            near = sorted(lines, key=lambda line: abs(line.angle - 0.7))
            found += all(abs(error(line, *true)[0]) < 0.2 for line, true in zip(near, (a, b), strict=True))
    assert found >= 19


def test_a_wide_wall_gives_two_parallel_edges(frames):
    image = frames(lambda x, y: 0.5 * (np.abs(x) < 5.5), np.random.default_rng(7))
    lines = find_lines(image)
    assert sorted(line.material_side * line.offset for line in lines) == pytest.approx([-5.5, -5.5], abs=0.4)


def test_a_wall_that_a_narrow_cylinder_explains_has_edges_but_none_to_steer_by(frames):
    rng = np.random.default_rng(17)
    for _ in range(8):
        image = frames(lambda x, y: 0.5 * (np.abs(y - 0.3) < 2.5), rng)
        lines = find_lines(image)
        assert sorted(line.material_side * line.offset for line in lines) == pytest.approx(
            [-2.8, -2.2], abs=0.6
        )
        assert not sure_lines(image)


def test_an_edge_by_the_rim_is_not_given_up_for_a_dome_that_fits_as_well(frames):
    rng = np.random.default_rng(18)
    found, fits_better = 0, 0
    for _ in range(60):
        image = frames(frames.edge(rng.uniform(-0.3, 0.3), rng.uniform(4.0, 5.2)), rng)
        found += len(find_lines(image)) == 1
        fits_better += len(find_outline(image).lines) == 1
    assert found >= 57
    assert found > fits_better + 4


@pytest.mark.parametrize("find", [find_lines, sure_lines])
@pytest.mark.parametrize("radius", [10.0, 20.0, 60.0, 200.0])
def test_curvature_is_no_edge(frames, radius, find):
    rng = np.random.default_rng(8)
    for _ in range(25):
        x0, y0, angle = rng.uniform(-4, 4), rng.uniform(-3, 3), rng.uniform(0, np.pi)
        assert not find(frames(frames.sphere(radius, x0, y0), rng))
        if find is sure_lines or radius > 28.8:
            assert not find(frames(frames.cylinder(radius, angle, y0), rng))


def test_flat_tilted_and_empty_frames_have_no_line(frames):
    rng = np.random.default_rng(9)
    for _ in range(50):
        slope = tuple(rng.normal(0.0, 0.02, 2))
        assert not find_lines(frames(frames.plane(0.5, slope), rng))
        assert not find_lines(frames(frames.plane(0.0), rng))


def test_known_dead_taxels_cost_little(frames):
    rng = np.random.default_rng(10)
    image = frames(frames.edge(0.4, 0.5), rng)
    dead = rng.random(image.depth.shape) < 0.05
    blind = replace(image, depth=np.where(dead, 0.0, image.depth), sigma=np.where(dead, np.inf, image.sigma))
    (line,) = find_lines(blind)
    turn, off = error(line, 0.4, 0.5, 1)
    assert abs(turn) < 0.06
    assert abs(off) < 0.4


@pytest.mark.parametrize("value", [np.nan, np.inf, -3.0, 5.0])
def test_hostile_frames_are_no_line(frames, value):
    image = frames(frames.edge(0.4, 0.5), np.random.default_rng(11))
    assert find_lines(replace(image, depth=np.full_like(image.depth, value))) == ()
    assert find_lines(replace(image, sigma=np.full_like(image.sigma, np.inf))) == ()


@pytest.mark.parametrize(("rows", "columns", "pitch", "spread"), [(14, 6, 3.4, 3.4), (32, 32, 1.0, 1.0)])
def test_other_arrays_see_the_edge_too(make_frames, rows, columns, pitch, spread):
    frames = make_frames(rows, columns, pitch, spread, noise=0.01)
    lines = find_lines(frames(frames.edge(0.6, 0.3), np.random.default_rng(12)))
    assert len(lines) == 1
    turn, off = error(lines[0], 0.6, 0.3, 1)
    assert abs(turn) < 0.2
    assert abs(off) < 0.5 * pitch


def test_the_end_of_the_skin_moves_no_line(make_frames):
    frames = make_frames(spread=1.2, noise=0.005, margin=0.9)
    rng = np.random.default_rng(13)
    z = []
    for _ in range(60):
        angle, offset, side = rng.uniform(0, np.pi), rng.uniform(-4.0, 4.0), int(rng.choice([-1, 1]))
        lines = find_lines(frames(frames.edge(angle, offset, side), rng))
        assert len(lines) == 1
        z.append(np.array(error(lines[0], angle, offset, side)) / np.sqrt(np.diag(lines[0].covariance)))
    assert np.sqrt(np.mean(np.square(z), axis=0)) == pytest.approx([1.0, 1.0], abs=0.3)
