import numpy as np
import pytest

from primitives.classify import RankOptions, rank
from primitives.evidence import Contacts
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
