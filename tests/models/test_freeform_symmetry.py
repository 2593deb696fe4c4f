"""Bodies whose faces are freeform: their surface tells the rotations that leave them as they are."""

from functools import cache

import numpy as np
import pytest
import trimesh

from models.brep import Brep
from models.freeform_symmetry import symmetry_of_solid
from models.library import Library
from models.solid import Solid
from models.symmetry import SymmetryGroup
from primitives.arrays import Floats
from primitives.pose import pose, random_rotation


def _ball(radial: float, folds: int, lifted: float, sizes: tuple[float, float, float]) -> Floats:
    """(v, 3) of a ball with waves round it, raised more on one end, stretched."""
    x, y, z = trimesh.creation.icosphere(4).vertices.T
    wave = 1.0 + radial * np.cos(folds * np.arctan2(y, x)) * (1.0 - z**2)
    return np.column_stack([x * wave, y * wave, z + lifted * z**2]) * sizes


def _egg(fine: int, size: float, swell: float) -> Solid:
    """A ball with bumps that no rotation leaves as they are."""
    ball = trimesh.creation.icosphere(fine)
    x, y, z = ball.vertices.T
    lobes = 1.0 + swell * (0.05 * np.sin(2.0 * x + 1.0) * y + 0.05 * z * x + 0.04 * y * z)
    return Solid.from_mesh(ball.vertices * lobes[:, None] * size * np.array([30.0, 28.0, 26.0]), ball.faces)


@cache
def _freeform() -> Brep:
    """A boundary that tells of freeform faces, and of no symmetry: making one for each body takes long."""
    return Library.of({"egg": _egg(1, 1.0, 1.0)})["egg"].brep


def _group(points: Floats, turned: bool = True) -> tuple[SymmetryGroup, Floats]:
    turn = random_rotation(np.random.default_rng(0)) if turned else np.eye(3)
    world = pose(turn, [20.0, -30.0, 5.0])
    there = points @ world[:3, :3].T + world[:3, 3]
    return symmetry_of_solid(Solid.from_mesh(there, trimesh.creation.icosphere(4).faces), _freeform()), world


@pytest.mark.parametrize(("points", "name", "order"), [
    (_ball(0.0, 0, 0.0, (30.0, 20.0, 15.0)), "D2", 4),
    (_ball(0.0, 0, 0.0, (30.0, 30.0, 15.0)), "D_inf", np.inf),
    (_ball(0.0, 0, 0.3, (20.0, 20.0, 25.0)), "C_inf", np.inf),
    (_ball(0.2, 5, 0.0, (25.0, 25.0, 15.0)), "D5", 10),
    (_ball(0.15, 4, 0.0, (30.0, 30.0, 12.0)), "D4", 8),
    (_ball(0.15, 4, 0.0, (30.0, 30.0, 60.0)), "D4", 8),
    (_ball(0.15, 2, 0.0, (30.0, 30.0, 12.0)), "D2", 4),
    (_ball(0.2, 3, 0.3, (25.0, 25.0, 15.0)), "C3", 3),
    (_ball(0.2, 3, 0.3, (25.0, 20.0, 15.0)), "C1", 1),
])  # fmt: skip
def test_the_surface_tells_the_group(points: Floats, name: str, order: float) -> None:
    straight, _ = _group(points, turned=False)
    assert (straight.name, straight.order) == (name, order)
    group, world = _group(points)
    assert (group.name, group.order) == (name, order)
    if group.axis is not None:
        assert abs(group.axis @ world[:3, 2]) == pytest.approx(1.0, abs=1e-3)


def test_every_rotation_carries_the_surface_onto_itself() -> None:
    group, world = _group(_ball(0.2, 5, 0.0, (25.0, 25.0, 15.0)))
    solid = Solid.from_mesh(_ball(0.2, 5, 0.0, (25.0, 25.0, 15.0)), trimesh.creation.icosphere(4).faces)
    for turn in group.rotations:
        there = np.linalg.inv(world) @ turn @ world
        moved = solid.vertices @ there[:3, :3].T + there[:3, 3]
        assert np.abs(solid.signed_distance(moved)).max() < 0.3


@pytest.mark.parametrize(("points", "name"), [
    (_ball(0.0, 0, 0.0, (30.0, 30.0, 15.0)), "D_inf"),
    (_ball(0.0, 0, 0.0, (30.0, 29.0, 15.0)), "D2"),
    (_ball(0.0, 0, 0.3, (20.0, 19.3, 25.0)), "C2"),
    (_ball(0.2, 3, 0.3, (25.0, 24.0, 15.0)), "C1"),
])  # fmt: skip
def test_a_body_of_10_mm_has_the_group_of_a_large_one(points: Floats, name: str) -> None:
    group, _ = _group(points * (10.0 / np.linalg.norm(np.ptp(points, axis=0))))
    assert group.name == name


def test_a_small_squashed_ring_turns_over_but_not_round() -> None:
    ring = trimesh.creation.torus(15.0, 5.0, 64, 32)
    solid = Solid.from_mesh(ring.vertices * [0.18, 0.173, 0.18], ring.faces)
    assert symmetry_of_solid(solid, _freeform()).name == "D2"


def test_a_library_has_the_symmetry_of_a_freeform_body() -> None:
    ball = trimesh.creation.icosphere(3)
    solid = Solid.from_mesh(ball.vertices * [9.0, 6.0, 4.0], ball.faces)
    assert Library.of({"ellipsoid": solid})["ellipsoid"].symmetry.name == "D2"


@pytest.mark.parametrize("size", [0.1, 1.0])
@pytest.mark.parametrize("fine", [1, 2, 3])
@pytest.mark.parametrize("swell", [1.0, 0.6])
def test_facets_that_are_coarse_hide_no_lack_of_symmetry(size: float, fine: int, swell: float) -> None:
    assert symmetry_of_solid(_egg(fine, size, swell), _freeform()).name == "C1"
