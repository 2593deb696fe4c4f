"""Contacts that all came from one side end where the object does, which tells its size."""

import numpy as np
import pytest

from models import parts
from models.csg import Cube
from models.library import Library
from models.solid import Solid
from primitives.evidence import Contacts
from primitives.pose import pose, random_rotation, rotate, transform_points
from recognition.matching import Evidence, match
from recognition.matching.one_side import _by_normal, log_one_side, sides_of

SMALL, LARGE = Cube((60.0, 50.0, 30.0)), Cube((110.0, 90.0, 50.0))
LIBRARY = Library.of({"small": Solid.from_csg(SMALL), "large": Solid.from_csg(LARGE)})
NOISE, TURN = 0.3, 0.037


def _two_sides(width: float, depth: float, height: float, count: int, seed: int) -> Evidence:
    """Contacts drawn by area from the top of a block and the side at its front, from its corner on."""
    rng = np.random.default_rng(seed)
    top = rng.random(count) < depth / (depth + height)
    x, y, z = rng.uniform(0.0, [[width, depth, height]], (count, 3)).T
    points = np.column_stack([x, np.where(top, y, 0.0), np.where(top, 0.0, -z)])
    normals = np.where(top[:, None], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0])
    normals = normals + TURN * rng.standard_normal((count, 3))
    world = pose(random_rotation(rng), rng.uniform(-40.0, 40.0, 3))
    points = transform_points(world, points) + NOISE * rng.standard_normal((count, 3))
    normals = rotate(world, normals / np.linalg.norm(normals, axis=1, keepdims=True))
    return Evidence(Contacts.of(points, normals, NOISE, TURN))


def test_a_block_shows_its_faces() -> None:
    sides = sides_of(LIBRARY["small"])
    area, up = np.exp(sides.log_areas), sides.directions @ [0.0, 0.0, 1.0]
    assert area[up > 0.9999].min() == pytest.approx(60.0 * 50.0, rel=0.15)
    corner = (np.abs(sides.directions) > 0.25).all(axis=1)
    assert np.allclose(area[corner], 60.0 * 50.0 + 60.0 * 30.0 + 50.0 * 30.0, rtol=0.02)


@pytest.mark.parametrize("name", ["pipe", "bracket", "spur_gear"])
def test_the_places_of_a_contact_make_one(name: str) -> None:
    entry = Library.of({name: Solid.from_csg(parts.build(name))})[name]
    normals, area = entry.solid.body.triangle_normals, entry.solid.body.triangle_areas
    each = [log_one_side(entry, np.eye(3)[None], n[None], np.ones((1, 1)), np.ones(1))[0] for n in normals]
    assert area @ np.exp(each) == pytest.approx(1.0, abs=1e-4)  # alike normals are taken for one


def test_from_all_round_no_side_explains_contacts() -> None:
    normals, one = np.concatenate([np.eye(3), -np.eye(3)]), np.eye(3)[:1].repeat(6, axis=0)
    on, counts = np.ones((1, 6)), np.ones(6)
    round_it, straight = (
        log_one_side(LIBRARY["small"], np.eye(3)[None], n, on, counts) for n in (normals, one)
    )
    assert round_it < straight - 9.0


@pytest.mark.parametrize("seed", [0, 1])
def test_two_faces_felt_all_over_tell_how_large_they_are(seed: int) -> None:
    told = match(_two_sides(60.0, 50.0, 30.0, 40, seed), LIBRARY, unknown=0.0).probabilities
    assert told["small"] > 0.9


@pytest.mark.parametrize("seed", [0, 1])
def test_a_part_of_two_faces_tells_little_of_what_else_there_is(seed: int) -> None:
    told = match(_two_sides(30.0, 25.0, 15.0, 40, seed), LIBRARY, unknown=0.0).probabilities
    assert told["large"] > 0.1


def test_a_facet_without_area_is_seen_from_nowhere() -> None:
    normals, areas = _by_normal(np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 0.0]]), np.array([2.0, 0.0]))
    assert normals.tolist() == [[0.0, 0.0, 1.0]]
    assert areas.tolist() == [2.0]
