from dataclasses import replace

import numpy as np
import pytest

from exploration.sensing.lines.hough import find_lines
from exploration.sensing.lines.single_edge import DOUBTFUL, NOTHING, SURE, first_look, single_edge
from exploration.sensing.response import response_of
from primitives.errors import PalpateError


def look(image):
    return single_edge(image, response_of(image))


def error(line, angle, offset, side):
    """Angle [rad] and offset [mm] into the material off."""
    inward = side * np.array([-np.sin(angle), np.cos(angle)])
    assert line.inward @ inward > 0.9
    turn = float(inward[0] * line.inward[1] - inward[1] * line.inward[0])
    return turn, line.material_side * line.offset - side * offset


def edges(rng, n):
    for _ in range(n):
        yield rng.uniform(0, np.pi), rng.uniform(-4.0, 4.0), int(rng.choice([-1, 1]))


def test_nearly_every_edge_is_sure_at_once_and_its_covariance_is_its_scatter(frames):
    rng = np.random.default_rng(20)
    z = []
    for at in edges(rng, 300):
        verdict, line = look(frames(frames.edge(*at), rng))
        if verdict == SURE:
            z.append(np.array(error(line, *at)) / np.sqrt(np.diag(line.covariance)))
    assert len(z) > 280
    assert np.mean(np.square(z), axis=0) == pytest.approx([1.0, 1.0], abs=0.25)
    assert np.abs(z).max() < 5.0


@pytest.mark.parametrize("slope", [(0.035, 0.0), (0.0, -0.035), (-0.025, 0.025)])
def test_a_plateau_that_runs_out_within_the_pad_moves_no_line(frames, slope):
    for at in [(0.3, 1.0, 1), (1.7, -2.0, -1), (2.6, 0.5, 1)]:
        image = frames(frames.edge(*at, slope=slope))
        verdict, line = look(image)
        if verdict == SURE:
            turn, off = error(line, *at)
            assert abs(turn) < 2e-3
            assert abs(off) < 0.036


@pytest.mark.parametrize("dihedral", [120.0, 150.0])
def test_a_wide_dihedral_costs_what_is_stated_and_nothing_if_told(frames, dihedral):
    angle, offset, depth = 0.7, 0.8, 0.5
    run = depth * np.tan(np.radians(dihedral - 90.0))

    def field(x, y):
        t = y * np.cos(angle) - x * np.sin(angle) - offset
        return depth * np.clip(1.0 + t / run, 0.0, 1.0)

    image = frames(field)
    verdict, line = first_look(image, response_of(image), np.radians(dihedral))
    assert verdict == SURE
    assert abs(error(line, angle, offset, 1)[1]) < 0.01
    verdict, line = look(image)
    assert verdict == SURE
    assert error(line, angle, offset, 1)[1] == pytest.approx(-run / 2, abs=0.04)


def test_the_end_of_the_skin_is_in_the_model(make_frames):
    frames = make_frames(spread=1.2, noise=0.005, margin=0.9)
    rng = np.random.default_rng(21)
    for at in edges(rng, 40):
        verdict, line = look(frames(frames.edge(*at)))
        assert verdict == SURE
        turn, off = error(line, *at)
        assert abs(turn) < 1e-3
        assert abs(off) < 0.01


def test_taxels_that_died_without_telling_are_left_out(frames):
    rng = np.random.default_rng(22)
    z, sure = [], 0
    for at in edges(rng, 150):
        image = frames(frames.edge(*at), rng)
        died = rng.random(image.depth.shape) < 0.03
        verdict, line = look(replace(image, depth=np.where(died, 0.0, image.depth)))
        if verdict == SURE:
            sure += 1
            z.append(np.array(error(line, *at)) / np.sqrt(np.diag(line.covariance)))
    assert sure > 120
    assert np.sqrt(np.mean(np.square(z), axis=0)).max() < 1.3


def test_unknown_gains_bias_no_offset(frames):
    rng = np.random.default_rng(23)
    off, stated = [], []
    for at in edges(rng, 250):
        image = frames(frames.edge(*at), rng)
        depth = image.depth * (1.0 + 0.1 * rng.standard_normal(image.depth.shape))
        sigma = np.hypot(image.sigma, 0.1 * np.maximum(depth, 0.0))
        verdict, line = look(replace(image, depth=depth, sigma=sigma, gain_sigma=0.1))
        if verdict == SURE:
            off.append(error(line, *at)[1])
            stated.append(np.sqrt(line.covariance[1, 1]))
    assert abs(np.mean(off)) < 3 * np.std(off) / np.sqrt(len(off))
    assert np.std(off) == pytest.approx(np.sqrt(np.mean(np.square(stated))), rel=0.2)


def test_a_mirrored_frame_shows_the_mirrored_line(frames):
    rng = np.random.default_rng(24)
    for at in edges(rng, 20):
        image = frames(frames.edge(*at), rng)
        verdict, line = look(image)
        mirrored, other = look(replace(image, depth=image.depth[::-1].copy(), sigma=image.sigma[::-1].copy()))
        assert verdict == mirrored
        if verdict == SURE:
            assert other.direction @ (line.direction * [1, -1]) == pytest.approx(
                np.sign(other.direction @ (line.direction * [1, -1])), abs=1e-6
            )
            assert other.inward == pytest.approx(line.inward * [1, -1], abs=1e-3)
            assert other.material_side * other.offset == pytest.approx(
                line.material_side * line.offset, abs=1e-3
            )


def test_what_is_smooth_is_never_a_sure_edge(frames):
    rng = np.random.default_rng(25)
    for _ in range(150):
        radius, depth = np.exp(rng.uniform(np.log(20.0), np.log(400.0))), rng.uniform(0.3, 0.6)
        angle, x, y = rng.uniform(0, np.pi), rng.uniform(-8, 8), rng.uniform(-5, 5)
        assert look(frames(frames.sphere(radius, x, y, depth), rng))[0] != SURE
        assert look(frames(frames.cylinder(radius, angle, y, depth), rng))[0] != SURE
        assert look(frames(frames.plane(depth, tuple(rng.normal(0.0, 0.03, 2))), rng))[0] != SURE


def test_empty_and_flat_frames_are_nothing_at_once(frames):
    rng = np.random.default_rng(26)
    for depth in (0.0, 0.5, -3.0):
        assert look(frames(lambda x, y, depth=depth: np.full_like(x, depth), rng))[0] == NOTHING


def test_two_edges_are_left_to_the_longer_look(frames):
    rng = np.random.default_rng(27)
    half = frames.half
    corner = frames(lambda x, y: 0.5 * half(0.7, -1.0)(x, y) * half(0.7 + np.pi / 2, 1.0)(x, y), rng)
    wall = frames(lambda x, y: 0.5 * (np.abs(x) < 5.5), rng)
    assert look(corner)[0] == look(wall)[0] == DOUBTFUL


def test_a_pad_of_four_by_four_sees_an_edge(make_frames):
    frames = make_frames(4, 4, 2.0, 2.0, noise=0.005)
    rng = np.random.default_rng(28)
    found = 0
    for at in edges(rng, 60):
        at = (at[0], 0.5 * at[1], at[2])
        lines = find_lines(frames(frames.edge(*at), rng))
        found += len(lines) == 1 and abs(error(lines[0], *at)[0]) < 0.26
    assert found > 36


def test_a_frame_of_another_shape_is_refused_in_one_line(frames):
    image = frames(frames.edge(0.4, 0.5))
    with pytest.raises(PalpateError) as refused:
        find_lines(replace(image, depth=image.depth[:4]))
    assert "\n" not in str(refused.value)
