"""The choice of the next touch on objects whose difference is known."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from exploration.planning.touching.pace import Pace
from exploration.planning.ways.round_ball import Ball
from models.csg import Csg, Cube, Cylinder
from models.library import Library
from models.solid import Solid
from primitives import pose as se3
from recognition.matching.next_touch import Choice, NoChoice, choose, separating
from recognition.matching.next_touch.planar import planar

HOLE = np.array([25.0, 10.0, 0.0])


@dataclass(frozen=True)
class _Posed:
    name: str
    pose: np.ndarray
    log_weight: float
    covariance: np.ndarray = field(default_factory=lambda: 1e-6 * np.eye(6))


@dataclass(frozen=True)
class _Belief:
    hypotheses: tuple[_Posed, ...]
    probabilities: Mapping[str, float]


def _plate(bored: bool) -> Csg:
    plate = Cube((90.0, 60.0, 12.0))
    if not bored:
        return plate
    return plate - Cylinder(6.0, 30.0).at(*HOLE)


def _chosen(library: Library, seed: int = 0) -> Choice | NoChoice:
    rng = np.random.default_rng(seed)
    pose = se3.pose(se3.random_rotation(rng), rng.normal(size=3) * 20.0)
    hypotheses = tuple(_Posed(name, pose, np.log(0.5)) for name in library)
    belief = _Belief(hypotheses, dict.fromkeys(library, 0.5))
    here = se3.pose(np.diag([1.0, -1.0, -1.0]), pose[:3, 3] + [0.0, 0.0, 150.0])
    ball = Ball(pose[:3, 3], 80.0)
    return choose(belief, library, here, ball, (28.8, 18.0), Pace(), rng)


def test_the_touch_for_near_duplicates_hits_what_differs() -> None:
    library = Library.of({"plain": Solid.from_csg(_plate(False)), "bored": Solid.from_csg(_plate(True))})
    for seed in range(4):
        rng = np.random.default_rng(seed)
        pose = se3.pose(se3.random_rotation(rng), rng.normal(size=3) * 20.0)
        found = _chosen(library, seed)
        assert isinstance(found, Choice)
        assert found.name_bits > 0.3
        start = se3.inverse(pose) @ found.approach.start
        along = start[:3, 2]
        across = (HOLE - start[:3, 3]) - along * float((HOLE - start[:3, 3]) @ along)
        assert np.linalg.norm(across) < 22.0  # the hole is under the pad


def test_where_no_touch_tells_the_name_the_pose_is_settled_first() -> None:
    solid = Solid.from_csg(_plate(True))
    library, pad = Library.of({"one": solid, "other": solid}), (28.8, 18.0)
    here, ball = se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 150.0]), Ball(np.zeros(3), 80.0)
    for open_by, settled in ((1e-6, True), (4.0, False)):
        along_x = np.diag([open_by, 1e-6, 1e-6, 1e-8, 1e-8, 1e-8])
        hypotheses = tuple(_Posed(name, np.eye(4), np.log(0.5), along_x) for name in library)
        belief = _Belief(hypotheses, dict.fromkeys(library, 0.5))
        found = separating(belief, library, here, ball, pad, Pace(), np.random.default_rng(0))
        assert isinstance(found, NoChoice) == settled
    assert isinstance(found, Choice)
    assert found.name_bits == 0.0
    assert abs(found.approach.direction[0]) > 0.9  # against an end, which tells where along x it is


def test_objects_that_are_alike_have_no_separating_touch() -> None:
    twin = Solid.from_csg(_plate(True))
    found = _chosen(Library.of({"one": twin, "other": twin}))
    assert isinstance(found, NoChoice)
    assert "left apart" in found.reason


def test_a_planner_may_bring_its_own_utility() -> None:
    library = Library.of({"plain": Solid.from_csg(_plate(False)), "bored": Solid.from_csg(_plate(True))})
    rng = np.random.default_rng(0)
    belief = _Belief((_Posed("plain", np.eye(4), 0.0),), {"plain": 1.0})
    here = se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 150.0])
    found = choose(
        belief, library, here, Ball(np.zeros(3), 80.0), (28.8, 18.0), Pace(), rng,
        utility=lambda outcomes, known: 1.0 * outcomes.hit[:, 0],
    )  # fmt: skip
    assert isinstance(found, Choice)
    assert found.bits > 0.0


def test_a_path_in_the_plane_comes_from_where_two_boxes_end_elsewhere() -> None:
    solids = {
        name: Solid.from_csg(Cube((long, 60.0, 40.0))) for name, long in (("short", 60.0), ("long", 66.0))
    }
    library, rng = Library.of(solids), np.random.default_rng(0)
    hypotheses = tuple(_Posed(name, np.eye(4), np.log(0.5)) for name in library)
    ball = Ball(np.zeros(3), 80.0)
    found = planar(_Belief(hypotheses, dict.fromkeys(library, 0.5)), library, ball, (28.8, 18.0), rng)
    assert found is not None
    assert found.start[2, 3] == 0.0
    assert abs(found.direction[0]) > 0.5  # from the side, 60 mm lie everywhere alike
    one = _Belief(hypotheses[:1], {"short": 1.0})
    assert planar(one, library, ball, (28.8, 18.0), rng) is None
