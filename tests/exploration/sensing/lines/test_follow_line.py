"""An expected edge, followed: unbiased where it bends, its ends read off profiles, lost when it is not there."""

import numpy as np
import pytest

from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.follow_line import follow_line
from exploration.sensing.lines.followed import Expected, Followed
from exploration.sensing.response import response_of


def disc_of(radius: float, center: tuple[float, float], inside: bool = True):
    """The depth field of a disc, or of a hole, smoothed over a sample's width."""

    def field(x, y):
        far = radius - np.hypot(x - center[0], y - center[1])
        return 0.5 * np.clip((far if inside else -far) / 0.225 + 0.5, 0.0, 1.0)

    return field


def followed(image: TactileImage, expected: Expected) -> Followed:
    return follow_line(image, response_of(image), expected)


@pytest.mark.parametrize("radius", [10.0, 20.0, 60.0])
@pytest.mark.parametrize("inside", [True, False])
def test_a_bent_edge_is_placed_without_bias(frames, radius: float, inside: bool) -> None:
    center = (1.0, -1.0 - radius) if inside else (1.0, 1.0 + radius)
    image = frames(disc_of(radius, center, inside))
    bend = (1.0 if inside else -1.0) / radius
    edge = followed(image, Expected(0.05, 0.3, -1, 0.7 * bend, 0.05, 8.0))
    assert edge
    foot = edge.foot
    assert np.hypot(*(foot - center)) == pytest.approx(radius, abs=0.03)
    assert edge.bend == pytest.approx(bend, rel=0.12, abs=2e-4)


def test_what_is_expected_of_the_bend_weighs_as_its_sigma_says(frames) -> None:
    image = frames(disc_of(20.0, (0.0, -21.0)))
    free = followed(image, Expected(0.0, -1.0, -1, 0.0, 0.1, 8.0))
    held = followed(image, Expected(0.0, -1.0, -1, 0.0, 1e-5, 8.0))
    assert free.bend == pytest.approx(0.05, rel=0.1)
    assert abs(held.bend) < 1e-3


def test_offset_errors_have_the_stated_size(frames) -> None:
    make, rng = frames, np.random.default_rng(4)
    field = frames.edge(0.1, 1.0)
    errors = []
    for _ in range(60):
        edge = followed(make(field, rng), Expected(0.08, 0.8, 1, 0.0, 0.01, 10.0))
        errors.append((edge.offset - 1.0) / np.sqrt(edge.covariance[1, 1]))
    assert 0.7 < np.std(errors) < 1.4
    assert abs(np.mean(errors)) < 0.5


@pytest.mark.parametrize("ahead", np.arange(2.5, 8.0, 0.4))
def test_where_the_face_ends_ahead_is_the_corner_wherever_the_columns_lie(frames, ahead: float) -> None:
    half = frames.half

    def field(x, y):
        return 0.5 * half(0.0, 0.0)(x, y) * half(np.pi / 2, -ahead)(x, y)

    edge = followed(frames(field), Expected(0.0, 0.1, 1))
    assert edge
    assert edge.misfit < 2.0
    assert edge.ahead == pytest.approx(ahead, abs=0.3)
    assert not np.isfinite(edge.behind)
    assert edge.offset == pytest.approx(0.0, abs=0.05)


def test_material_outside_ahead_is_an_inside_corner(frames) -> None:
    half = frames.half

    def field(x, y):
        return 0.5 * np.maximum(half(0.0, 0.0)(x, y), half(np.pi / 2, -6.0, -1)(x, y))

    edge = followed(frames(field), Expected(0.0, 0.1, 1))
    assert edge.opens == pytest.approx(6.0, abs=2.0)


@pytest.mark.parametrize("angle", np.linspace(0.3, 1.5, 13))
def test_a_narrow_face_that_ends_beside_what_was_looked_at_is_no_misfit(frames, angle: float) -> None:
    near, far = frames.half(angle, -1.0), frames.half(angle + np.pi, -11.0)
    edge = followed(frames(lambda x, y: 0.5 * near(x, y) * far(x, y)), Expected(angle, -0.9, 1))
    assert edge
    assert edge.misfit < 2.0
    assert edge.offset == pytest.approx(-1.0, abs=0.12)


@pytest.mark.parametrize("taper", [0.35, 0.6, 0.9])
@pytest.mark.parametrize("apex", [-16.0, -13.0])
def test_a_tapering_face_bends_the_edge_by_far_less_than_noise(frames, taper: float, apex: float) -> None:
    """The far edge slants toward the followed one and meets it `apex` [mm] along."""
    near, far = frames.half(0.0, 0.0), frames.half(taper, -apex * np.sin(taper), -1)
    edge = followed(frames(lambda x, y: 0.5 * near(x, y) * far(x, y)), Expected(0.0, 0.1, 1))
    assert edge
    assert abs(edge.offset) < 0.35 * np.sqrt(edge.covariance[1, 1])


def test_a_thin_wall_ends_opposite(frames) -> None:
    half = frames.half

    def field(x, y):
        return 0.5 * half(0.0, -1.0)(x, y) * half(0.0, 5.0, -1)(x, y)

    edge = followed(frames(field), Expected(0.0, -1.0, 1))
    assert edge.width == pytest.approx(6.0, abs=1.2)


def test_an_edge_that_is_not_there_is_lost(frames) -> None:
    rng = np.random.default_rng(1)
    flat = followed(frames(lambda x, y: 0.5 + 0.0 * x, rng), Expected(0.0, 0.0, 1))
    empty = followed(frames(lambda x, y: 0.0 * x, rng), Expected(0.0, 0.0, 1))
    assert not empty
    assert not flat or abs(flat.offset) > 2.0
