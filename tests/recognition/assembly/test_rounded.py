"""Bodies whose edges are rounded."""

from itertools import combinations, product

import numpy as np
import pytest

from models.csg import Cube, Sphere, Torus
from models.csg import Cylinder as Bar
from models.solid import Solid
from primitives.evidence import Contacts
from primitives.fit import fit
from primitives.pose import frame_along, pose
from recognition.assembly.assemble import assemble
from recognition.assembly.rounded import ROUNDED
from recognition.best_body import FeltFace

HALF, R = np.array([40.0, 25.0, 16.0]), 6.0
BOX = np.array([[-90.0] * 3, [90.0] * 3])
SIDES = [s * np.eye(3)[k] for k in range(3) for s in (1.0, -1.0)]
EDGES = [(a, b) for a, b in combinations(SIDES, 2) if abs(a @ b) < 0.5]


def felt(kind, points, normals):
    lot = Contacts.of(points, normals, 0.02)
    return FeltFace(fit(kind, lot), lot)


def flat(normal):
    k = int(np.argmax(np.abs(normal)))
    spots = [np.linspace(R - HALF[i], HALF[i] - R, 6) if i != k else [HALF[k] * normal[k]] for i in range(3)]
    points = np.array(list(product(*spots)))
    return felt("plane", points, np.tile(normal, (len(points), 1)))


def edge(one, other):
    along = np.abs(np.cross(one, other))
    turn = 0.5 * np.pi * np.linspace(0.05, 0.95, 6)[:, None]
    ways = np.cos(turn) * one + np.sin(turn) * other
    rows = np.outer(np.linspace(-1.0, 1.0, 5) * ((HALF - R) @ along), along) + (HALF - R) * (one + other)
    return felt("cylinder", (rows[:, None] + R * ways).reshape(-1, 3), np.tile(ways, (5, 1)))


def ball_box():
    """A box rounded all over, as the union that it is."""
    x, y, z = 2.0 * HALF
    inner = 2.0 * R
    tree = Cube((x, y - inner, z - inner)) | Cube((x - inner, y, z - inner)) | Cube((x - inner, y - inner, z))
    for one, other in EDGES:
        axis = np.abs(np.cross(one, other))
        bar = Bar(R, float(2.0 * ((HALF - R) @ axis)))
        tree = tree | bar.placed(pose(frame_along(axis), (HALF - R) * (one + other)))
    for signs in product((1.0, -1.0), repeat=3):
        tree = tree | Sphere(R).at(*((HALF - R) * signs))
    return Solid.from_csg(tree, 0.005)


def test_a_box_that_is_rounded_all_over_is_a_box_with_bars_and_balls():
    made = assemble([*map(flat, SIDES), *(edge(*pair) for pair in EDGES)], BOX)
    assert made
    kinds = [piece.kind for piece in made.pieces]
    assert (kinds.count("cube"), kinds.count("cylinder"), kinds.count("sphere")) == (13, 12, 8)
    wanted = ball_box()
    assert made.solid.volume == pytest.approx(wanted.volume, rel=2e-4)
    assert np.abs(made.solid.signed_distance(wanted.vertices)).max() < 0.05
    assert all(s is not None for s in made.surface_of_fit)
    assert made.warnings == (ROUNDED,)


def test_edges_hardly_longer_than_they_are_round_are_rounded_too(monkeypatch):
    monkeypatch.setitem(globals(), "HALF", np.array([40.0, 25.0, R + 3.0]))
    made = assemble([*map(flat, SIDES), *(edge(*pair) for pair in EDGES)], BOX)
    assert made
    assert made.warnings == (ROUNDED,)
    assert made.solid.volume == pytest.approx(ball_box().volume, rel=2e-4)


def test_two_edges_that_run_to_flat_ends_are_rounded_to_these():
    pair = [edge(SIDES[4], SIDES[0]), edge(SIDES[4], SIDES[3])]
    made = assemble([*map(flat, SIDES), *pair], BOX)
    assert made
    lost = (1.0 - 0.25 * np.pi) * R**2 * 2.0 * (HALF[0] + HALF[1])
    assert made.solid.volume == pytest.approx(8.0 * HALF.prod() - lost, rel=2e-3)


def test_edges_that_all_run_one_way_are_walls_of_the_body_as_before():
    upright = [edge(a, b) for a, b in EDGES if abs(np.cross(a, b)[2]) > 0.5]
    made = assemble([*map(flat, SIDES), *upright], BOX)
    assert made
    assert ROUNDED not in made.warnings
    assert made.solid.volume == pytest.approx(
        8.0 * HALF.prod() - (4.0 - np.pi) * R**2 * 2.0 * HALF[2], rel=1e-3
    )


def turned(deep, lean):
    """(n, 3) places of the rounded rim of a bar with its end at 20 mm, and (n, 3) normals."""
    turns, lean = (lot.ravel() for lot in np.meshgrid(np.arange(0.0, 6.2, 0.3), lean))
    out = np.column_stack([np.cos(turns), np.sin(turns), 0.0 * turns])
    ways = np.sin(lean)[:, None] * out + np.cos(lean)[:, None] * np.eye(3)[2]
    return (18.0 - deep) * out + [0.0, 0.0, 20.0 - deep] + deep * ways, ways


@pytest.mark.parametrize("bore", [False, True])
def test_the_end_of_a_bar_is_rounded_by_a_ring_and_keeps_its_bore(bore):
    turns, high = (lot.ravel() for lot in np.meshgrid(np.arange(0.0, 6.2, 0.3), np.linspace(-17.0, 12.0, 6)))
    out = np.column_stack([np.cos(turns), np.sin(turns), 0.0 * turns])
    wall = 18.0 * out + high[:, None] * np.eye(3)[2]
    ends = []
    for z, reach in ((20.0, 12.0), (-20.0, 17.0)):
        disc = np.array([[x, y, z] for x in range(-16, 17, 3) for y in range(-16, 17, 3)], dtype=float)
        far = np.hypot(disc[:, 0], disc[:, 1])
        disc = disc[(far < reach) & (far > (7.0 if bore else -1.0))]
        ends.append(felt("plane", disc, np.tile([0.0, 0.0, np.sign(z)], (len(disc), 1))))
    faces = [
        felt("cylinder", wall, out),
        *ends,
        felt("torus", *turned(5.0, np.deg2rad([10.0, 30.0, 50.0, 75.0]))),
    ]
    if bore:
        faces.append(felt("cylinder", 6.0 * out + high[:, None] * np.eye(3)[2], -out))
    made = assemble(faces, BOX)
    assert made
    assert made.warnings == (ROUNDED,)
    wanted = (Bar(18.0, 35.0).at(0, 0, -2.5) | Bar(13.0, 40.0)) | Torus(13.0, 5.0).at(0, 0, 15.0)
    wanted = Solid.from_csg(wanted - Bar(6.0, 60.0) if bore else wanted, 0.005)
    assert made.solid.volume == pytest.approx(wanted.volume, rel=5e-4)
    assert np.abs(made.solid.signed_distance(wanted.vertices)).max() < 0.1
