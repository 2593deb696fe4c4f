"""Contacts that are no contacts of the object: one in ten before it does no harm, and one within it is noticed."""

import numpy as np
import pytest

from models import parts
from models.library import Library
from models.solid import Solid
from primitives.evidence import Contacts
from primitives.pose import pose, random_rotation, rotate, transform_points
from recognition.matching import Evidence, match
from recognition.matching.likelihood import NoiseConfig, log_astray, log_known, log_strays, log_unlike

NAMES = ("bracket", "wedge", "block", "flange")
SIGMA, TURN = 0.1, 0.02


@pytest.fixture(scope="module")
def library() -> Library:
    return Library.of({name: Solid.from_csg(parts.build(name)) for name in NAMES})


def _felt(library: Library, count: int, astray: int, rng: np.random.Generator) -> Contacts:
    entry = library["bracket"]
    rows = rng.integers(len(entry.samples), size=count)
    world = pose(random_rotation(rng), rng.uniform(-40.0, 40.0, 3))
    points = transform_points(world, entry.samples.points[rows]) + SIGMA * rng.standard_normal((count, 3))
    normals = rotate(world, entry.samples.normals[rows]) + TURN * rng.standard_normal((count, 3))
    points[:astray] += rng.uniform(3.0, 20.0, (astray, 1)) * normals[:astray]
    order = rng.permutation(count)
    return Contacts.of(points[order], normals[order], SIGMA, TURN)


def test_one_in_two_hundred_astray_does_not_make_a_known_object_unknown(library: Library) -> None:
    belief = match(Evidence(_felt(library, 1000, 5, np.random.default_rng(0))), library)
    assert belief.decision == "bracket"
    assert belief.confidence > 0.8


def test_many_contacts_tell_which_of_them_separate(library: Library) -> None:
    contacts = _felt(library, 1000, 0, np.random.default_rng(1))
    belief = match(Evidence(contacts), library)
    best = belief.best("bracket")
    assert best is not None
    assert best.log_likelihoods.shape == (1000,)


def _odds(off_it: int, of: int, behind: bool = False) -> float:
    """Of an unknown object, where so many contacts do not lie on the known one."""
    on, off = np.full((1, of), 3.0), np.full((1, of), -9.0)
    on[0, :off_it] = -200.0
    config = NoiseConfig()
    strays = log_strays(off, (on < 0.0) & behind, config)
    return float((log_unlike(on, off, np.ones(of)) - log_known(on, strays, np.ones(of), config))[0])


def test_one_in_ten_off_a_body_is_borne_and_three_in_ten_speak_for_another() -> None:
    assert all(_odds(k, n) < np.log(9.0) for k, n in ((1, 12), (2, 20), (5, 50)))
    assert all(_odds(k, n) > np.log(9.0) for k, n in ((4, 12), (6, 20), (15, 50)))


def test_one_of_a_dozen_within_a_known_object_speaks_for_an_unknown_one() -> None:
    assert _odds(1, 12, behind=True) > np.log(10.0)


def test_what_fits_costs_an_unknown_object_the_number_of_contacts() -> None:
    on, off = np.full((1, 30), 3.0), np.full((1, 30), -9.0)
    odds = log_known(on, off, np.ones(30), NoiseConfig()) - log_unlike(on, off, np.ones(30))
    assert odds[0] == pytest.approx(np.log(31.0), abs=0.2)


def test_empty_space_where_a_known_object_is_speaks_against_one_like_it_too() -> None:
    assert log_astray(0.0, 14.0, 0.0) == 0.0
    few, many = log_astray(1.0, 14.0, -4.6), log_astray(6.0, 14.0, -27.6)
    assert -27.6 < many < few < 0.0
