"""How far touches err is estimated with the pose of what they touched."""

import numpy as np
import pytest

from exploration.planning.touching.lone_touch import Approach, LoneTouch, joined
from models.csg import Cube, Cylinder
from models.library import Library
from models.solid import Solid
from models.symmetry import pose_error
from primitives.arrays import frozen
from primitives.evidence import Contacts
from primitives.pose import exp, pose, random_rotation, rotate, rotation_exp, transform_points
from recognition.identifying.exact import exact
from recognition.matching import Hypothesis, Prior

SIZE = np.array([60.0, 45.0, 30.0])
ENTRY = Library.of({"box": Solid.from_csg(Cube(tuple(SIZE)))})["box"]
CENTER = ENTRY.samples.points.min(axis=0) + SIZE / 2.0
PRIOR = Prior(np.zeros(3), 300.0)


def _touch(number, world, place, turn, rng):
    """Four contacts of one face, that share the error of their touch."""
    axis, way = number % 3, 1.0 if number % 2 else -1.0
    normal, across = way * np.eye(3)[axis], np.delete(np.eye(3), axis, axis=0)
    middle = CENTER + 0.5 * SIZE[axis] * normal + (rng.uniform(-0.3, 0.3, 2) * np.delete(SIZE, axis)) @ across
    tilt = rotation_exp(turn * rng.standard_normal(3))
    arms = np.concatenate([5.0 * across, -5.0 * across]) @ tilt.T
    points = middle + arms + place * rng.standard_normal() * normal
    normals = np.tile(tilt @ normal, (4, 1))
    felt = Contacts.of(transform_points(world, points), rotate(world, normals), 0.01, 0.002, touch=number)
    return LoneTouch(number, Approach(np.eye(4), 1.0), felt, (), joined([]), True, "a flat face", np.eye(4))


def _trial(seed, place, turn, many=8):
    rng = np.random.default_rng(seed)
    world = pose(random_rotation(rng), rng.uniform(-40.0, 40.0, 3))
    touches = [_touch(k, world, place, turn, rng) for k in range(many)]
    near = world @ exp(np.array([0.2, -0.2, 0.1, 0.004, -0.004, 0.002]))
    begun = Hypothesis("box", frozen(near), 0.0, frozen(0.01 * np.eye(6)), 0.0, frozen(np.zeros(1)))
    found = exact(begun, ENTRY, touches, PRIOR)
    error = pose_error(ENTRY.symmetry, found.hypothesis.pose, world)
    return found, error


@pytest.mark.parametrize(("place", "turn"), [(0.1, 0.0), (0.0, 0.01), (0.1, 0.01), (0.02, 0.001)])
def test_a_pose_is_off_by_what_it_states(place, turn):
    told = [_trial(seed, place, turn) for seed in range(30)]
    places = np.array([e.distance / f.hypothesis.translation_sigma for f, e in told])
    turns = np.array([e.angle / f.hypothesis.rotation_sigma for f, e in told])
    # of three normal coordinates that are known 95 % lie within 1.6 root mean squares, 14 % within a half
    assert (places < 1.6).mean() > 0.8
    assert (turns < 1.6).mean() > 0.8
    if place > 0.05 and turn > 0.005:
        assert (places < 0.5).mean() < 0.4
        assert (turns < 0.5).mean() < 0.4


def test_a_touch_that_turns_out_exact_makes_the_pose_surer():
    loose, sharp = (np.mean([_trial(s, *err)[0].hypothesis.rotation_sigma for s in range(10)])
                    for err in ((0.1, 0.02), (0.1, 0.001)))  # fmt: skip
    assert sharp < 0.5 * loose


def test_attitudes_that_are_exact_count_for_more_than_places_that_are_not():
    off = np.median([_trial(seed, 0.15, 0.0005)[1].angle for seed in range(30)])
    assert off < np.deg2rad(0.06)  # 0.1 mm of a lever of 50 mm is twice that


def test_few_touches_leave_the_guess_about_as_it_was():
    found, _ = _trial(0, 0.0, 0.0, many=3)
    assert found.place > 0.03
    assert found.turn > 0.002


def test_the_normal_of_a_round_face_is_not_as_exact_as_flat_faces_agree() -> None:
    """The only one round a shaft says where its axis is, and is off by 2 degrees."""
    entry = Library.of({"shaft": Solid.from_csg(Cylinder(25.0, 40.0))})["shaft"]
    touches = []
    for number, end in enumerate([1.0, -1.0, 1.0, -1.0]):
        at = np.array([[x, y, 20.0 * end] for x in (-5.0, 5.0) for y in (-5.0, 5.0)])
        felt = Contacts.of(at, np.tile([0.0, 0.0, end], (4, 1)), 0.01, 0.002, touch=number)
        touches.append(LoneTouch(number, Approach(np.eye(4), 1.0), felt, (), joined([]), True, "", np.eye(4)))
    off = np.array([[np.cos(0.035), np.sin(0.035), 0.0]])
    side = Contacts.of(np.array([[25.0, 0.0, 3.0]]), off, 0.01, 0.002, touch=4)
    touches.append(LoneTouch(4, Approach(np.eye(4), 1.0), side, (), joined([]), True, "", np.eye(4)))
    begun = Hypothesis("shaft", frozen(np.eye(4)), 0.0, frozen(0.01 * np.eye(6)), 0.0, frozen(np.zeros(1)))
    found = exact(begun, entry, touches, PRIOR)
    assert found is not None
    error = pose_error(entry.symmetry, found.hypothesis.pose, np.eye(4)).distance
    assert error < 2.5 * found.hypothesis.translation_sigma
