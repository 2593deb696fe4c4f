"""A scallop that one touch of a fingertip was in."""

import numpy as np
import pytest

from exploration.planning.faces.hollows import hollow_face
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.patch_graph import MergeOptions, PatchGraph, ranked_face
from primitives.pose import pose, random_rotation, rotate, transform_points

WORLD = pose(random_rotation(np.random.default_rng(3)), [10.0, -20.0, 30.0])


def felt(azimuths: Floats, radius: float = 12.0, side: float = -1.0, touch: int = 5) -> Contacts:
    """Contacts of a cylinder along z; from inside it unless `side` is 1."""
    rng = np.random.default_rng(touch)
    ways = np.column_stack([np.cos(azimuths), np.sin(azimuths), np.zeros(len(azimuths))])
    points = np.array([38.0, 0.0, 9.0]) + (radius + 0.01 * rng.standard_normal((len(ways), 1))) * ways
    normals = side * ways + 0.005 * rng.standard_normal(ways.shape)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Contacts.of(transform_points(WORLD, points), rotate(WORLD, normals), 0.015, 0.006, touch=touch)


@pytest.fixture(scope="module")
def plate() -> PatchGraph:
    """A flat face across z."""
    rng = np.random.default_rng(1)
    points = np.column_stack([rng.uniform(-30, 30, (30, 2)), np.full(30, 22.0)])
    top = Contacts.of(transform_points(WORLD, points), np.tile(WORLD[:3, 2], (30, 1)), 0.01, 0.01)
    return PatchGraph((ranked_face(0, top, MergeOptions()),), ())


@pytest.mark.parametrize("radius", [6.0, 12.0, 30.0])
def test_four_contacts_that_face_three_ways_are_a_hollow(plate: PatchGraph, radius: float) -> None:
    lot = felt(np.pi + np.array([-0.35, 0.0, 0.02, 0.35]), radius)
    face = hollow_face(plate, Contacts.concatenate([felt(np.array([0.0]), touch=1), lot]))
    assert face is not None
    assert isinstance(face.fit, Fit)
    assert not face.fit.convex
    assert face.fit.shape.sizes[0] == pytest.approx(radius, rel=0.05)
    assert abs(face.fit.shape.direction @ WORLD[:3, 2]) > 0.9999
    assert (face.contacts.touch == 5).all()


def test_a_bulge_two_ways_few_contacts_two_touches_or_no_known_direction_are_none(plate: PatchGraph) -> None:
    around = np.pi + np.array([-0.35, 0.0, 0.02, 0.35])
    assert hollow_face(plate, felt(around, side=1.0)) is None
    assert (
        hollow_face(plate, felt(np.pi + np.array([-0.35, -0.33, 0.33, 0.35]))) is None
    )  # as an inside corner does
    assert hollow_face(plate, felt(around[:3])) is None
    assert hollow_face(plate, Contacts.concatenate([felt(around[:2]), felt(around[2:], touch=6)])) is None
    assert hollow_face(plate, felt(around, radius=2.0)) is None
    assert hollow_face(PatchGraph((), ()), felt(around)) is None
    assert hollow_face(plate, Contacts.of([])) is None
