import numpy as np
import pytest

from primitives.classify import RankOptions, rank, two_flats
from primitives.evidence import Contacts
from primitives.fit import fit
from primitives.shapes import Cone, Cylinder, Sphere, Torus


def test_the_shape_that_made_the_contacts_ranks_first(shape, touched):
    rng = np.random.default_rng(4)
    names = [rank(touched(shape, 30, rng, arc=2.0))[0].fit.kind for _ in range(15)]
    assert names.count(shape.kind) >= 14


def test_probabilities_sum_to_one_and_fall(shape, touched):
    ranked = rank(touched(shape, 30, np.random.default_rng(1)))
    chances = [one.probability for one in ranked]
    assert sum(chances) == pytest.approx(1.0)
    assert chances == sorted(chances, reverse=True)


def test_a_sphere_of_huge_radius_is_a_plane(touched):
    rng = np.random.default_rng(7)
    cap = Sphere([0, 0, -1500.0], 1500.0)
    xy = rng.uniform(-8, 8, (40, 2))
    points = cap.project(np.column_stack([xy, np.zeros(40)])) + rng.normal(size=(40, 3)) * [0, 0, 0.05]
    normals = cap.normals(points) + 0.03 * rng.standard_normal((40, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert rank(Contacts.of(points, normals, 0.05, 0.03))[0].fit.kind == "plane"


def test_a_cylinder_that_bends_by_less_than_an_array_can_tell_is_a_plane():
    rng, roll = np.random.default_rng(9), Cylinder([0, 0, -1200.0], [0, 1.0, 0], 1200.0)
    xy = rng.uniform(-12, 12, (40, 2))
    points = roll.project(np.column_stack([xy, np.zeros(40)])) + rng.normal(size=(40, 3)) * [0, 0, 0.002]
    contacts = Contacts.of(points, roll.normals(points), 0.002, 0.0005)
    assert rank(contacts)[0].fit.kind == "plane"
    assert rank(contacts, options=RankOptions(flattest=100.0))[0].fit.kind == "cylinder"


def test_few_contacts_on_a_small_cap_are_a_balls_and_not_a_nearly_flat_cones():
    rng, ball = np.random.default_rng(8), Sphere([0, 0, -36.0], 36.0)
    names = []
    for _ in range(40):
        turn, away = rng.uniform(0, 2 * np.pi, 6), rng.uniform(2.0, 5.5, 6)
        at = ball.project(np.column_stack([away * np.cos(turn), away * np.sin(turn), np.zeros(6)]))
        points = at + 0.02 * rng.standard_normal((6, 1)) * ball.normals(at)
        normals = ball.normals(at) + 0.03 * rng.standard_normal((6, 3))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        ranked = rank(Contacts.of(points, normals, 0.02, 0.03))
        names.append(ranked[0].fit.kind)
    assert names.count("cone") <= 2


def test_a_nearly_flat_cone_that_is_well_touched_is_a_cone(touched):
    dish = Cone([0, 0, 0.0], [0, 0, -1.0], 1.4)
    contacts = touched(dish, 60, np.random.default_rng(3))
    assert rank(contacts)[0].fit.kind == "cone"


def test_unmodeled_error_does_not_buy_parameters(shape, touched):
    rng = np.random.default_rng(9)
    contacts = touched(shape, 60, rng, sigma=0.15, turn=0.09)
    trusted = Contacts.of(contacts.points, contacts.normals, 0.05, 0.03)  # three times worse than it says
    assert rank(trusted)[0].fit.kind == shape.kind


def test_too_little_evidence_ranks_nothing():
    assert rank(Contacts.of([[0, 0, 0], [1, 0, 0.0]])) == ()


def test_two_round_ends_far_apart_make_no_ring():
    rng, ring = np.random.default_rng(4), Torus([0, 0, 0.0], [0, 0, 1.0], 40.0, 18.0)
    options = RankOptions(largest_torus=3.0, least_turn=0.5, least_arc=0.3)

    def felt(turns):
        tube = rng.uniform(-0.6, 0.6, len(turns))
        out = 40.0 + 18.0 * np.cos(tube)
        at = np.column_stack([out * np.cos(turns), out * np.sin(turns), 18.0 * np.sin(tube)])
        return Contacts.of(at, ring.normals(at), 0.02, 0.02)

    ends = np.concatenate([rng.uniform(-0.06, 0.06, 20) + k * np.pi for k in (0, 1)])
    assert "torus" not in [ranked.fit.kind for ranked in rank(felt(ends), options=options)]
    assert rank(felt(rng.uniform(-0.6, 0.6, 40)), options=options)[0].fit.kind == "torus"


def test_a_ball_that_is_hardly_wider_one_way_is_no_ring():
    rng, ring = np.random.default_rng(6), Torus([0, 0, 0.0], [0, 0, 1.0], 0.15, 40.0)
    polar, azimuth = rng.uniform(0.1, 0.8, 60), rng.uniform(-np.pi, np.pi, 60)
    out = 0.15 + 40.0 * np.sin(polar)
    at = np.column_stack([out * np.cos(azimuth), out * np.sin(azimuth), 40.0 * np.cos(polar)])
    contacts = Contacts.of(at, ring.normals(at), 0.002, 0.01)
    assert rank(contacts, options=RankOptions(least_ring=0.0))[0].fit.kind == "torus"
    assert rank(contacts)[0].fit.kind == "sphere"


def test_a_rounded_rim_that_every_touch_met_elsewhere_is_rarely_a_cone():
    """Flat above, a fillet of 2.5 mm below: how far round a touch came passes for a radius that grows."""
    rng, named = np.random.default_rng(3), []
    for _ in range(20):
        parts = []
        for number in range(7):
            middle, along = rng.uniform(-1.5, 2.5), rng.uniform(-50, 50)
            y = along + rng.uniform(-30, 30, 20)
            down = middle + rng.uniform(-1, 1, 20) + rng.uniform(-0.02, 0.02) * (y - along)
            down = np.clip(down, -2.5, 3.5)
            turn = np.clip(down, 0.0, None) / 2.5
            at = [2.5 * np.cos(turn), y, -np.minimum(down, 0.0) - 2.5 * np.sin(turn)]
            normals = np.column_stack([np.cos(turn), 0.0 * y, -np.sin(turn)])
            parts.append(Contacts.of(np.column_stack(at), normals, 0.06, 0.1, touch=number))
        named.append(rank(Contacts.concatenate(parts))[0].fit.kind)
    assert named.count("cone") <= 5


def cone_felt_along(turns, semi_angle, wide=0.0):
    """Contacts of a cone, 20 to 60 mm from its apex, along strips at some turns round its axis."""
    cone, rng = Cone(np.zeros(3), np.array([0, 0, 1.0]), semi_angle), np.random.default_rng(0)
    along, across = np.repeat(np.linspace(20.0, 60.0, 12), 3), np.tile([-wide / 2, 0.0, wide / 2], 12)
    lots = []
    for turn in turns:
        around = turn + across / (along * np.sin(semi_angle))
        lots.append(
            np.column_stack(
                [
                    along * np.sin(semi_angle) * np.cos(around),
                    along * np.sin(semi_angle) * np.sin(around),
                    along * np.cos(semi_angle),
                ]
            )
        )
    points = np.concatenate(lots)
    normals = cone.normals(points)
    points = points + 0.05 * rng.standard_normal((len(points), 1)) * normals
    return Contacts.of(points, normals, 0.05, 0.02, touch=np.repeat(np.arange(len(turns)), 36))


@pytest.mark.parametrize(("lines", "semi_angle"), [(3, 0.35), (3, 0.2), (4, 0.785), (4, 1.2)])
def test_a_cone_that_was_felt_along_three_lines_or_more_is_one(lines, semi_angle):
    touched = cone_felt_along(np.arange(lines) * 2.0 * np.pi / lines, semi_angle)
    assert rank(touched)[0].fit.kind == "cone"


@pytest.mark.parametrize(("counts", "strays"), [((40, 40), 0.0), ((20, 6), 0.0), ((40, 40), 0.15)])
def test_two_flat_sides_beside_a_corner_are_no_cone_and_nothing_else_that_is_far_off(counts, strays):
    """Some of their contacts a pad that lay half over the rim may have read to lean by 13 degrees."""
    rng = np.random.default_rng(1)
    sides = [(np.array([0, 1.0, 0]), np.array([1.0, 0, 0])), (np.array([1.0, 0, 0]), np.array([0, 1.0, 0]))]
    points = np.concatenate(
        [
            np.outer(rng.uniform(5.0, 60.0, count), way)
            + np.outer(rng.uniform(-1.5, 1.5, count), [0, 0, 1.0])
            for count, (way, _) in zip(counts, sides, strict=True)
        ]
    )
    normals = np.concatenate([np.tile(-sides[k][1], (counts[k], 1)) for k in (0, 1)])
    lean = np.where(rng.random(len(points)) < strays, 0.23, 0.0)
    normals = np.cos(lean)[:, None] * normals + np.outer(np.sin(lean), [0, 0, 1.0])
    unsure = 0.04 if strays else 0.1
    touched = Contacts.of(points + 0.02 * rng.standard_normal(points.shape), normals, 0.06, unsure)
    assert all(one.fit.kind != "cone" and one.fit.chi2 < 10 * one.fit.dof for one in rank(touched))


def test_of_two_flat_sides_the_one_that_was_felt_less_may_scatter_more():
    rng, sides = np.random.default_rng(3), []
    for count, along, out, scatter in (
        (72, [0, 1, 0], [-1, 0, 0], 0.015),
        (36, [1, 0, 0], [0, -1, 0], 0.045),
    ):
        places = np.outer(rng.uniform(5.0, 60.0, count), along)
        places[:, 2] = rng.uniform(-1.5, 1.5, count)
        normals = np.tile(np.array(out, dtype=float), (count, 1))
        sides.append(
            Contacts.of(places + scatter * rng.standard_normal((count, 1)) * normals, normals, 0.03, 0.1)
        )
    touched = Contacts.concatenate(sides)
    cone = fit("cone", touched)
    assert cone.rms < 0.045 / RankOptions().as_near
    assert two_flats(cone, touched, RankOptions())


@pytest.mark.parametrize("count", [4, 6])
def test_a_cylinder_that_few_contacts_on_two_lines_are_of_is_one(count):
    rng = np.random.default_rng(count)
    turn = np.repeat([0.0, np.pi], count) + 0.04 * rng.standard_normal(2 * count)
    ways = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(2 * count)])
    points = (10.0 + 0.03 * rng.standard_normal((2 * count, 1))) * ways
    points[:, 2] = rng.uniform(-15.0, 15.0, 2 * count)
    assert rank(Contacts.of(points, ways, 0.03, 0.05))[0].fit.kind == "cylinder"


def test_a_cone_of_nearly_a_right_angle_is_a_plane():
    flat = np.random.default_rng(2).uniform(-30.0, 30.0, (60, 2))
    height = 0.01 * np.linalg.norm(flat, axis=1)
    way = np.column_stack([-0.01 * flat / np.linalg.norm(flat, axis=1, keepdims=True), np.ones(60)])
    touched = Contacts.of(np.column_stack([flat, height]), way, 0.1, 0.02)
    assert rank(touched)[0].fit.kind == "plane"


def bare(contacts):
    return Contacts.of(contacts.points, None, contacts.sigma)


def on_two_sides(width, bend, sigma=0.02):
    """Contacts on opposite strips 50 mm apart, of a `width` [mm], each bent by `bend` [1/mm]."""
    rng = np.random.default_rng(0)
    along, across = rng.uniform(0.0, 60.0, (2, 40)), rng.uniform(-0.5, 0.5, (2, 40)) * width
    sides, normals = [], []
    for sign, x, y in zip((1.0, -1.0), along, across, strict=True):
        z = sign * (25.0 - 0.5 * bend * y**2) + sigma * rng.standard_normal(len(x))
        way = np.column_stack([0.0 * x, bend * y, np.ones(len(x))]) * [1.0, 1.0, sign]
        sides.append(np.column_stack([x, y, z]))
        normals.append(way / np.linalg.norm(way, axis=1, keepdims=True))
    return Contacts.of(np.concatenate(sides), np.concatenate(normals), sigma, 0.03)


def test_the_narrow_sides_of_a_plate_are_no_cylinder_and_strips_that_a_pad_lay_on_are():
    for felt in (on_two_sides(2.5, 0.0), bare(on_two_sides(2.5, 0.0))):
        assert all(found.fit.kind not in ("cylinder", "cone", "torus") for found in rank(felt))
    assert rank(on_two_sides(10.0, 1.0 / 25.0))[0].fit.kind == "cylinder"
