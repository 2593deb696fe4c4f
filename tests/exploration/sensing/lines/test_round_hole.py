"""Round holes from looks at their rims."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter
from scipy.special import ndtr

from exploration.sensing.frame import TactileImage, TaxelArray
from exploration.sensing.lines.blurred_disc import of_disc
from exploration.sensing.lines.round_hole import RoundHoleConfig, _Look, _without_strays, fit_round_hole
from exploration.sensing.response import rubber
from primitives import pose as se3
from primitives.shapes import Plane

UP = np.array([0.0, 0.0, 1.0])
PAD = TaxelArray("pad", 10, 16, (1.8, 1.8))
SPREAD, NOISE = 1.2, 0.01


def over(center, radius, pose, rng, outer=np.inf):
    """A frame of a pad on a face with a hole, by the disc's own blur."""
    width = rubber(SPREAD, PAD.pitch).mean_width
    x, y = np.meshgrid(PAD.x, PAD.y)
    places = se3.transform_points(pose, np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3))
    away = np.linalg.norm(places[:, :2] - center, axis=1).reshape(x.shape)
    face = 1.0 if np.isinf(outer) else of_disc(np.linalg.norm(places[:, :2], axis=1) / width, outer / width)
    face = np.broadcast_to(face, places.shape[:1]).reshape(x.shape)
    depth = (0.5 + 0.004 * x) * (face - of_disc(away / width, radius / width))
    noisy = depth + NOISE * rng.standard_normal(depth.shape)
    return TactileImage(PAD, noisy, np.full(depth.shape, NOISE), SPREAD, 0.1, 0.0), pose


def test_one_circle_explains_looks_from_several_places():
    rng = np.random.default_rng(3)
    down = np.diag([1.0, -1.0, -1.0])
    for radius, places in ((4.0, [(1.0, 0.5)]), (15.0, [(16.0, 0.0), (-16.0, 1.0), (0.0, 16.0)])):
        frames = [over([0.3, -0.2], radius, se3.pose(down, [*at, 0.0]), rng) for at in places]
        found = fit_round_hole(frames, np.zeros(3), UP, radius + 1.0)
        assert found is not None
        assert np.linalg.norm(found.center[:2] - [0.3, -0.2]) < 0.1
        assert abs(found.radius - radius) < max(4.0 * found.sigma, 0.05)


def test_a_hole_thought_narrower_than_the_skin_can_see_is_measured_all_the_same():
    frame = over([0.2, 0.1], 2.6, se3.pose(np.diag([1.0, -1.0, -1.0])), np.random.default_rng(3))
    found = fit_round_hole([frame], np.zeros(3), UP, 0.8)
    assert found is not None
    assert abs(found.radius - 2.6) < max(4.0 * found.sigma, 0.1)


def test_the_bore_of_a_ring_is_seen_on_three_millimeters_of_face():
    rng, down = np.random.default_rng(3), np.diag([1.0, -1.0, -1.0])
    places = [(15.0, 0.0), (-15.0, 0.0), (0.0, 15.0), (0.0, -15.0)]
    frames = [over([0.1, -0.1], 13.4, se3.pose(down, [*at, 0.0]), rng, 16.5) for at in places]
    found = fit_round_hole(frames, np.zeros(3), UP, 11.7, 16.5)
    assert found is not None
    assert abs(found.radius - 13.4) < max(4.0 * found.sigma, 0.05)
    assert np.linalg.norm(found.center[:2] - [0.1, -0.1]) < 0.1
    assert np.abs(found.face[:, 2] - 0.5).max() < 0.1
    away = np.linalg.norm(found.face[:, :2], axis=1)
    assert len(away) > 20
    assert 13.0 < away.min() < away.max() < 17.0
    blind = fit_round_hole(frames, np.zeros(3), UP, 11.7)
    assert blind is None or abs(blind.radius - 13.4) < 4.0 * blind.sigma


def test_no_hole_reaches_to_the_circle_that_its_face_ends_at():
    """What is missing of an image there is no hole of the face, however well a circle explains it."""
    rng, down = np.random.default_rng(3), np.diag([1.0, -1.0, -1.0])
    frames = [over([1.6, 0.2], 10.2, se3.pose(down, [x, 0.0, 0.0]), rng, 12.0) for x in (-12.0, 12.0)]
    assert fit_round_hole(frames, np.zeros(3), UP, 9.0) is not None
    assert fit_round_hole(frames, np.zeros(3), UP, 9.0, 12.0) is None


def leaning_on_a_ring(center, radius, outer, pose, lean, rng):
    """A frame of a pad that leans on a ring: what presses, blurred on a fine grid."""
    fine, width = 0.1, rubber(SPREAD, PAD.pitch).mean_width
    x, y = np.meshgrid(*(np.arange(a.min() - 8.0, a.max() + 8.0, fine) for a in (PAD.x, PAD.y)))
    places = se3.transform_points(pose, np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3))[:, :2]
    inside = np.linalg.norm(places - center, axis=1) > radius
    on = (inside & (np.linalg.norm(places, axis=1) < outer)).reshape(x.shape)
    seen = gaussian_filter((0.5 + lean[0] * x + lean[1] * y) * on, width / fine)
    rows, columns = (np.rint((a - grid.min()) / fine).astype(int) for a, grid in ((PAD.y, y), (PAD.x, x)))
    depth = seen[np.ix_(rows, columns)]
    noisy = depth + NOISE * rng.standard_normal(depth.shape)
    return TactileImage(PAD, noisy, np.full(depth.shape, NOISE), SPREAD, 0.1, 0.0), pose


def test_a_pad_that_leans_on_a_narrow_ring_measures_its_bore_no_less():
    rng, down = np.random.default_rng(3), np.diag([1.0, -1.0, -1.0])
    places = [(28.0, 0.0), (-28.0, 0.0), (0.0, 28.0), (0.0, -28.0)]
    for lean in (-0.06, 0.06):
        frames = [
            leaning_on_a_ring([0.0, 0.0], 26.5, 30.0, se3.pose(down, [x, y, 0.0]),
                              lean * np.array([x, -y]) / 28.0, rng)
            for x, y in places
        ]  # fmt: skip
        found = fit_round_hole(frames, np.zeros(3), UP, 27.0, 30.0)
        assert found is not None
        assert abs(found.radius - 26.5) < 0.06


def blurred_box(places, low, high, width):
    """The share of the skin's blur that a rectangle holds, at (n, 2) places."""
    ends = [ndtr((np.asarray(end) - places) / width) for end in (high, low)]
    return np.prod(ends[0] - ends[1], axis=1)


def over_missing(missing, pose, rng):
    """A frame of a pad on a face, of which a share is `missing` at (n, 2) places."""
    x, y = np.meshgrid(PAD.x, PAD.y)
    places = se3.transform_points(pose, np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3))
    depth = 0.5 * (1.0 - missing(places[:, :2])).reshape(x.shape) + NOISE * rng.standard_normal(x.shape)
    return TactileImage(PAD, depth, np.full(depth.shape, NOISE), SPREAD, 0.1, 0.0), pose


def test_a_keyway_leaves_a_bore_round_and_a_square_or_hexagonal_hole_is_not_round():
    width = rubber(SPREAD, PAD.pitch).mean_width

    def keyed(places):
        bore = of_disc(np.linalg.norm(places, axis=1) / width, 9.0 / width)
        return np.maximum(bore, blurred_box(places, [0.0, -3.0], [12.0, 3.0], width))

    def square(places):
        return blurred_box(places, [-8.0, -8.0], [8.0, 8.0], width)

    def hexagon(places):
        turns = np.arange(6) * np.pi / 3.0
        return np.prod([ndtr((17.5 - places @ [np.cos(t), np.sin(t)]) / width) for t in turns], axis=0)

    rng, down = np.random.default_rng(3), np.diag([1.0, -1.0, -1.0])
    poses = [se3.pose(down, [*at, 0.0]) for at in ((7.0, 7.0), (-7.0, 7.0), (7.0, -7.0), (-7.0, -7.0))]
    bored, cut = ([over_missing(hole, pose, rng) for pose in poses] for hole in (keyed, square))
    wide = [se3.pose(down, [*at, 0.0]) for at in ((19.0, 0.0), (-19.0, 0.0), (0.0, 19.0), (0.0, -19.0))]
    hex_cut = [over_missing(hexagon, pose, rng) for pose in wide]
    found = fit_round_hole(bored, np.zeros(3), UP, 8.4)
    assert found is not None
    assert abs(found.radius - 9.0) < 0.15
    assert np.linalg.norm(found.center[:2]) < 0.15
    assert fit_round_hole(cut, np.zeros(3), UP, 9.0) is None
    assert fit_round_hole(hex_cut, np.zeros(3), UP, 18.0) is None


def test_a_hole_is_seen_beside_the_edges_of_its_face():
    width = rubber(SPREAD, PAD.pitch).mean_width

    def cornered(places):
        """A hole of radius 5.6 that leaves 0.8 mm of material to two edges, past which nothing is."""
        face = ndtr((6.4 - places[:, 0]) / width) * ndtr((6.4 + places[:, 1]) / width)
        return 1.0 - face + of_disc(np.linalg.norm(places, axis=1) / width, 5.6 / width)

    rng, down = np.random.default_rng(3), np.diag([1.0, -1.0, -1.0])
    frames = [over_missing(cornered, se3.pose(down, [-4.0, 3.0, 0.0]), rng)]
    ends = [(Plane([6.4, 0.0, 0.0], np.eye(3)[0]), 1.0), (Plane([0.0, -6.4, 0.0], np.eye(3)[1]), -1.0)]
    found = fit_round_hole(frames, np.array([0.5, 0.4, 0.0]), UP, 5.0, ends=ends)
    assert found is not None
    assert abs(found.radius - 5.6) < max(4.0 * found.sigma, 0.05)
    assert np.linalg.norm(found.center[:2]) < 0.1
    blind = fit_round_hole(frames, np.array([0.5, 0.4, 0.0]), UP, 5.0)
    assert blind is None or abs(blind.radius - 5.6) > 0.1 or np.linalg.norm(blind.center[:2]) > 0.1


def test_a_gap_in_a_band_is_no_hole_and_a_hole_that_the_band_has_room_for_is():
    """Of a gap nothing but its two sides shows, as of a hole as wide as the band."""
    width = rubber(SPREAD, PAD.pitch).mean_width

    def band(half, missing):
        return lambda at: (
            1.0 - (ndtr((half - at[:, 1]) / width) - ndtr((-half - at[:, 1]) / width)) * (1.0 - missing(at))
        )

    rng, down = np.random.default_rng(3), np.diag([1.0, -1.0, -1.0])
    for half, missing, radius in (
        (3.0, lambda at: ndtr((2.6 - at[:, 0]) / width) - ndtr((-2.6 - at[:, 0]) / width), None),
        (5.5, lambda at: of_disc(np.linalg.norm(at, axis=1) / width, 3.0 / width), 3.0),
    ):
        frames = [over_missing(band(half, missing), se3.pose(down, [0.3, 0.0, 0.0]), rng)]
        side = np.array([0.0, half, 0.0])
        ends = [(Plane(side, np.eye(3)[1]), 1.0), (Plane(-side, np.eye(3)[1]), -1.0)]
        found = fit_round_hole(frames, np.zeros(3), UP, 3.0, ends=ends)
        assert (found is None) == (radius is None)
        assert radius is None or abs(found.radius - radius) < max(4.0 * found.sigma, 0.05)


def test_a_hole_near_an_edge_that_nobody_knows_of_is_measured_by_what_is_at_its_rim():
    """A knuckle's end; and past the edges that are told the face may go on, as where a plate begins."""
    rng = np.random.default_rng(3)
    down = np.diag([1.0, -1.0, -1.0])
    frames = [over(np.zeros(2), 4.0, se3.pose(down, [x, 0.0, 0.0]), rng, 8.5) for x in (-1.0, 1.0, 2.0)]
    told = [(Plane(np.array([0.0, 6.0, 0.0]), np.array([0.0, 1.0, 0.0])), 1.0)]
    for ends in ((), told):
        found = fit_round_hole(frames, np.array([0.3, 0.2, 0.0]), UP, 3.4, ends=ends)
        assert found is not None
        assert found.radius == pytest.approx(4.0, abs=0.12)
        assert np.linalg.norm(found.center) < 0.15


def test_a_face_without_a_hole_shows_none():
    flat = over([0.0, 0.0], 1e-3, np.diag([1.0, -1.0, -1.0, 1.0]), np.random.default_rng(3))
    assert fit_round_hole([flat], np.zeros(3), UP, 4.0) is None


def test_taxels_off_a_circle_are_left_out_on_one_side_of_it_and_not_all_round():
    turn = np.arange(120) * np.pi / 60.0
    ring = 9.0 * np.column_stack([np.cos(turn), np.sin(turn)])
    ones, rows = np.ones(120), np.ones((120, 3))
    look = _Look(ring, rows, ones, ones, 1.2, ones, np.zeros((120, 2)), np.eye(2), np.eye(4), ones[:2])
    keyway, corners = np.abs(turn - np.pi) < 0.4, np.cos(6.0 * turn) > 0.7

    def kept(strays):
        return _without_strays([look], np.zeros(2), 9.0 * strays, np.ones(120), RoundHoleConfig())

    (rest,) = kept(keyway)
    assert len(rest.flat) == int((~keyway).sum())
    assert corners.mean() < 1.0 - RoundHoleConfig().round
    assert kept(corners) == []
    assert kept(np.zeros(120, dtype=bool)) == []
