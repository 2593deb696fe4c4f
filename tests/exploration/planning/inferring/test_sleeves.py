"""A tube's bore narrows where its outside does."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.planning.inferring.sleeves import narrowing
from exploration.planning.inferring.stepped_holes import BY_OUTSIDE, BY_SLOPE, BY_TOUCH, stepped_holes
from exploration.planning.open.round_rims import RoundRim
from exploration.planning.touching.findings import Stopped
from primitives.evidence import Contacts
from primitives.fit import Fit, fit
from primitives.patch_graph import Face, MergeOptions, ranked_face
from primitives.shapes import Cone, Cylinder

UP = np.array([0.0, 0.0, 1.0])
MOUTH = RoundRim(np.array([3.0, 1.0, 85.0]), UP, 27.0, 0.02, 0, measured=True)
FOOT = RoundRim(np.array([3.0, 1.0, 0.0]), -UP, 18.0, 0.02, 1, measured=True)
DROP = np.arctan2(10.0, 20.0)


def turned(number: int, shape: Cylinder | Cone, low: float, high: float) -> Face:
    rng = np.random.default_rng(number)
    turn, level = rng.uniform(0, 6.28, 80), rng.uniform(low, high, 80)
    away = 30.0 * np.column_stack([np.cos(turn), np.sin(turn)])
    points = shape.project(np.column_stack([3.0 + away[:, 0], 1.0 + away[:, 1], level]))
    return ranked_face(number, Contacts.of(points, shape.normals(points), 0.01, 0.01), MergeOptions())


@pytest.fixture(scope="module")
def outside() -> list[Face]:
    """34 mm wide at the mouth, 24 mm below, a cone from 55 mm down to 35 mm between."""
    wide = turned(3, Cylinder([3.0, 1.0, 0.0], UP, 34.0), 56.0, 84.0)
    thin = turned(4, Cylinder([3.0, 1.0, 0.0], UP, 24.0), 1.0, 34.0)
    between = turned(5, Cone([3.0, 1.0, -13.0], UP, DROP), 37.0, 53.0)
    assert isinstance(between.fit, Fit)
    assert between.fit.kind == "cone"
    return [wide, thin, between]


def test_the_bore_narrows_between_the_same_depths(outside: list[Face]) -> None:
    assert narrowing(MOUTH, FOOT, outside) == pytest.approx((30.0, 50.0), abs=0.3)
    (step,) = stepped_holes([MOUTH, FOOT], faces=outside)
    assert step.why == BY_OUTSIDE
    mouth, narrow = step.holes
    assert (mouth.radius, mouth.depth) == pytest.approx((27.0, 30.0), abs=0.3)
    assert (narrow.radius, narrow.depth) == pytest.approx((18.0, 35.0), abs=0.3)
    cone = fit("cone", step.contacts)
    assert isinstance(cone, Fit)
    assert not cone.convex
    away = np.hypot(*(step.contacts.points[:, :2] - [3.0, 1.0]).T)
    assert away == pytest.approx(27.0 - 9.0 * (55.0 - step.contacts.points[:, 2]) / 20.0, abs=0.1)


def test_a_cone_from_end_to_end_has_a_bore_that_is_one(outside: list[Face]) -> None:
    cone = turned(6, Cone([3.0, 1.0, -170.0], UP, np.arctan2(34.0, 255.0)), 2.0, 83.0)
    (step,) = stepped_holes([MOUTH, FOOT], faces=[cone])
    assert (step.why, step.holes) == (BY_OUTSIDE, ())


def test_no_outside_that_narrows_so_tells_nothing(outside: list[Face]) -> None:
    assert narrowing(MOUTH, FOOT, outside[:2]) is None
    assert narrowing(MOUTH, replace(FOOT, radius=8.0), outside) is None  # its wall is thicker there
    assert narrowing(replace(MOUTH, center=MOUTH.center + np.array([5.0, 0.0, 0.0])), FOOT, outside) is None
    down = turned(7, Cone([3.0, 1.0, 98.0], -UP, DROP), 37.0, 53.0)
    assert narrowing(MOUTH, FOOT, [*outside[:2], down]) is None


def test_what_was_felt_in_it_goes_before(outside: list[Face]) -> None:
    ledge = [Stopped(MOUTH.center, 20.0, 40.1), Stopped(MOUTH.center, 22.6, 39.9)]
    assert stepped_holes([MOUTH, FOOT], stopped=ledge, faces=outside)[0].why == BY_TOUCH
    slope = [Stopped(MOUTH.center, 20.0, 8.0), Stopped(MOUTH.center, 24.0, 3.5)]
    assert stepped_holes([MOUTH, FOOT], stopped=slope, faces=outside)[0].why == BY_SLOPE
    scraped = [
        Stopped(MOUTH.center, 26.0, 30.0),
        Stopped(MOUTH.center, 24.0, 40.0),
    ]  # of no cone from the mouth
    assert stepped_holes([MOUTH, FOOT], stopped=scraped, faces=outside)[0].why == BY_OUTSIDE


def test_stops_on_the_outside_s_cone_are_of_it(outside: list[Face]) -> None:
    on_it = [Stopped(MOUTH.center, 25.0, 34.4), Stopped(MOUTH.center, 21.0, 43.3)]
    assert stepped_holes([MOUTH, FOOT], stopped=on_it, faces=outside)[0].why == BY_OUTSIDE
    assert stepped_holes([MOUTH, FOOT], stopped=on_it[:1], faces=outside)[0].why == BY_OUTSIDE
    off = [Stopped(MOUTH.center, 22.5, 60.0)]
    assert stepped_holes([MOUTH, FOOT], stopped=off, faces=outside)[0].why == BY_TOUCH


def test_a_chamfer_at_the_foot_narrows_no_bore() -> None:
    top, foot = replace(MOUTH, center=np.array([3.0, 1.0, 30.0]), radius=9.0), replace(FOOT, radius=5.5)
    body = turned(3, Cylinder([3.0, 1.0, 0.0], UP, 15.0), 3.0, 29.0)
    chamfer = turned(4, Cone([3.0, 1.0, -13.0], UP, np.pi / 4), 0.2, 1.8)
    assert narrowing(top, foot, [body, chamfer]) is None


def test_a_thick_wall_and_an_axis_a_little_off_are_no_hindrance(outside: list[Face]) -> None:
    assert narrowing(replace(MOUTH, radius=20.0), replace(FOOT, radius=11.0), outside) == pytest.approx(
        (30.0, 50.0), abs=0.3
    )
    lean = np.array([0.004, 0.0, 1.0])
    taper = turned(6, Cone([3.0 - 0.004 * 850.0, 1.0, -807.5], lean / np.linalg.norm(lean), 0.04), 2.0, 83.0)
    assert narrowing(replace(MOUTH, radius=30.0), replace(FOOT, radius=26.7), [taper]) is not None
