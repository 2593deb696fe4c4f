"""Contacts on one flat face are laid on every face that holds them, and tell nothing of the rest of the object."""

from dataclasses import replace

import numpy as np
import pytest

from models.csg import Cube, Cylinder
from models.library import Library
from models.solid import Solid
from primitives.evidence import Contacts
from primitives.pose import pose, random_rotation, rotate, transform_points
from recognition.matching import Evidence, match
from recognition.matching.flats import flats_of, laid_on
from recognition.matching.lone_face import LoneFace, lone_face
from recognition.matching.one_face import Room, divided, face_under, orbits

NOISE, TURN = 0.3, 0.037
TEE = Cube((100.0, 16.0, 12.0)) | Cube((16.0, 70.0, 12.0)).at(20.0, 35.0, 0.0)


def _library(**trees):
    return Library.of({name: Solid.from_csg(tree) for name, tree in trees.items()})


def _felt(points, rng, told=True):
    """Contacts that look up, at some pose; whether their normals are `told`."""
    world = pose(random_rotation(rng), rng.normal(size=3) * 40.0)
    normals = np.array([0.0, 0.0, 1.0]) + TURN * rng.normal(size=(len(points), 3))
    normals = rotate(world, normals / np.linalg.norm(normals, axis=1, keepdims=True))
    felt = transform_points(world, points) + NOISE * rng.normal(size=points.shape)
    return Contacts.of(felt, normals if told else None, NOISE, TURN)


def _square(half, many, rng):
    return np.column_stack([rng.uniform(-half, half, (many, 2)), np.zeros(many)])


def test_a_flat_face_is_boxed_and_a_round_one_is_not():
    ends = flats_of(_library(rod=Cylinder(20.0, 60.0))["rod"])
    assert len(ends) == 2
    for end in ends:
        assert abs(abs(end.axes[2, 2]) - 1.0) < 1e-6
        assert np.isclose(end.area, np.pi * 400.0, rtol=0.01)
        assert abs(end.diagonal - 40.0 * np.sqrt(2.0)) < 6.0


def test_contacts_are_laid_onto_a_face_wherever_they_were_felt():
    flats = flats_of(_library(block=Cube((60.0, 40.0, 20.0)))["block"])
    rng = np.random.default_rng(0)
    world = pose(random_rotation(rng), rng.normal(size=3) * 50.0)
    points, normals = transform_points(world, _square(12.0, 30, rng)), np.tile(world[:3, 2], (30, 1))
    one = lone_face(points, normals, np.ones(30, dtype=bool))
    laid = laid_on(points, one, flats)
    facing = laid[:, :, :3] @ normals[0]
    there = laid[:, :, :3] @ points.T + laid[:, :, 3:]  # (k, 3, n)
    assert len(laid) == 48 * 6
    assert np.allclose(np.abs(facing).max(axis=1), 1.0)
    assert np.allclose(np.einsum("ki,kin->kn", facing, there).T, np.abs(facing) @ [30.0, 20.0, 10.0])


def test_faces_that_a_symmetry_exchanges_are_one():
    entry = _library(block=Cube((60.0, 40.0, 20.0)))["block"]
    found = orbits(entry, flats_of(entry), 75.0)
    assert sorted(many for _, many in found) == [2] * 6
    assert len({first for first, _ in found}) == 3


def test_a_contact_lies_on_the_face_whose_plane_and_place_are_its_own():
    flats = flats_of(_library(tee=TEE)["tee"])
    here = np.eye(4)[:3]
    up = LoneFace(np.array([20.0, 60.0, 6.0]), np.array([0.0, 0.0, 1.0]), True)
    face, out = face_under(up, here, flats, 5.0)
    assert out
    assert np.allclose(flats[face].axes[:, 2], [0.0, 0.0, 1.0], atol=1e-6)
    beside, below = replace(up, point=np.array([-30.0, 60.0, 6.0])), replace(up, facing=-up.facing)
    assert face_under(beside, here, flats, 5.0) is None
    assert face_under(below, here, flats, 5.0) is None
    assert face_under(replace(below, signed=False), here, flats, 5.0) == (face, False)


def test_modes_of_one_face_have_its_room_together_and_one_of_them_keeps_its_share():
    room = Room((2, True), 1.0)
    out, shares = divided([0.0, np.log(3.0), 5.0], [room, room, None])
    assert np.isclose(np.exp(out[0]) + np.exp(out[1]), np.e)
    assert np.isclose(out[1] - out[0], np.log(3.0))
    assert out[2] == 5.0
    assert np.isclose(divided([7.0], [room], shares[1])[0][0], out[1])


def test_a_patch_is_as_likely_as_faces_that_hold_it_are_large():
    known = _library(cube=Cube((70.0, 70.0, 70.0)), plate=Cube((110.0, 110.0, 12.0)))
    rng = np.random.default_rng(1)
    told = [match(Evidence(_felt(_square(10.0, 20, rng), rng)), known).probabilities for _ in range(4)]
    odds = np.exp(np.mean([np.log(p["cube"] / p["plate"]) for p in told]))
    assert np.isclose(odds, 1.0 / (2 * 110**2 / (2 * 110**2 + 4 * 110 * 12)), rtol=0.35)


@pytest.mark.parametrize("told", [True, False])
@pytest.mark.parametrize("seed", range(3))
def test_a_face_that_contacts_fill_stays_open_beside_one_that_holds_them_with_room_to_spare(seed, told):
    known = _library(tee=TEE, plate=Cube((130.0, 120.0, 12.0)))
    rng = np.random.default_rng(seed)
    samples = known["tee"].samples
    top = samples.points[(samples.normals[:, 2] > 0.999) & (samples.points[:, 2] > 5.9)]
    belief = match(Evidence(_felt(top[rng.permutation(len(top))[:60]] * [1, 1, 0], rng, told)), known)
    best = belief.best("tee")
    assert best is not None
    assert best.log_likelihoods.min() > -6.0  # none lies beside it
    assert 0.1 < belief.probabilities["tee"] < 0.6  # of about a quarter, by their areas


def test_contacts_in_a_plane_are_of_one_face_with_normals_and_without():
    rng = np.random.default_rng(3)
    flat, up = _square(20.0, 30, rng) + 0.3 * rng.normal(size=(30, 3)), np.tile([0.0, 0.0, 1.0], (30, 1))
    no, yes = np.zeros(30, dtype=bool), np.ones(30, dtype=bool)
    assert lone_face(flat, up, yes).signed
    assert not lone_face(flat, up, no).signed
    assert lone_face(flat, up, np.arange(30) < 4).signed
    assert lone_face(flat[:4], up[:4], yes[:4]) is None
    assert lone_face(flat, rng.normal(size=(30, 3)), yes) is None
    assert lone_face(flat + rng.normal(size=(30, 3)) * [0, 0, 8.0], up, no) is None
    small = flat * [0.4, 0.15, 1.0]  # whose noise is a sixth of its breadth
    assert lone_face(small, up, no) is None
    assert not lone_face(small, up, no, 0.3).signed
    line = flat * [1.0, 0.0, 1.0] + 0.3 * rng.normal(size=(30, 3)) * [0.0, 1.0, 0.0]
    assert lone_face(line, up, no, 0.3) is None  # it lies in many planes
