"""Hexagonal and square sockets, from edges seen round their mouth."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from exploration.control.sighting import Sighting
from exploration.planning.inferring.sockets import sockets
from primitives import pose as se3
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, ranked_face

Z = np.eye(3)[2]


def flat(number, z, size=30.0):
    grid = np.array([[x, y, z] for x in (-size, 0.0, size) for y in (-size, 0.0, size)])
    return ranked_face(number, Contacts.of(grid, np.tile(Z, (9, 1))), MergeOptions())


TOP, FLOOR = flat(0, 0.0), flat(1, -8.0, 3.0)


def edges(angles, inside, rng, noise=0.1, slide=2.0):
    """Edges of the top at half a width across flats, with the ways into the socket at such angles."""
    ways = np.column_stack([np.cos(angles), np.sin(angles), np.zeros(len(angles))])
    along = np.cross(Z, ways)
    points = -inside * ways + noise * rng.standard_normal((len(angles), 1)) * ways
    points = points + slide * rng.uniform(-1.0, 1.0, (len(angles), 1)) * along
    return [(Sighting(p, t, w, Z, 0.05, 8.0), 0) for p, t, w in zip(points, along, ways, strict=True)]


def placed(rims, pose):
    turn = pose[:3, :3]
    return [
        (Sighting(*se3.transform_points(pose, r.point[None]), turn @ r.tangent, turn @ r.outward, turn @ r.normal,
                  r.sigma, r.length), own)
        for r, own in rims
    ]  # fmt: skip


@given(
    sides=st.sampled_from([6, 4]),
    inside=st.floats(4.0, 14.0),
    first=st.floats(0.0, 1.5),
    seed=st.integers(0, 99),
)
def test_edges_of_all_sides_but_one_make_a_socket_down_to_the_floor(sides, inside, first, seed):
    rng = np.random.default_rng(seed)
    turns = (
        first
        + 2.0 * np.pi / sides * np.repeat(np.arange(sides - 1), 2)
        + rng.normal(0.0, 0.02, 2 * sides - 2)
    )
    lots = sockets(edges(turns, inside, rng, slide=0.3 * inside), [TOP, FLOOR])
    assert len(lots) == sides
    for k in range(sides):
        turn = first + 2.0 * np.pi / sides * k
        way = np.array([np.cos(turn), np.sin(turn), 0.0])
        lot = max(lots, key=lambda lot: float(lot.normals[0] @ way))
        assert lot.normals[0] @ way > np.cos(0.06)
        assert lot.points.mean(axis=0) @ way == pytest.approx(-inside, abs=0.4)
        assert -8.0 < lot.points[:, 2].min() < lot.points[:, 2].max() < 0.0


def test_it_is_found_wherever_its_face_lies():
    rng = np.random.default_rng(1)
    pose = se3.pose(se3.rotation_exp([0.4, -1.1, 0.7]), [30.0, -20.0, 50.0])
    turned = se3.transform_points(pose, TOP.contacts.points), TOP.contacts.normals @ pose[:3, :3].T
    top = ranked_face(0, Contacts.of(*turned), MergeOptions())
    lots = sockets(placed(edges(np.arange(6) * np.pi / 3.0, 9.0, rng), pose), [top])
    assert len(lots) == 6
    center = np.mean([lot.points.mean(axis=0) for lot in lots], axis=0)
    assert np.linalg.norm(se3.transform_points(se3.inverse(pose), center[None])[0][:2]) < 0.2


def test_a_round_mouth_too_few_sides_and_the_outside_of_a_nut_make_none():
    rng = np.random.default_rng(2)
    around = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    assert sockets(edges(around, 9.0, rng), [TOP]) == []
    assert sockets(edges(np.array([0.0, 0.0, np.pi, np.pi]), 9.0, rng), [TOP]) == []
    assert sockets(edges(np.arange(4) * np.pi / 3.0, 9.0, rng), [TOP]) == []
    assert sockets(edges(np.arange(6) * np.pi / 3.0, -9.0, rng), [TOP]) == []
    assert sockets(edges(np.arange(4) * np.pi / 2.0, 27.0, rng), [TOP]) == []  # an array has room there
    assert sockets(edges(np.arange(6) * np.pi / 3.0, 9.0, rng), []) == []  # of no face
    assert sockets([], [TOP]) == []


@pytest.mark.parametrize("sides", [6, 4])
def test_edges_far_along_the_lines_of_a_socket_are_of_none(sides):
    rng = np.random.default_rng(3)
    near = edges(np.arange(sides) * 2.0 * np.pi / sides, 6.0, rng, noise=0.0, slide=0.0)
    far = [(replace(r, point=r.point + 60.0 * r.tangent), own) for r, own in near]
    assert len(sockets(near, [TOP, FLOOR])) == sides
    assert sockets(far, [TOP, FLOOR]) == []


def test_edges_past_the_ends_of_a_side_are_no_edges_of_it():
    """As of the neck of a T-slot, whose walls are in line with the sides of a square below it."""
    square = edges(np.arange(4) * np.pi / 2.0, 7.0, np.random.default_rng(4), noise=0.0, slide=0.0)
    neck = [
        (replace(r, point=r.point + 8.0 * Z[[1, 2, 0]]), own) for r, own in square if abs(r.outward[0]) > 0.9
    ]
    ends = [(r, own) for r, own in square if abs(r.outward[1]) > 0.9]
    assert len(sockets(square, [TOP, FLOOR])) == 4
    assert sockets([*neck, *ends[:1]], [TOP, FLOOR]) == []
