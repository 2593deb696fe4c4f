"""Flats that are touches of one low rim, and those that are not."""

import numpy as np
import pytest

from exploration.planning.faces.low_rims import whole_rims
from primitives.evidence import Contacts
from primitives.patch_graph import Face, MergeOptions, PatchGraph, ranked_face

UP = np.array([0.0, 0.0, 1.0])
OPTIONS = MergeOptions()


def base():
    """The face below, which tells the axis."""
    grid = np.stack(np.meshgrid(np.arange(-12.0, 13.0, 3.0), np.arange(-12.0, 13.0, 3.0)), axis=-1).reshape(
        -1, 2
    )
    points = np.column_stack([grid, np.zeros(len(grid))])
    return ranked_face(0, Contacts.of(points, np.tile(-UP, (len(points), 1))), OPTIONS)


def touch(number, place, angle, rng):
    """A strip 4 mm high that was felt as flat, about a (2,) place that looks along an angle [rad]."""
    way = np.array([np.cos(angle), np.sin(angle), 0.0])
    along = np.array([-way[1], way[0], 0.0])
    spots = [[a, z] for a in (-1.2, 1.2) for z in (2.0, 4.0)]
    points = np.array([[*place, 0.0] + a * along + z * UP for a, z in spots])
    off = rng.normal(0.0, 0.02)
    seen = angle + rng.normal(0.0, 0.03)
    normal = np.array([np.cos(seen), np.sin(seen), 0.0])
    return ranked_face(
        number, Contacts.of(points + off * way, np.tile(normal, (4, 1)), touch=number), OPTIONS
    )


def rims(flats):
    graph = PatchGraph((base(), *flats), (), OPTIONS)
    return graph, [face for face in whole_rims(graph)[0].faces if face.id]


def disc(angles, radius=13.0, center=(3.0, -2.0), seed=0, first=1):
    rng = np.random.default_rng(seed)
    places = [np.array(center) + radius * np.array([np.cos(a), np.sin(a)]) for a in angles]
    return [touch(first + k, place, a, rng) for k, (place, a) in enumerate(zip(places, angles, strict=True))]


def prism(corners, shares, seed=0):
    """One touch of each side of a polygon, a share of the way along it."""
    rng, found = np.random.default_rng(seed), []
    for k, (one, other, share) in enumerate(zip(corners, np.roll(corners, -1, axis=0), shares, strict=True)):
        line = other - one
        found.append(touch(1 + k, one + share * line, np.arctan2(-line[0], line[1]), rng))
    return found


def regular(sides, radius=13.0):
    t = 2.0 * np.pi * np.arange(sides) / sides
    return radius * np.column_stack([np.cos(t), np.sin(t)])


@pytest.mark.parametrize("seed", range(4))
def test_touches_of_a_low_disc_are_its_rim(seed):
    graph, (rim,) = rims(disc(np.array([0.3, 1.1, 2.7, 3.9, 5.1]), seed=seed))
    assert isinstance(rim, Face)
    assert rim.fit.kind == "cylinder"
    assert rim.fit.convex
    assert rim.fit.shape.radius == pytest.approx(13.0, abs=0.15)
    assert len(rim.contacts) == 20
    assert whole_rims(graph)[1] == {2: 1, 3: 1, 4: 1, 5: 1}


def test_discs_beside_each_other_are_two_rims():
    flats = [*disc([0.3, 1.1, 2.7, 3.9, 5.1]), *disc([0.1, 1.0, 2.7, 3.8, 5.3], 9.0, (60.0, 0.0), first=9)]
    _, found = rims(flats)
    assert sorted(round(rim.fit.shape.radius) for rim in found) == [9, 13]


@pytest.mark.parametrize("sides", [3, 4, 5, 6])
def test_the_middles_of_a_regular_polygon_s_sides_are_hardly_ever_a_rim(sides):
    mistaken = 0
    for seed in range(20):
        graph, found = rims(prism(regular(sides), np.full(sides, 0.5), seed))
        mistaken += len(found) < len(graph.faces) - 1
    assert mistaken <= 1


def test_sides_of_any_triangle_felt_somewhere_are_no_rim():
    for seed in range(20):
        rng = np.random.default_rng(seed)
        corners = regular(3, 20.0) + rng.uniform(-6.0, 6.0, (3, 2))
        shares = rng.choice([0.2, 0.3, 0.7, 0.8], 3)
        _, found = rims(prism(corners, shares, seed))
        assert all(face.fit.kind == "plane" for face in found)


def test_two_touches_say_nothing():
    _, found = rims(disc([0.3, 2.0]))
    assert [face.fit.kind for face in found] == ["plane", "plane"]
