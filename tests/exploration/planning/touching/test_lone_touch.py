"""One touch on the simulated stage, against the object that it was made on."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exploration.devices.guard import Guard, GuardLimits
from exploration.devices.simulated import simulate
from exploration.planning.known.swept import rectangles
from exploration.planning.touching.lone_touch import Approach, touch_once
from exploration.planning.ways.travel import EDGE
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models import parts
from models.solid import Solid
from primitives import pose as se3


def _touch(
    part: str, place: list[float], toward: list[float], length: float = 80.0, away: float = 50.0, **limits
):  # type: ignore[no-untyped-def]
    solid, spec = Solid.from_csg(parts.build(part)), load_sensor("lts210")
    start = se3.pose(se3.frame_along(toward), np.array(place) - away * np.array(toward))
    stage, arrays = simulate(solid, [spec], np.random.default_rng(0), start_pose=start)
    guard = Guard(stage, arrays, [Calibration.nominal(spec)], GuardLimits(**limits))
    return solid, guard, touch_once(guard, Approach(start, length))


def test_a_touch_on_a_face_gives_its_plane_and_its_edge() -> None:
    solid, guard, touch = _touch("cube", [10.0, 0.0, 20.0], [0.0, 0.0, -1.0])
    assert touch.met
    assert guard.cost.touches == 1
    assert len(touch.contacts) >= 4
    assert np.abs(solid.signed_distance(touch.contacts.points)).max() < 0.05
    assert (touch.contacts.normals @ [0.0, 0.0, 1.0]).min() > np.cos(0.02)
    assert any(np.abs(edge.points[:, 0] - 20.0).max() < 0.3 for edge in touch.edges)


@pytest.mark.parametrize(
    ("place", "toward", "away"),
    [
        ([10.0, 0.0, 20.0], [0, 0, -1], 50.0),
        ([-18.0, 18.0, 20.0], [0, 0, -1], 50.0),
        ([0.0, 0.0, 20.0], [0, 0, -1], -1.2),  # pressed into it already
    ],
)
def test_what_a_touch_calls_free_holds_no_material(
    place: list[float], toward: list[float], away: float
) -> None:
    solid, _, touch = _touch("cube", place, toward, away=away)
    assert touch.met
    assert np.abs(solid.signed_distance(touch.contacts.points)).max() < 0.1
    rng = np.random.default_rng(1)
    for pose, half in zip(touch.free.poses, touch.free.half_extents, strict=True):
        inside = se3.transform_points(pose, rng.uniform(-1.0, 1.0, (300, 3)) * half)
        assert solid.signed_distance(inside).min() > -0.02
    assert len(touch.free.poses)


@pytest.mark.parametrize("room", [0.4, 2.2, 40.0])  # [mm] behind a pad that is pressed 1.2 mm deep
def test_no_zero_is_taken_under_load_where_the_travel_ends_behind_the_pad(room: float) -> None:
    reach = (-600.0, -600.0, -600.0, 600.0, 600.0, 18.8 + EDGE + room)
    solid, _, touch = _touch("cube", [0.0, 0.0, 20.0], [0, 0, -1], away=-1.2, length=3.0, reach=reach)
    assert touch.met
    assert np.abs(solid.signed_distance(touch.contacts.points)).max() < 0.1


def test_no_contact_is_told_where_a_hole_is() -> None:
    solid, _, touch = _touch("plate_with_hole", [6.0, 2.0, 5.0], [0.0, 0.0, -1.0])
    assert np.abs(solid.signed_distance(touch.contacts.points)).max() < 0.1
    assert len(touch.untouched)
    assert solid.signed_distance(touch.untouched).min() > 0.0


def test_a_touch_that_misses_says_that_its_way_is_free() -> None:
    _, _, touch = _touch("cube", [60.0, 0.0, 20.0], [0.0, 0.0, -1.0])
    assert not touch
    assert not len(touch.contacts)
    assert touch.free.contains(np.array([[60.0, 0.0, 0.0]]))[0]
    assert not touch.stopped


def test_an_approach_that_ends_early_and_felt_nothing_was_stopped() -> None:
    _, _, missed = _touch("cube", [60.0, 0.0, 20.0], [0.0, 0.0, -1.0])
    half_way = missed.approach.start @ se3.pose(translation=[0.0, 0.0, 0.5 * missed.approach.length])
    assert replace(missed, pose=half_way).stopped
    _, _, met = _touch("cube", [0.0, 0.0, 20.0], [0.0, 0.0, -1.0])
    assert met.met
    assert not met.stopped


@settings(max_examples=50, deadline=None)
@given(st.integers(0, 10_000))
def test_rectangles_fill_a_mask_and_nothing_else(seed: int) -> None:
    rng = np.random.default_rng(seed)
    mask = rng.uniform(size=(10, 16)) < rng.uniform()
    count = np.zeros(mask.shape, dtype=int)
    for top, bottom, left, right in rectangles(mask):
        count[top:bottom, left:right] += 1
    assert np.array_equal(count, mask.astype(int))
