"""Normals that point into the object are noticed, matched turned round, and told; those of a hollow are not."""

from dataclasses import replace

import numpy as np
import pytest

from models import parts
from models.csg import Csg, Cube, Cylinder
from models.library import Library
from models.solid import Solid
from primitives.errors import PalpateError
from primitives.evidence import Contacts
from primitives.facing import may_face_in
from primitives.pose import pose, random_rotation, rotate, transform_points
from recognition.matching import Belief, Evidence, Prior, match
from recognition.matching.facing import either
from recognition.recognizing.answer import warnings_of

NAMES = ("bracket", "wedge", "block", "flange")
SIGMA, TURN = 0.2, 0.03


@pytest.fixture(scope="module")
def library() -> Library:
    return Library.of({name: Solid.from_csg(parts.build(name)) for name in NAMES})


def _felt(library: Library, rows: np.ndarray, rng: np.random.Generator, sign: float) -> Contacts:
    samples, world = library["bracket"].samples, pose(random_rotation(rng), rng.uniform(-40.0, 40.0, 3))
    points = transform_points(world, samples.points[rows]) + SIGMA * rng.standard_normal((len(rows), 3))
    normals = rotate(world, samples.normals[rows]) + TURN * rng.standard_normal((len(rows), 3))
    return Contacts.of(points, sign * normals / np.linalg.norm(normals, axis=1, keepdims=True), SIGMA, TURN)


def test_normals_that_point_in_are_turned_round_and_told(library: Library) -> None:
    rng = np.random.default_rng(0)
    rows = rng.integers(len(library["bracket"].samples), size=16)
    evidence = Evidence(_felt(library, rows, rng, -1.0))
    belief = match(evidence, library)
    assert belief.decision == "bracket"
    assert belief.inward > 0.99
    assert sum(belief.probabilities.values()) == pytest.approx(1.0)
    assert "point into the object" in warnings_of(belief, evidence)[0]


def test_they_are_noticed_where_nobody_told_the_noise_too(library: Library) -> None:
    rng = np.random.default_rng(3)
    contacts = _felt(library, rng.integers(len(library["bracket"].samples), size=16), rng, -1.0)
    coarse = replace(contacts, sigma=np.full(16, 8.0))
    belief = match(Evidence(coarse, scale_known=False, normal_scale_known=False), library)
    assert belief.inward > 0.99
    assert belief.hypotheses[0].residual < 2.0 * SIGMA


def test_normals_that_point_out_are_taken_as_they_are(library: Library) -> None:
    rng = np.random.default_rng(1)
    rows = rng.integers(len(library["bracket"].samples), size=16)
    belief = match(Evidence(_felt(library, rows, rng, 1.0)), library)
    assert belief.decision == "bracket"
    assert belief.inward == 0.0


def test_a_cup_felt_from_within_stays_a_cup() -> None:
    cup = Solid.from_csg(Cube((80.0, 60.0, 50.0)) - Cube((70.0, 50.0, 50.0)).at(0.0, 0.0, 8.0))
    block = Solid.from_csg(Cube((69.0, 49.0, 47.0)))
    known = Library.of({"cup": cup, "block": block})
    samples = known["cup"].samples
    within = np.flatnonzero((samples.points * samples.normals).sum(axis=1) < -1.0)[:24]
    contacts = Contacts.of(samples.points[within], samples.normals[within], SIGMA, TURN)
    assert may_face_in(contacts, True)
    belief = match(Evidence(contacts), known)
    assert belief.decision == "cup"
    assert belief.inward < 0.05


def test_one_face_says_nothing_of_which_way_normals_point() -> None:
    rng = np.random.default_rng(2)
    points = np.column_stack([rng.uniform(-20, 20, (200, 12, 2)).reshape(-1, 2), rng.normal(0, SIGMA, 2400)])
    normals = [0.0, 0.0, 1.0] + TURN * rng.standard_normal((2400, 3)) * [1.0, 1.0, 0.0]
    rows = zip(points.reshape(200, 12, 3), normals.reshape(200, 12, 3), strict=True)
    tables = [Contacts.of(p, n, SIGMA, TURN) for p, n in rows]
    assert sum(may_face_in(t, True) for t in tables) <= 2


def test_beliefs_of_both_ways_are_weighed_by_how_probable_the_contacts_are() -> None:
    out, within = Belief((), {"a": 0.9, "b": 0.1}, -50.0), Belief((), {"a": 0.2, "b": 0.8}, -50.0)
    both = either(out, within, 0.01)
    assert both.inward == pytest.approx(0.01)
    assert both.probabilities["a"] == pytest.approx(0.99 * 0.9 + 0.01 * 0.2)
    assert either(out, Belief((), {"a": 0.2, "b": 0.8}, 700.0), 0.01).probabilities["b"] == pytest.approx(0.8)


def round_the_axis(solid: Csg) -> tuple[Library, Evidence]:
    """One object, and exact contacts on a round wall of 12 mm about its axis, whose normals face that."""
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    out = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(24)])
    places = 12.0 * out + np.outer(np.resize([2.0, 5.0, 8.0], 24), [0.0, 0.0, 1.0])
    return Library.of({"one": Solid.from_csg(solid)}), Evidence(Contacts.of(places, -out, 0.05, 0.01))


BOWL = Cube((60, 40, 20)) - Cylinder(12, 30).at(0, 0, 10)
PEG = Cylinder(12, 30) | Cube((60, 40, 5)).at(0, 0, -15)


@pytest.mark.parametrize("unknown", [0.0, 0.1])
@pytest.mark.parametrize(("solid", "inward"), [(BOWL, 0.0), (PEG, 1.0)])
def test_a_reading_that_no_pose_meets_leaves_the_other(solid: Csg, inward: float, unknown: float) -> None:
    library, evidence = round_the_axis(solid)
    belief = match(evidence, library, Prior(np.zeros(3), 5.0), unknown)
    assert belief.decision == "one"
    assert belief.inward == pytest.approx(inward, abs=1e-6)


def test_where_neither_reading_is_met_it_says_so() -> None:
    library, evidence = round_the_axis(BOWL)
    with pytest.raises(PalpateError, match="no pose within"):
        match(evidence, library, Prior(np.full(3, 500.0), 1.0), 0.0)
