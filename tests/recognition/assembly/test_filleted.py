"""Fillets that are added to the pieces of a body."""

import numpy as np
import pytest

from models.csg import Cube, Torus
from models.csg import Cylinder as Bar
from models.solid import Solid
from primitives.pose import pose
from primitives.shapes import Cylinder, Plane
from primitives.shapes import Torus as Ring
from recognition.assembly.filleted import filleted
from recognition.assembly.made import Known
from recognition.assembly.piece import Piece, tree_of

FACET = 0.01
X, Y, Z = np.eye(3)
NONE = np.empty((0, 3))


def piece(kind, operation, solid, at):
    return Piece(kind, operation, solid, pose(None, at), None, ((None, None),))


def known(shapes, places, felt=NONE):
    lots = [*places, felt]
    return Known([*shapes, Plane([0, 0, -90], Z)], lots, [True] * len(places) + [False], NONE)


def ring_places(radius, size):
    turn, lean = (lot.ravel() for lot in np.meshgrid(np.arange(0, 6.2, 0.3), np.deg2rad([10.0, 45.0, 80.0])))
    off = radius + size - size * np.sin(lean)
    return np.column_stack([off * np.cos(turn), off * np.sin(turn), size - size * np.cos(lean)])


@pytest.mark.parametrize("bore", [False, True])
def test_a_post_on_a_plate_gets_its_fillet_and_keeps_its_bore(bore):
    body = [
        piece("cylinder", "add", Bar(40.0, 10.0), [0, 0, -5]),
        piece("cylinder", "add", Bar(12.0, 40.0), [0, 0, 20]),
    ]
    body += [piece("cylinder", "subtract", Bar(6.0, 100.0), [0, 0, 0])] if bore else []
    shapes = [Ring([0, 0, 5], Z, 17.0, 5.0), Plane([0, 0, 0], Z), Cylinder([0, 0, 20], Z, 12.0)]
    made = filleted(tuple(body), known(shapes, [ring_places(12.0, 5.0), NONE, NONE]), FACET)
    assert [p.kind for p in made if all(p is not old for old in body)] == ["cylinder", "torus"]
    tree = Bar(40.0, 10.0).at(0, 0, -5) | Bar(12.0, 40.0).at(0, 0, 20) | (
        Bar(17.0, 5.0).at(0, 0, 2.5) - Torus(17.0, 5.0).at(0, 0, 5)
    )  # fmt: skip
    wanted = Solid.from_csg(tree - Bar(6.0, 100.0) if bore else tree, FACET)
    assert Solid.from_csg(tree_of(made), FACET).volume == pytest.approx(wanted.volume, rel=1e-3)


def test_a_wall_on_a_floor_gets_a_square_bar_less_a_round_one():
    body = (
        piece("cube", "add", Cube((60, 60, 10)), [0, 0, -5]),
        piece("cube", "add", Cube((10, 60, 40)), [-25, 0, 20]),
    )
    lean = np.deg2rad([10.0, 45.0, 80.0])
    across = np.column_stack([-20.0 + 4.0 - 4.0 * np.sin(lean), 0.0 * lean, 4.0 - 4.0 * np.cos(lean)])
    places = np.concatenate([across + y * Y for y in np.linspace(-29.0, 29.0, 13)])
    shapes = [Cylinder([-16, 0, 4], Y, 4.0), Plane([0, 0, 0], Z), Plane([-20, 0, 0], X)]
    made = filleted(body, known(shapes, [places, NONE, NONE]), FACET)
    assert [(p.kind, p.operation) for p in made[2:]] == [("cube", "add"), ("cylinder", "subtract")]
    gained = Solid.from_csg(tree_of(made), FACET).volume - Solid.from_csg(tree_of(body), FACET).volume
    assert gained == pytest.approx(58.0 * 16.0 * (1.0 - np.pi / 4.0), rel=0.02)


def test_nothing_is_added_where_the_body_has_it_where_faces_do_not_meet_or_where_it_would_bury_what_was_felt():
    plate, stub = (
        piece("cylinder", "add", Bar(40.0, 10.0), [0, 0, -5]),
        piece("cylinder", "add", Bar(12.0, 40.0), [0, 0, 20]),
    )
    ring, foot, wall = Ring([0, 0, 5], Z, 17.0, 5.0), Plane([0, 0, 0], Z), Cylinder([0, 0, 20], Z, 12.0)
    lots = [ring_places(12.0, 5.0), NONE, NONE]
    once = filleted((plate, stub), known([ring, foot, wall], lots), FACET)
    assert filleted(once, known([ring, foot, wall], lots), FACET) == once
    for shapes in ([ring, Plane([0, 0, -3], Z), wall], [ring, foot, Cylinder([5, 0, 20], Z, 12.0)]):
        assert filleted((plate, stub), known(shapes, lots), FACET) == (plate, stub)
    turn = np.arange(0.0, 6.2, 0.4)
    felt = np.column_stack([14.0 * np.cos(turn), 14.0 * np.sin(turn), 0.0 * turn])
    assert filleted((plate, stub), known([ring, foot, wall], lots, felt), FACET) == (plate, stub)
