"""Round faces that were hardly touched, beside a plate that was felt well."""

import numpy as np
import pytest

from exploration.planning.faces.attribution import CONVEX
from exploration.planning.faces.uprighted import uprighted
from primitives.evidence import Contacts
from primitives.fit import fit
from primitives.patch_graph import Face, MergeOptions, PatchGraph, ranked_face
from primitives.shapes import Cone, Cylinder, Sphere

Z = np.eye(3)[2]


def plate(rng):
    points = np.column_stack([rng.uniform(-20, 20, (60, 2)), np.zeros(60)])
    return face(0, Contacts.of(points, np.tile(Z, (60, 1)), 0.02, 0.02))


def face(number, contacts):
    return ranked_face(number, contacts, MergeOptions())


def felt(shape, rng, count=12):
    """One touch of a pad: some 8 mm round, 1 mm along."""
    turn, up = rng.uniform(-0.25, 0.25, count), rng.uniform(-0.5, 0.5, count)
    at = shape.project(np.column_stack([18.0 * np.cos(turn), 18.0 * np.sin(turn), up]))
    normals = shape.normals(at) + 0.02 * rng.standard_normal((count, 3))
    points = at + 0.02 * rng.standard_normal((count, 1)) * shape.normals(at)
    return Contacts.of(points, normals / np.linalg.norm(normals, axis=1, keepdims=True), 0.02, 0.02)


@pytest.mark.parametrize("seed", range(5))
def test_a_round_end_that_was_touched_once_stands_upright_on_its_plate(seed):
    rng = np.random.default_rng(seed)
    graph = PatchGraph((plate(rng), face(1, felt(Cylinder([0, 0, 0.0], Z, 18.0), rng))), ())
    end = uprighted(graph).faces[1].fit
    assert end.kind == "cylinder"
    assert abs(end.shape.direction @ Z) > 0.9999
    assert end.shape.radius == pytest.approx(18.0, abs=3.0)


def test_what_leans_for_sure_stays_as_it_was_fitted():
    rng = np.random.default_rng(1)
    leaning = face(1, felt(Cone([0, 0, -60.0], Z, 0.29), rng, 25))
    graph = PatchGraph((plate(rng), leaning), ())
    assert uprighted(graph).faces[1] is leaning


def band(rng, lean, high, count=48):
    """Of the rim of a flange of radius 24, all round, by cylinders that lean."""
    leaning = Cylinder([0, 0, 0.0], np.array([np.sin(lean), 0.0, np.cos(lean)]), 24.0)
    turn, up = np.linspace(0.0, 6.0, count), rng.uniform(0.0, high, count)
    at = leaning.project(np.column_stack([24.0 * np.cos(turn), 24.0 * np.sin(turn), up]))
    return Contacts.of(at, leaning.normals(at), 0.05, 0.1)


def test_a_narrow_band_of_many_contacts_stands_upright_where_a_long_one_tells_its_lean():
    rng = np.random.default_rng(2)
    narrow, long = face(1, band(rng, 0.03, 3.0)), face(1, band(rng, 0.03, 40.0))
    assert abs(narrow.fit.shape.direction @ Z) < 0.9998
    (_, upright), (_, kept) = (uprighted(PatchGraph((plate(rng), own), ())).faces for own in (narrow, long))
    assert abs(upright.fit.shape.direction @ Z) > 0.9999
    assert kept is long


def zone(rng, high):
    """Two touches of a ball of radius 24, to both sides of its equator."""
    ball = Sphere([0, 0, 0.0], 24.0)
    turn, up = (
        np.concatenate([rng.uniform(0, 0.5, 12), rng.uniform(3, 3.5, 12)]),
        rng.uniform(-high, high, 24),
    )
    at = ball.project(np.column_stack([24.0 * np.cos(turn), 24.0 * np.sin(turn), up]))
    return face(1, Contacts.of(at, ball.normals(at), 0.02, 0.03))


def test_the_low_rim_of_a_flange_is_no_sphere_though_the_skin_bends_over_both_its_edges():
    rng = np.random.default_rng(4)
    low, high = zone(rng, 2.0), zone(rng, 6.0)
    assert low.fit.kind == high.fit.kind == "sphere"
    end = uprighted(PatchGraph((plate(rng), low), ())).faces[1].fit
    assert end.kind == "cylinder"
    assert end.shape.radius == pytest.approx(24.0, abs=0.1)
    assert uprighted(PatchGraph((plate(rng), high), ())).faces[1] is high


def test_a_low_rim_of_many_contacts_that_fit_a_ball_better_stands_upright():
    """Of a plate of radius 40, 4 mm of its side: the skin bends it by some hundredths of a millimeter."""
    rng = np.random.default_rng(4)
    turn, up = rng.uniform(0.0, 4.0, 52), rng.uniform(-2.0, 2.0, 52)
    bend = np.cos(turn), np.sin(turn), 0.015 * up
    normals = np.column_stack(bend) / np.linalg.norm(np.column_stack(bend), axis=1, keepdims=True)
    out = 40.0 - 0.01 * up**2 + 0.02 * rng.standard_normal(52)
    points = np.column_stack([out * np.cos(turn), out * np.sin(turn), up])
    contacts = Contacts.of(points, normals, 0.04, 0.03)
    ball = Face(1, fit("sphere", contacts), contacts)
    low = uprighted(PatchGraph((plate(rng), ball), ())).faces[1].fit
    assert low.kind == "cylinder"
    assert low.shape.radius == pytest.approx(40.0, abs=0.05)


def test_a_dome_of_many_contacts_stays_one():
    rng, ball = np.random.default_rng(5), Sphere([0, 0, 0.0], 40.0)
    turn, up = rng.uniform(0.0, 4.0, 52), rng.uniform(5.0, 30.0, 52)
    away = np.column_stack(
        [np.sqrt(1600.0 - up**2) * np.cos(turn), np.sqrt(1600.0 - up**2) * np.sin(turn), up]
    )
    dome = face(1, Contacts.of(away, ball.normals(away), 0.03, 0.03))
    assert dome.fit.kind == "sphere"
    assert uprighted(PatchGraph((plate(rng), dome), ())).faces[1] is dome


def test_the_rim_of_a_plate_is_a_cylinder_where_it_ends_at_both_its_flats():
    rng = np.random.default_rng(6)
    ball = Sphere([0, 0, 4.0], 44.0)
    turn, up = np.linspace(0.0, 5.0, 90), rng.uniform(0.1, 7.9, 90)
    at = ball.project(np.column_stack([44.0 * np.cos(turn), 44.0 * np.sin(turn), up]))
    rim = face(1, Contacts.of(at, ball.normals(at), 0.02, 0.03))
    below, above = plate(rng), face(2, Contacts.of(plate(rng).contacts.points + 8.0 * Z, np.tile(Z, (60, 1))))
    assert uprighted(PatchGraph((below, rim), ())).faces[1] is rim
    (_, own, _) = uprighted(PatchGraph((below, rim, above), ())).faces
    assert own.fit.kind == "cylinder"
    assert abs(own.fit.shape.direction @ Z) > 0.9999
    assert own.fit.shape.radius == pytest.approx(44.0, abs=0.2)


def sliver(rng, middle):
    """Of a ball of radius 26 whose equator is 2 mm over the plate: a band of 1.6 mm, and one contact beside it."""
    ball = Sphere([0, 0, 2.0], 26.0)
    turn, up = np.linspace(0.0, 5.0, 30), np.append(rng.uniform(middle - 0.8, middle + 0.8, 29), 9.0)
    away = np.sqrt(26.0**2 - (up - 2.0) ** 2)
    at = np.column_stack([away * np.cos(turn), away * np.sin(turn), up])
    contacts = Contacts.of(at, ball.normals(at), 0.02, 0.03)
    return Face(1, fit("sphere", contacts), contacts)


def test_a_sliver_of_a_rim_beside_one_flat_is_a_cylinder_where_it_looks_straight_out():
    rng = np.random.default_rng(8)
    rim, dome = sliver(rng, 1.4), sliver(rng, 20.0)
    own = uprighted(PatchGraph((plate(rng), rim), ())).faces[1].fit
    assert own.kind == "cylinder"
    assert own.shape.radius == pytest.approx(26.0, abs=0.1)
    assert own.inliers.sum() == 29  # what lies beside the rim is none of it
    assert uprighted(PatchGraph((plate(rng), dome), ())).faces[1] is dome


@pytest.mark.filterwarnings("error")
def test_two_bands_apart_of_a_ball_are_no_sliver_though_their_median_lies_between_them():
    rng, ball = np.random.default_rng(9), Sphere([0, 0, 2.0], 26.0)
    turn, up = np.linspace(0.0, 5.0, 12), np.repeat([-2.0, 6.0], 6)
    away = np.sqrt(26.0**2 - (up - 2.0) ** 2)
    at = np.column_stack([away * np.cos(turn), away * np.sin(turn), up])
    contacts = Contacts.of(at, ball.normals(at), 0.02, 0.03)
    bands = Face(1, fit("sphere", contacts), contacts)
    assert uprighted(PatchGraph((plate(rng), bands), ())).faces[1] is bands


ROCKED = np.array(
    [  # along, out and up of a plate's side 4.5 mm high, its normal out and up: a pad leaned, and felt the edge
        [-4.43, 0.035, 2.604, 0.999, 0.054],
        [-0.43, 0.046, 2.651, 0.997, 0.083],
        [0.03, 0.049, 2.635, 0.997, 0.083],
        [1.14, -0.022, 2.924, 0.999, 0.032],
        [-7.29, -0.001, 2.280, 0.999, 0.032],
        [1.15, 0.014, 1.810, 0.999, 0.032],
        [-4.64, 0.009, 1.963, 0.999, 0.032],
        [0.15, 0.029, 2.906, 0.991, 0.131],
        [0.05, -0.148, 4.034, 0.928, 0.372],
    ]
)


def rocked(lean=None):
    """Contacts of that side; or of one that is rounded, whose normals `lean` as they do there."""
    along, out, up, level, upward = ROCKED.T
    if lean is not None:
        out, level, upward = -(1.0 - np.cos(lean)) * (up[-1] - up[0]) / lean[-1], np.cos(lean), np.sin(lean)
    points, normals = np.column_stack([along, 39.0 + out, up - 4.5]), np.column_stack([0 * up, level, upward])
    sure = np.arange(9) == 0
    sigma, tilt = np.where(sure, 0.013, 0.06), np.where(sure, 0.006, 0.1)
    return Contacts.of(points, normals, sigma, tilt, touch=np.where(sure, 17, 19))


def test_a_narrow_side_that_a_pad_rocked_on_is_flat():
    rng = np.random.default_rng(0)
    side = ranked_face(1, rocked(), CONVEX)
    assert side.fit.kind == "cylinder"
    end = uprighted(PatchGraph((plate(rng), side), ())).faces[1].fit
    assert end.kind == "plane"
    assert abs(end.shape.direction @ Z) < 0.02


def test_a_side_that_is_rounded_for_sure_stays_round():
    rng = np.random.default_rng(0)
    side = ranked_face(1, rocked(np.linspace(0.0, 1.0, 9)), CONVEX)
    assert side.fit.kind != "plane"
    assert uprighted(PatchGraph((plate(rng), side), ())).faces[1].fit.kind != "plane"
