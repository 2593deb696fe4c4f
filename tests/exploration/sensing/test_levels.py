from dataclasses import replace

import numpy as np
import pytest

from exploration.sensing.levels import leveled, levels


@pytest.mark.parametrize("noise", [0.01, 0.03])
@pytest.mark.parametrize("kind", ["nothing", "edge", "ball"])
def test_the_noise_floor_is_read_off_a_frame_whatever_is_pressed(make_frames, noise, kind):
    frames, rng = make_frames(noise=noise), np.random.default_rng(0)
    field = {"nothing": lambda x, y: 0.0 * x, "edge": frames.edge(0.4, 1.0), "ball": frames.sphere(15.0)}[
        kind
    ]
    found = [levels(frames(field, rng)).noise for _ in range(40)]
    assert np.median(found) == pytest.approx(noise, rel=0.2)


@pytest.mark.parametrize("shift", [-0.08, 0.0, 0.1])
def test_a_shift_of_all_zeros_is_seen_beside_the_contact_and_taken_away(make_frames, shift):
    frames, rng = make_frames(spread=1.2), np.random.default_rng(1)
    pulls = []
    for k in range(30):
        image = frames(frames.edge(0.1 * k, rng.uniform(-2.0, 2.0)), rng)
        image = replace(image, depth=image.depth + shift)
        told = levels(image)
        if np.isfinite(told.background_sigma):
            pulls.append((told.background - shift) / told.background_sigma)
            assert told.plateau == pytest.approx(0.5, abs=0.08)
    assert len(pulls) >= 15
    assert np.sqrt(np.mean(np.square(pulls))) < 2.0


def test_contact_all_over_hides_the_background_and_is_left_alone(frames):
    image = frames(frames.plane(0.5), np.random.default_rng(2))
    told = levels(image)
    assert told.background == 0.0
    assert np.isinf(told.background_sigma)
    assert leveled(image) is image
