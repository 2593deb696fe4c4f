"""One touch, or many at one place or on one face, says little of the name: loose poses have the room of a face."""

from dataclasses import replace

import numpy as np
import pytest

from models import parts
from models.csg import Cube, Cylinder, Sphere
from models.library import Library
from models.solid import Solid
from primitives.evidence import Contacts
from primitives.pose import inverse, pose
from recognition.matching import Evidence, match
from recognition.matching.belief import Hypothesis
from recognition.matching.room import Lone, log_room
from recognition.matching.span import log_copies, same, spread_of
from recognition.matching.target import target_of

BLOCKS = {"long": Cube((160.0, 30.0, 20.0)), "cube": Cube((50.0, 50.0, 50.0)), "ball": Sphere(30.0),
          "step": Cube((90.0, 50.0, 20.0)) | Cube((30.0, 50.0, 30.0)).at(25.0, 0.0, 25.0)}  # fmt: skip


@pytest.fixture(scope="module")
def library() -> Library:
    return Library.of({name: Solid.from_csg(body, 0.02) for name, body in BLOCKS.items()})


@pytest.mark.parametrize(("many", "alike"), [(1, 1.7), (20, 8.0)])
def test_one_place_is_as_likely_on_each_object(library: Library, many: int, alike: float) -> None:
    for normal in ([0.0, 0.0, 1.0], [0.6, 0.8, 0.0], [-0.48, 0.6, 0.64]):
        contacts = Contacts.of([[1.0, 2.0, 3.0]] * many, [normal] * many, 0.3, 0.04)
        told = match(Evidence(contacts), library, unknown=0.0).probabilities
        assert max(told.values()) < alike * min(told.values())


def test_a_face_felt_all_over_is_about_as_likely_as_as_much_of_a_larger_one() -> None:
    known = Library.of({"small": Solid.from_csg(Cube((60.0, 60.0, 90.0))),
                        "large": Solid.from_csg(Cube((120.0, 100.0, 11.0)))})  # fmt: skip
    points = np.column_stack([np.random.default_rng(0).uniform(-29.0, 29.0, (30, 2)), np.zeros(30)])
    told = match(
        Evidence(Contacts.of(points, np.tile([0.0, 0.0, 1.0], (30, 1)), 0.3, 0.04)), known, unknown=0.0
    )
    assert min(told.probabilities.values()) > 0.2


def test_the_room_of_a_contact_on_a_plate_is_its_face(library: Library) -> None:
    entry, target = library["long"], target_of(library["long"])
    normal = np.array([0.0, 0.0, 1.0])
    level = np.zeros((6, 6))  # of a contact in the middle of the top: its height, and both tilts
    level[2, 2], level[3, 3], level[4, 4] = 1e2, 1e4, 1e4
    covariance, log_volume = spread_of(level, np.eye(4)[:3], np.zeros((1, 3)), entry, target)
    lone = Lone(np.array([0.0, 0.0, 10.0]), normal, True, 0.1, 0.01)
    narrow = 1.5 * np.log(2.0 * np.pi) - 0.5 * np.log(1e2 * 1e4 * 1e4)
    room = np.exp(log_volume + log_room(np.eye(4)[:3], covariance, lone, target) - narrow)
    assert room == pytest.approx(160.0 * 30.0 * 2.0 * np.pi, rel=0.35)


def test_a_mode_counts_the_symmetric_poses_that_it_does_not_span(library: Library) -> None:
    entry, target = library["cube"], target_of(library["cube"])
    sharp, turning = np.diag([0.1**2] * 3 + [0.01**2] * 3), np.diag([0.1**2] * 3 + [0.01**2, 0.01**2, 1.7**2])
    assert log_copies(entry, sharp, target) == pytest.approx(np.log(24.0))
    assert log_copies(entry, turning, target) == pytest.approx(np.log(6.0))


def test_a_pose_that_turned_far_about_a_place_beside_the_object_is_of_the_same_mode(library: Library) -> None:
    entry = library["step"]
    about = pose(None, [80.0, 0.0, 0.0])
    turned = about @ pose([[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0]]) @ inverse(about)
    target = target_of(entry)
    arm = np.cross([0.0, 0.0, 1.0], target.center - about[:3, 3])
    twist = np.concatenate([arm, [0.0, 0.0, 1.0]])
    covariance = 2.0 * np.outer(twist, twist) + np.diag([0.1**2] * 3 + [0.01**2] * 3)
    h = Hypothesis("step", np.eye(4), 0.0, covariance, 0.0, np.zeros(0))
    assert same(entry, [h], turned, target).all()
    assert not same(entry, [h], pose(None, [0.0, 30.0, 0.0]), target).any()
    assert same(entry, [h, replace(h, pose=pose(None, [0.0, 90.0, 0.0]))], turned, target).tolist() == [
        True,
        False,
    ]


def test_a_disc_stands_for_all_turns_about_itself_and_no_facet_counts() -> None:
    entry = Library.of({"disc": Solid.from_csg(Cylinder(40.0, 12.0))})["disc"]
    target = target_of(entry)
    level = np.diag([1e2, 1e2, 1e2, 1e4, 1e4, 0.0])
    faceted = level + np.diag([0.0, 0.0, 0.0, 0.0, 0.0, 50.0])
    middle = target.center[None]
    covariance, log_volume = spread_of(level, np.eye(4)[:3], middle, entry, target)
    assert np.allclose(covariance[5], 0.0)
    assert np.allclose(covariance[:, 5], 0.0)
    held = 2.5 * np.log(2.0 * np.pi) - 0.5 * np.log(1e2**3 * 1e4**2)
    assert log_volume == pytest.approx(held + np.log(2.0 * np.pi), abs=0.01)
    assert spread_of(faceted, np.eye(4)[:3], middle, entry, target)[1] == pytest.approx(log_volume, abs=1e-3)


@pytest.mark.parametrize("seed", [0, 1])
def test_a_round_object_is_no_less_likely_than_its_twin_that_turns_to_where_nothing_was_felt(
    seed: int,
) -> None:
    disc = Cylinder(35.0, 10.0)
    known = Library.of({"plain": Solid.from_csg(disc),
                        "holed": Solid.from_csg(disc - Cylinder(5.0, 30.0).at(22.0, 0.0, 0.0))})  # fmt: skip
    rng = np.random.default_rng(seed)
    rows = rng.choice(len(known["plain"].samples.points), 30, replace=False)
    points, normals = (a[rows] for a in (known["plain"].samples.points, known["plain"].samples.normals))
    points = points + rng.normal(size=points.shape) * 0.2
    normals = normals + rng.normal(size=normals.shape) * 0.02
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    told = match(Evidence(Contacts.of(points, normals, 0.2, 0.035)), known, unknown=0.0).probabilities
    assert 0.45 < told["plain"] < 0.85  # 0.7 by an integral over the turn


def test_contacts_of_the_bracket_are_still_named() -> None:
    known = Library.of({name: Solid.from_csg(parts.build(name)) for name in ("bracket", "wedge")})
    samples = known["bracket"].samples
    belief = match(Evidence(Contacts.of(samples.points[:20], samples.normals[:20], 0.1, 0.02)), known)
    assert belief.decision == "bracket"
