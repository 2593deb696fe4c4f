from dataclasses import replace

import numpy as np
import pytest

from exploration.sensing.suspects import suspects, unsuspected


def _some(frames, rng, count, dead=0.0):
    """Presses of many kinds: image, dead taxels, and the field's own truth."""
    for k in range(count):
        angle, offset = rng.uniform(0.0, np.pi), rng.uniform(-5.0, 5.0)
        one, other = (
            frames.half(angle, offset),
            frames.half(angle + rng.uniform(0.5, 2.6), rng.uniform(-4, 4)),
        )
        face = frames.plane(0.5, tuple(rng.normal(0.0, 0.01, 2)))
        field = (
            lambda x, y, one=one, face=face: one(x, y) * face(x, y),
            lambda x, y, one=one, other=other, face=face: one(x, y) * other(x, y) * face(x, y),
            lambda x, y, one=one, other=other, face=face: (1 - one(x, y) * other(x, y)) * face(x, y),
            face,
            frames.sphere(12.0, offset, 1.0),
            lambda x, y: 0.0 * x,
        )[k % 6]
        gone = rng.random(frames.array.shape) < dead
        truth = frames(field).depth
        image = frames(field, rng)
        yield (
            replace(image, depth=np.where(gone, frames.noise * rng.standard_normal(gone.shape), image.depth)),
            gone,
            truth,
        )


def test_nothing_is_suspected_on_clean_frames_of_faces_edges_corners_and_spheres(frames):
    marked = [suspects(image).sum() for image, _, _ in _some(frames, np.random.default_rng(0), 300)]
    assert sum(marked) <= 1e-4 * 300 * 160


@pytest.mark.parametrize("noise", [0.002, 0.025])
def test_dead_taxels_inside_contact_are_found_and_their_neighbors_spared(make_frames, noise):
    found = there = accused = 0
    for image, gone, truth in _some(make_frames(noise=noise), np.random.default_rng(1), 120, 0.03):
        marked = suspects(image)
        inside = truth > 0.25
        found, there = found + (marked & gone & inside).sum(), there + (gone & inside).sum()
        accused += (marked & ~gone).sum()
    assert there > 150
    assert found >= 0.95 * there
    assert accused <= 1e-3 * 120 * 160


def test_a_taxel_stuck_high_is_found_in_free_air(frames):
    image = frames(lambda x, y: 0.0 * x, np.random.default_rng(2))
    stuck = np.array(image.depth)
    stuck[0, 0] = stuck[4, 7] = 0.8
    marked = suspects(replace(image, depth=stuck))
    assert sorted(map(tuple, np.argwhere(marked))) == [(0, 0), (4, 7)]


def test_noise_above_the_calibration_makes_no_suspects(make_frames):
    noisy = make_frames(noise=0.05)
    images = [replace(i, sigma=i.sigma / 3) for i, _, _ in _some(noisy, np.random.default_rng(3), 120)]
    assert sum(suspects(i).sum() for i in images) <= 3e-4 * 120 * 160


def test_suspects_are_left_out_as_dead_taxels_are_and_clean_images_are_untouched(frames):
    image = frames(frames.plane(0.5), np.random.default_rng(4))
    assert unsuspected(image) is image
    depth = np.array(image.depth)
    depth[5, 5] = 0.0
    assert np.argwhere(np.isinf(unsuspected(replace(image, depth=depth)).sigma)).tolist() == [[5, 5]]


@pytest.mark.parametrize("shape", [(1, 1), (1, 8), (2, 2), (4, 4)])
def test_arrays_too_small_to_contradict_themselves_suspect_nobody(make_frames, shape):
    small = make_frames(rows=shape[0], columns=shape[1])
    image = small(small.plane(0.5), np.random.default_rng(5))
    assert not suspects(image).any()
    assert not suspects(replace(image, depth=image.depth * np.nan)).any()
