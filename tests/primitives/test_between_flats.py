"""Roundings between flat faces, from what a pad felt of them on its way over."""

from itertools import combinations, product

import numpy as np
import pytest

from primitives.between_flats import between_flats
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from primitives.patch_graph import Face, MergeOptions, PatchGraph, ranked_face

HALF = np.array([40.0, 25.0, 16.0])
RADIUS = 6.0
SIDES = [s * np.eye(3)[k] for k in range(3) for s in (1.0, -1.0)]


def flat(number, normal, border):
    """A side of a box about the origin, felt but for its border."""
    k = int(np.argmax(np.abs(normal)))
    reach = HALF - border
    spots = [np.linspace(-reach[i], reach[i], 6) if i != k else [HALF[k] * normal[k]] for i in range(3)]
    points = np.array(list(product(*spots)))
    return ranked_face(number, Contacts.of(points, np.tile(normal, (len(points), 1)), 0.02), MergeOptions())


def on_edge(one, other, leans=(0.3, 0.5, 0.7), count=4):
    """(n, 3) places of the rounding between two sides, and (n, 3) normals."""
    along = np.abs(np.cross(one, other))
    ways = np.array([np.cos(np.pi / 2 * s) * one + np.sin(np.pi / 2 * s) * other for s in leans])
    rows = np.outer(np.linspace(-1.0, 1.0, count) * ((HALF - 12.0) @ along), along)
    middle = (HALF - RADIUS) * (one + other)
    return (middle + rows)[:, None].repeat(len(ways), 1).reshape(-1, 3) + np.tile(
        RADIUS * ways, (count, 1)
    ), np.tile(ways, (count, 1))


def face_of(number, *edges, kind="cylinder"):
    lot = Contacts.of(*(np.concatenate(rows) for rows in zip(*edges, strict=True)), 0.02)
    return Face(number, fit(kind, lot), lot)


def box(border=RADIUS + 1.0):
    return [flat(k, normal, border) for k, normal in enumerate(SIDES)]


def radii(graph):
    return sorted(face.fit.shape.radius for face in graph.faces if face.fit and face.fit.kind == "cylinder")


def test_what_was_taken_for_one_cylinder_over_two_edges_is_two_roundings():
    up, down, side = SIDES[4], SIDES[5], SIDES[0]
    merged = face_of(6, on_edge(up, side), on_edge(down, side))
    made = between_flats(PatchGraph((*box(border=1.0), merged)))
    assert all(face.id != 6 for face in made.faces)
    assert radii(made) == pytest.approx([RADIUS, RADIUS], abs=0.02)
    felt = [int((face.contacts.touch != NOT_FELT).sum()) for face in made.faces if face.id > 6]
    assert felt == [12, 12]


def test_edges_that_nobody_was_on_are_rounded_as_the_others_where_both_faces_end_early():
    seen = face_of(6, on_edge(SIDES[4], SIDES[0]))
    assert len(radii(between_flats(PatchGraph((*box(), seen))))) == 12
    assert len(radii(between_flats(PatchGraph((*box(border=1.0), seen))))) == 1


def test_a_bevel_and_an_edge_that_is_sharp_are_no_roundings():
    bevel = face_of(6, on_edge(SIDES[4], SIDES[0], leans=(0.5, 0.52), count=8), kind="plane")
    graph = PatchGraph((*box(border=1.0), bevel))
    assert between_flats(graph) is graph
    sharp = PatchGraph(tuple(box()))
    assert between_flats(sharp) is sharp


@pytest.mark.parametrize("off", [0.03, 0.1])
def test_a_wide_bevel_is_none_however_well_its_middle_lies_on_a_rounding(off):
    along, out = np.eye(3)[1], np.array([1.0, 0.0, 1.0]) / np.sqrt(2.0)
    middle = HALF * [1.0, 0.0, 1.0] - 2.5 * np.array([1.0, 0.0, 1.0])
    places = [
        middle + x * np.cross(along, out) + y * along for x in (-1.6, 0.0, 1.6) for y in (-9.0, 0.0, 9.0)
    ]
    noise = np.random.default_rng(0).normal(scale=off, size=(9, 1))
    wide = face_of(6, (np.array(places) + noise * out, np.tile(out, (9, 1))), kind="plane")
    graph = PatchGraph((*box(border=1.0), wide))
    assert between_flats(graph) is graph


def test_an_edge_that_nobody_was_on_is_not_rounded_where_a_bevel_or_a_ledge_was_felt_in_its_place():
    seen, up, side = face_of(9, on_edge(SIDES[4], SIDES[0])), SIDES[4], SIDES[2]
    spots = np.linspace(-39.0, 39.0, 9)
    for depth, leans in ((8.0, True), (1.0, False)):
        out = (up + side) / np.sqrt(2.0) if leans else up
        across = np.cross(out, np.eye(3)[0])
        middle = HALF * (up + side) - 0.5 * depth * (up + side)
        rows = (-3.0, 0.0, 3.0) if leans else (0.0, -1.5, 1.5)
        places = [middle + x * np.eye(3)[0] + y * across for x in spots for y in rows]
        felt = Contacts.of(np.array(places), np.tile(out, (27, 1)), 0.02)
        graph = PatchGraph((*box(), seen, ranked_face(10, felt, MergeOptions())))
        assert len(radii(between_flats(graph))) == 11


def test_contacts_that_tell_different_radii_are_of_no_rounding():
    points, normals = on_edge(SIDES[4], SIDES[0])
    bent = points + 1.5 * np.sin(np.arange(len(points)))[:, None] * normals
    graph = PatchGraph((*box(border=1.0), face_of(6, (bent, normals))))
    assert between_flats(graph) is graph


def test_each_of_many_edges_gets_its_own_contacts():
    pairs = [(a, b) for a, b in combinations(SIDES, 2) if abs(a @ b) < 0.5]
    rolled = [face_of(6 + k, on_edge(a, b)) for k, (a, b) in enumerate(pairs)]
    made = between_flats(PatchGraph((*box(), *rolled)))
    assert radii(made) == pytest.approx([RADIUS] * 12, abs=0.02)
    assert len(made.faces) == 18
