"""Flats that are facets of one round face."""

import sys
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from exploration.planning.faces.faceted import rounded
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.fit import Fit, fit
from primitives.patch_graph import Face, MergeOptions, PatchGraph, ranked_face
from primitives.pose import pose, random_rotation, rotate, transform_points
from primitives.shapes import Cone, Cylinder, Sphere

WORLD = pose(random_rotation(np.random.default_rng(3)), [12.0, -40.0, 7.0])
NOISE = 0.02  # [mm]


def facet(number: int, corners: Floats, inside: Floats) -> Face:
    """Felt all over a convex flat of (n, 3) corners that looks away from a (3,) place."""
    rng = np.random.default_rng(number)
    share = rng.dirichlet(np.ones(len(corners)), 24)
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal = normal / np.linalg.norm(normal)
    normal = normal * np.sign(normal @ (corners[0] - inside))
    points = share @ corners + np.outer(rng.normal(0.0, NOISE, 24), normal)
    leans = normal + rng.normal(0.0, 0.005, (24, 3))
    felt = transform_points(WORLD, points), rotate(WORLD, leans / np.linalg.norm(leans, axis=1)[:, None])
    return ranked_face(number, Contacts.of(*felt, NOISE, 0.005, touch=number), MergeOptions())


def frustum(sides: int, bottom: float, top: float, skip: int = 0, out: float = 1.0) -> list[Face]:
    """The sides of a frustum 40 mm tall, without some of them; from inside where `out` is -1."""
    turn = 2.0 * np.pi * np.arange(sides + 1) / sides
    ring = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(sides + 1)])
    low, high = bottom * ring, top * ring + [0.0, 0.0, 40.0]
    quads = [np.array([low[k], low[k + 1], high[k + 1], high[k]]) for k in range(skip, sides)]
    middle = np.array([0.0, 0.0, 20.0])
    return [facet(k, quad, middle if out > 0.0 else 3.0 * quad.mean(axis=0)) for k, quad in enumerate(quads)]


def lid(number: int, radius: float) -> Face:
    turn = np.linspace(0.0, 6.0, 12)
    corners = np.column_stack([radius * np.cos(turn), radius * np.sin(turn), np.full(12, 40.0)])
    return facet(number, corners, np.zeros(3))


def graph(faces: list[Face]) -> PatchGraph:
    return PatchGraph(faces=tuple(faces))


def fit_of(face: Face) -> Fit:
    assert isinstance(face.fit, Fit)
    return face.fit


@pytest.mark.parametrize(("sides", "skip"), [(24, 0), (16, 0), (30, 14), (24, 17)])
def test_a_ring_of_many_flats_is_one_cylinder_and_the_lid_stays_flat(sides: int, skip: int) -> None:
    found, gone = rounded(graph([*frustum(sides, 50.0, 50.0, skip), lid(99, 50.0)]))
    drum, top = found.faces
    shape = fit_of(drum).shape
    assert isinstance(shape, Cylinder)
    assert fit_of(drum).convex
    assert 50.0 * np.cos(np.pi / sides) - 0.1 < shape.radius < 50.1
    assert abs(float(shape.direction @ rotate(WORLD, np.array([[0.0, 0.0, 1.0]]))[0])) > 0.9999
    assert fit_of(top).kind == "plane"
    assert set(gone) | {drum.id} == set(range(sides - skip))
    assert set(gone.values()) == {drum.id}


@pytest.mark.parametrize("moved", [-400.0, -115.0, 0.0, 400.0])
def test_flats_that_lean_are_of_a_cone_wherever_it_is(monkeypatch: pytest.MonkeyPatch, moved: float) -> None:
    monkeypatch.setattr(sys.modules[__name__], "WORLD", WORLD @ pose(np.eye(3), [0.0, 0.0, moved]))
    (leaning,) = rounded(graph(frustum(24, 45.0, 30.0)))[0].faces
    shape = fit_of(leaning).shape
    assert isinstance(shape, Cone)
    assert np.rad2deg(shape.semi_angle) == pytest.approx(np.rad2deg(np.arctan(15.0 / 40.0)), abs=0.5)


def test_flats_that_look_inward_are_of_a_bore_and_of_one_too_flat_nothing_is_made() -> None:
    (bore,) = rounded(graph(frustum(24, 45.0, 45.0, out=-1.0)))[0].faces
    assert fit_of(bore).kind == "cylinder"
    assert not fit_of(bore).convex
    shallow = graph(frustum(24, 200.0, 45.0))
    assert rounded(shallow) == (shallow, {})


def test_a_drum_is_one_cylinder_beside_flats_that_make_nothing() -> None:
    shallow = frustum(24, 200.0, 45.0)
    drum = [replace(face, id=100 + face.id) for face in frustum(16, 50.0, 50.0)]
    found, gone = rounded(graph([*shallow, *drum]))
    assert len(found.faces) == 25
    assert set(gone.values()) == {100}


def test_teeth_are_no_cylinder() -> None:
    """Flanks of one hand are tangents of one circle, but were felt far from it."""
    turn = 2.0 * np.pi * np.arange(17) / 16
    ring = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(17)])
    up = np.array([0.0, 0.0, 40.0])
    pairs = [(50.0 * ring[k], 44.0 * ring[k + 1]) for k in range(16)]
    ratchet = graph([facet(k, np.array([a, b, b + up, a + up]), 0.5 * up) for k, (a, b) in enumerate(pairs)])
    assert rounded(ratchet) == (ratchet, {})


def test_nor_are_tips_of_teeth_with_the_floors_between_them() -> None:
    """Both are tangents of circles where they were felt, one 8 mm within the other."""
    up = np.array([0.0, 0.0, 40.0])

    def flat(number: int, turn: float, radius: float) -> Face:
        out, along = np.array([np.cos(turn), np.sin(turn), 0.0]), np.array([-np.sin(turn), np.cos(turn), 0.0])
        a, b = radius * out - 3.0 * along, radius * out + 3.0 * along
        return facet(number, np.array([a, b, b + up, a + up]), 0.5 * up)

    turns = 2.0 * np.pi * np.arange(16) / 16
    tips = [flat(k, turn, 50.0) for k, turn in enumerate(turns)]
    floors = [flat(16 + k, turn + np.pi / 16, 42.0) for k, turn in enumerate(turns)]
    gear = graph([*tips, *floors])
    assert rounded(gear) == (gear, {})
    assert len(rounded(graph(tips))[0].faces) == 1


def test_a_face_that_was_rounded_takes_in_what_facets_are_felt_later() -> None:
    faces = frustum(16, 50.0, 50.0)
    first, _ = rounded(graph(faces[:12]))
    later, more = rounded(graph([*first.faces, *faces[12:]]))
    (whole,) = later.faces
    assert set(more) == {12, 13, 14, 15}
    assert len(whole.contacts) == 16 * 24
    again, none = rounded(later)
    assert again is later
    assert none == {}


def test_facets_of_a_ball_are_one_sphere() -> None:
    ball = trimesh.creation.icosphere(subdivisions=2, radius=40.0)
    flats = [facet(k, corners, np.zeros(3)) for k, corners in enumerate(np.asarray(ball.triangles)[::4])]
    (found,) = rounded(graph(flats))[0].faces
    shape = fit_of(found).shape
    assert isinstance(shape, Sphere)
    assert 39.0 < shape.radius < 40.0


@pytest.mark.parametrize("sides", [4, 6, 8, 12])
def test_sides_of_a_polygon_stay_flat(sides: int) -> None:
    flats = graph(frustum(sides, 50.0, 50.0))
    assert rounded(flats) == (flats, {})


def test_so_do_four_flats_of_a_circle() -> None:
    few = graph(frustum(24, 50.0, 50.0, 20))
    assert rounded(few) == (few, {})


def test_what_else_was_felt_of_it_is_taken_too() -> None:
    faces = frustum(24, 50.0, 50.0)
    both = Contacts.concatenate([faces[0].contacts, faces[1].contacts])
    bent = ranked_face(77, both, MergeOptions())  # two facets under one pad
    found, gone = rounded(graph([*faces[2:], bent]))
    assert len(found.faces) == 1
    assert gone[77] == found.faces[0].id
    assert len(found.faces[0].contacts) == 24 * 24


def test_a_ring_that_is_taken_by_a_larger_one_leaves_no_id_behind() -> None:
    both = [*frustum(40, 49.8, 49.8), *(replace(face, id=100 + face.id) for face in frustum(16, 50.0, 50.0))]
    found, gone = rounded(graph(both))
    assert set(gone.values()) <= {face.id for face in found.faces}
    again, more = rounded(found)
    assert again is found
    assert more == {}


def ball(number: int, turns: Floats, touch: int) -> Face:
    """What pads wider than facets took for a sphere of 40 mm: its normals lean as the facets do."""
    rng = np.random.default_rng(number)
    ways = rng.normal(size=(len(turns), 3))
    ways = ways / np.linalg.norm(ways, axis=1)[:, None]
    leans = ways + turns * rng.choice([-1.0, 1.0], (len(turns), 1)) * np.roll(ways, 1, axis=1)
    leans = leans / np.linalg.norm(leans, axis=1)[:, None]
    points = (40.0 + rng.normal(0.0, 0.05, len(turns)))[:, None] * ways
    felt = Contacts.of(transform_points(WORLD, points), rotate(WORLD, leans), 0.05, 0.01, touch=touch)
    found = fit("sphere", felt)
    assert isinstance(found, Fit)
    return Face(number, found, felt)


def test_a_land_beside_a_coarse_knob_is_no_piece_of_it() -> None:
    knob, land = frustum(16, 50.0, 50.0), turned(99, 49.2, 40.0, 20.0)
    found, gone = rounded(graph([*knob, land]))
    assert len(found.faces) == 2
    assert 99 not in gone


def test_two_readings_of_one_ball_are_one_whose_place_no_facet_pulls() -> None:
    leaning = np.full((400, 1), 0.05)
    pulled = np.linalg.norm(fit_of(ball(0, leaning, 1)).shape.anchor - WORLD[:3, 3])
    found, gone = rounded(graph([ball(0, leaning, 1), ball(1, leaning, 2)]))
    (whole,) = found.faces
    assert gone in ({0: 1}, {1: 0})
    assert np.linalg.norm(fit_of(whole).shape.anchor - WORLD[:3, 3]) < min(0.02, 0.5 * pulled)


def test_a_smooth_ball_stays_as_it_is() -> None:
    smooth = graph([ball(0, np.zeros((100, 1)), 1)])
    assert rounded(smooth) == (smooth, {})


@pytest.mark.parametrize("length", [8.0, 30.0])
def test_so_do_lands_that_differ_by_a_hair(length: float) -> None:
    shaft = graph([turned(0, 20.0, 0.0, length), turned(1, 20.12, length, length)])
    assert rounded(shaft) == (shaft, {})


def turned(number: int, radius: float, low: float, length: float) -> Face:
    """A cylinder about the z axis."""
    rng = np.random.default_rng(number)
    turn = rng.uniform(0.0, 2.0 * np.pi, 80)
    ways = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(80)])
    points = radius * ways + np.outer(rng.uniform(low, low + length, 80), [0.0, 0.0, 1.0])
    felt = transform_points(WORLD, points), rotate(WORLD, ways)
    found = fit("cylinder", Contacts.of(*felt, 0.02, 0.01, touch=number))
    assert isinstance(found, Fit)
    return Face(number, found, Contacts.of(*felt, 0.02, 0.01, touch=number))


def test_all_that_was_felt_is_one_ball_where_pads_spanned_facets_here_and_there() -> None:
    """Ten patches of it, whose normals lean; of an egg they may be anything."""
    rng = np.random.default_rng(5)
    corners = np.array([[1, 1, 1], [-1, -1, 1], [1, -1, -1], [-1, 1, -1]]) / np.sqrt(3.0)

    def patches(stretch: float) -> PatchGraph:
        made = []
        for k, way in enumerate([*np.eye(3), *-np.eye(3), *corners]):
            ways = way + 0.15 * rng.normal(size=(30, 3))
            ways = ways / np.linalg.norm(ways, axis=1)[:, None]
            points = (45.0 - rng.uniform(0.0, 0.4, 30))[:, None] * ways * [1.0, 1.0, stretch]
            leans = ways + rng.normal(0.0, 0.06, (30, 3))
            felt = points, leans / np.linalg.norm(leans, axis=1)[:, None]
            made.append(ranked_face(k, Contacts.of(*felt, 0.02, 0.01, touch=k), MergeOptions()))
        return graph(made)

    (whole,) = rounded(patches(1.0))[0].faces
    shape = fit_of(whole).shape
    assert isinstance(shape, Sphere)
    assert shape.radius == pytest.approx(44.8, abs=0.1)
    assert np.linalg.norm(shape.anchor) < 0.1
    assert len(rounded(patches(1.1))[0].faces) > 1
