import numpy as np
import pytest

from exploration.sensing.lines.hough import find_lines
from exploration.sensing.lines.outline import find_outline
from exploration.sensing.lines.parallel import made_parallel
from exploration.sensing.lines.region import TWO, Region
from exploration.sensing.lines.region_fit import RegionFit


def disc(x0, y0, radius, inside=True):
    """1 in (or out of) a circle, smoothed over a sample's width."""

    def cover(x, y):
        t = radius - np.hypot(x - x0, y - y0)
        return np.clip((t if inside else -t) / 0.225 + 0.5, 0.0, 1.0)

    return cover


def times(*covers):
    return lambda x, y: 0.5 * np.prod([cover(x, y) for cover in covers], axis=0)


def without(*covers):
    return lambda x, y: 0.5 * (1.0 - np.prod([1.0 - cover(x, y) for cover in covers], axis=0))


def errors(lines, truths):
    """Normalized errors of lines, each paired with the truth whose material lies the same way."""
    out = []
    for angle, offset, side in truths:
        inward = side * np.array([-np.sin(angle), np.cos(angle)])
        line = max(lines, key=lambda line: line.inward @ inward)
        turn = float(np.cross(np.append(inward, 0.0), np.append(line.inward, 0.0))[2])
        off = line.material_side * line.offset - side * offset
        out.append(np.array([turn, off]) / np.sqrt(np.diag(line.covariance)))
    return out


def many(frames, make, truths_of, count, find, seed):
    """Normalized errors over many frames, and how many frames had another number of lines."""
    rng = np.random.default_rng(seed)
    z, missed = [], 0
    for _ in range(count):
        truths = truths_of(rng)
        lines = find(frames(make(*(frames.half(*t) for t in truths)), rng))
        if len(lines) != len(truths):
            missed += 1
        else:
            z += errors(lines, truths)
    return np.array(z), missed


def opened(rng):
    angle, opening = rng.uniform(-np.pi, np.pi), rng.choice(np.radians([60.0, 90.0, 120.0]))
    at = rng.uniform(-2.5, 2.5, 2)
    turned = angle + opening
    first = (angle, at @ [-np.sin(angle), np.cos(angle)], 1)
    return [first, (turned, at @ [-np.sin(turned), np.cos(turned)], -1)]


def parted(rng, low, high, side):
    angle, half = rng.uniform(-np.pi, np.pi), rng.uniform(low, high) / 2
    middle = rng.uniform(-2.0, 2.0)
    return [(angle, middle - half, side), (angle, middle + half, -side)]


def ended(rng):
    angle = rng.uniform(-np.pi, np.pi)
    half = rng.uniform(3.5, 5.0)
    return [(angle, -half, 1), (angle, half, -1), (angle + np.pi / 2, rng.uniform(-2.0, 2.0), 1)]


CASES = {
    "corner": (times, opened),
    "inside corner": (without, opened),
    "slot": (without, lambda rng: parted(rng, 3.0, 9.0, -1)),
    "wall": (times, lambda rng: parted(rng, 9.5, 11.0, 1)),
}


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("find", [find_lines, lambda image: find_outline(image).lines])
def test_two_lines_are_found_within_their_own_uncertainty(frames, name, find):
    make, truths = CASES[name]
    z, missed = many(frames, make, truths, 25, find, 1)
    assert missed <= 3
    assert np.sqrt(np.mean(z**2)) == pytest.approx(1.0, abs=0.35)


def test_the_end_of_a_bar_has_three_lines(frames):
    z, missed = many(frames, times, ended, 25, lambda image: find_outline(image).lines, 2)
    assert missed <= 5
    assert np.sqrt(np.mean(z**2)) == pytest.approx(1.0, abs=0.35)


def test_lines_of_a_short_skin_are_not_pulled_by_its_end(make_frames):
    frames = make_frames(spread=1.2, noise=0.005, margin=0.9)
    z, missed = many(frames, times, opened, 15, find_lines, 3)
    assert missed <= 1
    assert np.sqrt(np.mean(z**2)) < 2.0


@pytest.mark.parametrize(
    ("radius", "inside"),
    [(3.0, False), *((r, inside) for r in (6.0, 12.0, 30.0) for inside in (True, False))],
)
def test_rims_are_arcs_whose_radius_is_as_sure_as_they_say(frames, radius, inside):
    rng = np.random.default_rng(4)
    z, shift, missed = [], [], 0
    for _ in range(20):
        away = rng.uniform(0.0, 1.5) if radius < 7.0 else radius + rng.uniform(-3.0, 3.0)
        turn = rng.uniform(-np.pi, np.pi)
        center = away * np.array([np.cos(turn), np.sin(turn)])
        outline = find_outline(frames(times(disc(*center, radius, inside)), rng))
        if len(outline.arcs) != 1 or outline.arcs[0].material_inside is not inside:
            missed += 1
            continue
        (arc,) = outline.arcs
        error = np.append(arc.center - center, arc.radius - radius)
        z.append(float(error @ np.linalg.solve(arc.covariance, error)) / 3)
        shift.append(np.linalg.norm(arc.center) - arc.radius - away + radius)
    assert missed <= 2
    assert np.mean(z) == pytest.approx(1.0, abs=0.6)
    assert abs(np.mean(shift)) < 4 * np.std(shift) / np.sqrt(len(shift)) + 0.02


def test_a_rim_that_is_nearly_straight_is_told_from_a_line(frames):
    right = 0
    for inside in (True, False):
        rng, rim = np.random.default_rng(9), times(disc(60 * np.cos(0.5), 60 * np.sin(0.5), 60.0, inside))
        found = [find_outline(frames(rim, rng)).arcs for _ in range(25)]
        right += sum(len(arcs) == 1 and arcs[0].material_inside is inside for arcs in found)
    assert right >= 47


def test_the_radius_of_a_small_disc_is_not_widened_by_slopes_that_are_noise(frames):
    rng = np.random.default_rng(8)
    found = [find_outline(frames(times(disc(0.3, -0.4, 3.0)), rng)).arcs for _ in range(60)]
    radii = [arcs[0].radius for arcs in found if arcs]
    assert len(radii) > 55
    assert np.mean(radii) == pytest.approx(3.0, abs=0.08)


def test_a_small_hole_is_seen_whole_though_nothing_crosses_half_height(frames):
    image = frames(times(disc(1.0, -0.5, 2.0, False)), np.random.default_rng(5))
    assert image.depth.min() > 0.2
    (arc,) = find_outline(image).arcs
    assert not arc.material_inside
    assert arc.span == pytest.approx(2 * np.pi)
    assert arc.radius == pytest.approx(2.0, abs=0.3)
    assert arc.center == pytest.approx([1.0, -0.5], abs=0.5)


def test_a_hole_is_found_beside_an_edge(frames):
    cover = times(frames.half(0.1, -4.0), disc(2.0, 3.0, 2.0, False))
    outline = find_outline(frames(cover, np.random.default_rng(6)))
    assert len(outline.lines) == len(outline.arcs) == 1
    assert outline.lines[0].offset == pytest.approx(-4.0, abs=0.3)
    assert outline.arcs[0].radius == pytest.approx(2.0, abs=0.4)


def test_smooth_surfaces_and_empty_frames_have_no_outline(frames):
    rng = np.random.default_rng(7)
    for field in (
        lambda x, y: 0.0 * x,
        frames.plane(0.5, (0.01, -0.02)),
        frames.sphere(40.0, 2.0, 1.0),
        frames.sphere(150.0),
        frames.cylinder(60.0, 0.4, 1.0),
        frames.cylinder(300.0, 1.0),
    ):
        for _ in range(5):
            image = frames(field, rng)
            assert not find_outline(image).lines
            assert not find_lines(image)


def test_an_outline_says_when_it_might_as_well_be_a_smooth_surface(frames):
    rng = np.random.default_rng(8)
    wall = find_outline(frames(times(frames.half(0.3, -2.0), frames.half(0.3, 2.0, -1)), rng))
    slot = find_outline(frames(without(frames.half(0.3, -2.0, -1), frames.half(0.3, 2.0)), rng))
    assert len(wall.lines) == len(slot.lines) == 2
    assert abs(wall.over_smooth) < 12.0
    assert slot.over_smooth > 100.0


def test_a_corner_that_is_cut_off_is_lines_though_an_arc_may_stand_for_it(frames):
    rng = np.random.default_rng(29)
    seen, off = 0, []
    for _ in range(16):
        turn, (x, y) = rng.uniform(-np.pi, np.pi), rng.uniform(-2.0, 2.0, 2)
        truths = []
        for more, cut in ((0.0, 0.0), (np.pi / 2, 0.0), (np.pi / 4, 4.0)):
            inward = np.array([-np.sin(turn + more), np.cos(turn + more)])
            truths.append((turn + more, inward @ (x, y) + cut, 1))
        lines = find_lines(frames(times(*(frames.half(*t) for t in truths)), rng))
        seen += len(lines) >= 2
        off += [np.abs(e).max() for e in errors(lines, truths)] if len(lines) == 3 else []
    assert seen >= 14
    assert len(off) >= 30
    assert max(off) < 4.5


def test_a_line_of_which_little_is_seen_is_laid_along_none_that_it_crosses():
    free = np.diag([0.01, 0.01, 0.01, 0.02, 0.1, 0.3, 1.0]) ** 2
    for apart in (0.02, 0.6):
        at = np.array([0.5, 0.0, 0.0, 0.4, 1.0, 0.4 + apart, -1.0])
        fit = RegionFit(Region((1.0, -1.0), TWO[0]), at, free, 150.0, 153, True, 3.0)
        laid = made_parallel(fit).parameters
        assert laid[5] - laid[3] == pytest.approx(0.0 if apart < 0.3 else apart)


def test_the_tip_of_a_corner_is_two_lines_though_a_dome_as_sharp_explains_it(frames):
    """No more than 15 of these were while any dome, however sharp, counted as a smooth surface."""
    rng = np.random.default_rng(0)
    found = 0
    for _ in range(40):
        tip, first = np.array([-2.0, 4.0]) + rng.uniform(-1, 1, 2), 1.51 + rng.uniform(-0.3, 0.3)
        sides = [
            frames.half(angle, tip @ [-np.sin(angle), np.cos(angle)], side)
            for angle, side in ((first, 1), (first + np.pi / 3, -1))
        ]
        found += len(find_lines(frames(times(*sides), rng))) == 2
    assert found > 18
