"""Inferred walls among the faces that were felt."""

import numpy as np
import pytest

from exploration.planning.inferring.adding import add, straightened
from exploration.planning.touching.findings import Findings
from primitives.evidence import NOT_FELT, Contacts
from primitives.patch_graph import MergeOptions, PatchGraph, ranked_face

X, Y, Z = np.eye(3)


def felt_side():
    points = np.array([[0.0, y, z] for y in range(0, 60, 6) for z in range(0, 30, 6)])
    return ranked_face(0, Contacts.of(points, np.tile(X, (len(points), 1)), 0.01, 0.01), MergeOptions())


def rim_wall(x, y, normal=X):
    """As one rim tells of a wall: many places a few mm apart, all off by the same."""
    points = np.array([[x, y + a, 2.0 + b] for a in range(-3, 4) for b in range(6)])
    return Contacts.of(points, np.tile(normal, (len(points), 1)), 0.1, 0.02, touch=NOT_FELT)


def test_a_wall_of_several_rims_stands_parallel_to_a_felt_face_however_each_of_them_errs():
    found = Findings(graph=PatchGraph(faces=(felt_side(),)))
    for x, y in ((20.1, 5.0), (19.9, 25.0), (20.15, 45.0)):
        fit = add(found, rim_wall(x, y), "why")
    assert len(found.graph.faces) == 2
    assert abs(float(fit.shape.normal @ X)) == pytest.approx(1.0, abs=1e-9)
    assert float(abs(fit.shape.origin @ X)) == pytest.approx(20.05, abs=0.02)
    again = ranked_face(
        1, found.graph.faces[1].contacts, MergeOptions()
    )  # as whoever reconstructs it fits it
    assert abs(float(again.fit.shape.direction @ X)) == pytest.approx(1.0, abs=1e-9)


def flat(number, normal, at):
    u = np.cross(normal, Y if abs(normal @ Y) < 0.7 else X)
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    points = at + np.array([a * u + b * v for a in range(0, 30, 6) for b in range(0, 30, 6)])
    return ranked_face(number, Contacts.of(points, np.tile(normal, (25, 1)), 0.01, 0.01), MergeOptions())


def test_a_wall_across_two_felt_faces_that_are_square_stands_across_both():
    found = Findings(graph=PatchGraph(faces=(flat(0, Y, 60.0 * Y), flat(1, Z, 30.0 * Z))))
    for x, y in ((20.1, 5.0), (19.9, 25.0), (20.15, 45.0)):
        fit = add(found, rim_wall(x, y), "why")
    assert abs(float(fit.shape.normal @ X)) == pytest.approx(1.0, abs=1e-6)
    lot = rim_wall(20.0, 5.0)
    aslant = np.array([0.0, 0.96, 0.28])
    assert straightened(lot, [flat(0, Y, 60.0 * Y), flat(1, aslant, 30.0 * Z)]) is lot


def test_one_that_is_parallel_to_none_or_leans_by_more_than_rims_err_is_left_as_it_is():
    leaning = np.array([np.cos(0.1), np.sin(0.1), 0.0])
    lot = rim_wall(20.0, 5.0, leaning)
    assert straightened(lot, [felt_side()]) is lot
    assert straightened(lot, []) is lot
    high = np.array([[20.0 + 0.05 * z, 5.0 + y, float(z)] for z in range(0, 60, 5) for y in range(6)])
    drafted = Contacts.of(high, np.tile([1.0, 0.0, -0.05], (len(high), 1)), 0.1, 0.02, touch=NOT_FELT)
    assert straightened(drafted, [felt_side()]) is drafted


def test_where_no_felt_face_is_parallel_later_rims_turn_a_wall():
    found = Findings(graph=PatchGraph(faces=(felt_side(),)))
    way = np.array([np.sin(0.5), np.cos(0.5), 0.0])
    along, wrong = np.cross(Z, way), way + 0.03 * np.cross(Z, way)
    for k, normal in enumerate((wrong / np.linalg.norm(wrong), way, way, way)):
        places = np.array(
            [30.0 * way + (8.0 * k + a) * along + b * Z for a in range(-3, 4) for b in range(6)]
        )
        fit = add(found, Contacts.of(places, np.tile(normal, (42, 1)), 0.1, 0.02, touch=NOT_FELT), "why")
    assert abs(float(fit.shape.normal @ way)) > np.cos(0.005)


def round_hole(radius, turns, touch, center=(0.0, 0.0), sigma=0.01, off=0.0):
    """A hole's wall along z, over some of its turn [rad], felt or told by its rims."""
    around, up = (grid.ravel() for grid in np.meshgrid(np.linspace(*turns, 9), np.linspace(0.0, 20.0, 6)))
    out = np.column_stack([np.cos(around), np.sin(around), np.zeros(len(around))])
    noise = np.random.default_rng(0).normal(scale=off, size=(len(out), 1))
    points = (radius + noise) * out + [*center, 0.0] + np.outer(up, Z)
    return Contacts.of(points, -out, sigma, 0.01, touch=touch)


def test_rims_of_a_hole_of_which_one_side_was_felt_add_no_second_wall():
    felt = ranked_face(0, round_hole(26.0, (-0.4, 0.4), touch=1, sigma=0.05, off=0.05), MergeOptions())
    found = Findings(graph=PatchGraph(faces=(felt,)))
    rims = round_hole(26.25, (-np.pi, np.pi), NOT_FELT, center=(-0.1, 0.0), sigma=0.085)
    add(found, rims, "why", "cylinder")
    assert len(found.graph.faces) == 1
    other = round_hole(20.0, (-np.pi, np.pi), NOT_FELT, sigma=0.085)  # a ledge lies between these two
    add(found, other, "why", "cylinder")
    assert len(found.graph.faces) == 2
