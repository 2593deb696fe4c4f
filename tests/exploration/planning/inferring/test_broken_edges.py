"""Chamfers and roundings between faces whose pictures show them."""

from itertools import product

import numpy as np
import pytest

from exploration.planning.inferring.broken_edges import broken_edges
from exploration.planning.known.mosaic import Lain
from exploration.sensing.lines.edge_profiles import pressed
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from primitives.patch_graph import Face, MergeOptions, ranked_face

SPREAD, SIGMA = 1.1, 0.02
BOX = np.array([60.0, 44.0, 30.0])
SIDES = [s * np.eye(3)[k] for k in range(3) for s in (1.0, -1.0)]


def flat(number, normal, low=7.0):
    """A side of the box, felt but for its border."""
    k = int(np.argmax(np.abs(normal)))
    spots = [np.linspace(low, BOX[i] - low, 6) if i != k else [BOX[k] * (normal[k] > 0)] for i in range(3)]
    points = np.array(list(product(*spots)))
    return ranked_face(number, Contacts.of(points, np.tile(normal, (len(points), 1)), 0.02), MergeOptions())


class Pictures:
    """Stands for a mosaic: taxels all over each face and past its ends, as an edge of one kind presses on them."""

    def __init__(self, kind, size, inside_of):
        self.kind, self.size, self.inside_of, self.rng = kind, size, inside_of, np.random.default_rng(5)

    def flush(self, anchor, normal):
        places = self.rng.uniform(-3.0, BOX + 3.0, (4000, 3))
        places -= np.outer((places - anchor) @ normal, normal)
        inside, found = self.inside_of(places, normal), []
        for before in (0.5, 0.9, 1.3):
            told = np.full(len(places), before)
            depth = pressed(self.kind, self.size, SPREAD, inside, told) + SIGMA * self.rng.standard_normal(
                len(places)
            )
            found.append(Lain(places, told, depth, np.full(len(places), SIGMA), SPREAD))
        return found


def from_border(places, normal):
    """[mm] inside of the nearest border of a side of the box."""
    across = [k for k in range(3) if abs(normal[k]) < 0.5]
    return np.min([np.minimum(places[:, k], BOX[k] - places[:, k]) for k in across], axis=0)


def test_all_edges_of_a_chamfered_box_are_planes_between_its_sides():
    faces = [flat(number, normal) for number, normal in enumerate(SIDES)]
    found = broken_edges(faces, Pictures("chamfer", 1.5, from_border))
    assert len(found) == 12
    for edge in found:
        assert edge.kind == "chamfer"
        assert edge.size == pytest.approx(1.5, abs=0.15)
        made = fit(edge.shape, edge.contacts)
        assert made.kind == "plane"
        assert np.sort(np.abs(made.shape.normal)) == pytest.approx(
            [0.0, np.sqrt(0.5), np.sqrt(0.5)], abs=1e-6
        )
        assert (edge.contacts.touch == NOT_FELT).all()
        legs = np.sort([np.minimum(p, BOX - p) for p in edge.contacts.points], axis=1)[:, :2].sum(axis=1)
        assert legs == pytest.approx(edge.size, abs=1e-6)


def test_all_edges_of_a_rounded_box_are_cylinders_that_touch_its_sides():
    faces = [flat(number, normal) for number, normal in enumerate(SIDES)]
    found = broken_edges(faces, Pictures("rounding", 3.0, from_border))
    assert [edge.kind for edge in found] == ["rounding"] * 12
    for edge in found:
        made = fit(edge.shape, edge.contacts)
        assert made.shape.radius == pytest.approx(3.0, abs=0.15)
        assert made.convex
        middle = np.minimum(made.shape.anchor, BOX - made.shape.anchor)
        assert np.sort(middle)[:2] == pytest.approx(made.shape.radius, abs=1e-3)


def test_a_sharp_box_and_edges_whose_faces_are_known_have_none():
    faces = [flat(number, normal) for number, normal in enumerate(SIDES)]
    assert broken_edges(faces, Pictures("chamfer", 0.0, from_border)) == []
    pictures = Pictures("chamfer", 2.0, from_border)
    first = broken_edges(faces, pictures)
    known = [Face(10 + k, fit(edge.shape, edge.contacts), edge.contacts) for k, edge in enumerate(first[:5])]
    assert len(broken_edges([*faces, *known], pictures)) == len(first) - 5


@pytest.mark.parametrize("convex", [True, False])
def test_the_end_of_a_shaft_and_the_mouth_of_a_hole_are_cones(convex):
    middle, radius = np.array([30.0, 22.0, 0.0]), 18.0 if convex else 9.0
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    out = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])
    wall = np.concatenate([middle + radius * out + [0.0, 0.0, 30.0 - deep] for deep in (6.0, 12.0, 18.0)])
    facing = np.tile(out if convex else -out, (3, 1))
    shaft = ranked_face(1, Contacts.of(wall, facing, 0.02), MergeOptions())
    top = flat(0, SIDES[4])
    away = np.linalg.norm(top.contacts.points[:, :2] - middle[:2], axis=1)
    top = top.only(away < radius - 2.0 if convex else away > radius + 2.0)

    def from_rim(places, normal):
        away = np.linalg.norm(places[:, :2] - middle[:2], axis=1)
        return radius - away if convex else away - radius

    (edge,) = broken_edges([top, shaft], Pictures("chamfer", 1.5, from_rim))
    cone = fit(edge.shape, edge.contacts)
    assert (edge.kind, cone.kind) == ("chamfer", "cone")
    assert cone.shape.semi_angle == pytest.approx(0.25 * np.pi, abs=1e-3)
    assert cone.convex == convex
    at_top = np.linalg.norm(cone.shape.apex[:2] - middle[:2]), abs(cone.shape.apex[2] - 30.0)
    assert at_top == pytest.approx((0.0, radius - edge.size if convex else radius + edge.size), abs=0.02)
