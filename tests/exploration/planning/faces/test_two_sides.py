"""Two narrow sides of a plate are no bar as thick as the plate."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.planning.faces.attribution import CONVEX, AttributionConfig, name_loose, take_in
from exploration.planning.faces.two_sides import two_sides
from primitives.evidence import Contacts
from primitives.fit import Fit
from primitives.patch_graph import PatchGraph, ranked_face
from primitives.shapes import Cylinder

NONE = Contacts.of(np.empty((0, 3)))
HOLLOW = AttributionConfig(convex=False)


def of_a_plate(seed: int, each: int = 6) -> Contacts:
    """Contacts of sides at y = -10.5 and 10.5, 2 mm high, three touches of each."""
    rng = np.random.default_rng(seed)
    sign = np.repeat([1.0, -1.0], each)
    points = np.column_stack([rng.uniform(-12, 12, 2 * each), 10.5 * sign, rng.uniform(-1, 1, 2 * each)])
    points[:, 1] += 0.02 * rng.standard_normal(2 * each)
    normals = sign[:, None] * [0.0, 1.0, 0.0] + 0.05 * rng.standard_normal((2 * each, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Contacts.of(points, normals, sigma=0.06, normal_sigma=0.1, touch=np.arange(2 * each) // 2)


def of_a_bar(azimuths: tuple[float, ...]) -> Contacts:
    bar = Cylinder([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], 10.5)
    at = np.repeat(azimuths, 3)
    points = np.column_stack(
        [np.tile([-12.0, 0.0, 12.0], len(azimuths)), 10.5 * np.cos(at), 10.5 * np.sin(at)]
    )
    return Contacts.of(
        points, bar.normals(points), sigma=0.06, normal_sigma=0.1, touch=np.arange(len(at)) // 3
    )


@pytest.mark.parametrize("seed", range(3))
def test_sides_of_a_plate_are_no_cylinder(seed: int) -> None:
    plate = of_a_plate(seed)
    face = ranked_face(0, plate, CONVEX)
    assert not isinstance(face.fit, Fit) or face.fit.kind == "cylinder"  # what they look like together
    assert two_sides(face)
    kinds = [face.fit.kind for face in _taken_in(plate).faces if isinstance(face.fit, Fit)]
    assert kinds == ["plane", "plane"]
    named = name_loose(PatchGraph(options=CONVEX), plate, HOLLOW)
    assert not named.graph.faces
    assert len(named.loose) == len(plate)


def _taken_in(contacts: Contacts) -> PatchGraph:
    """As touch after touch brings them, both sides in turn."""
    graph, loose = PatchGraph(options=CONVEX), NONE
    for touch in (0, 3, 1, 4, 2, 5):
        taken = take_in(graph, loose, contacts.select(contacts.touch == touch), HOLLOW)
        graph, loose = taken.graph, taken.loose
    return graph


@pytest.mark.parametrize("radius", [20.0, 45.0])
def test_a_wide_tube_felt_on_two_sides_is_one(radius: float) -> None:
    tube = Cylinder([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], radius)
    rng = np.random.default_rng(1)
    points = np.column_stack(
        [rng.uniform(-12, 12, 24), np.repeat([radius, -radius], 12), rng.uniform(-5, 5, 24)]
    )
    points = tube.project(points)
    face = ranked_face(
        0, Contacts.of(points, tube.normals(points), 0.02, 0.02, touch=np.arange(24) // 4), CONVEX
    )
    assert isinstance(face.fit, Fit)
    assert face.fit.kind == "cylinder"
    assert not two_sides(face)
    nothing = replace(face, contacts=NONE)
    assert not two_sides(nothing)


def test_a_bar_felt_from_three_ways_is_one() -> None:
    face = ranked_face(0, of_a_bar((0.0, 2.0, 4.0)), CONVEX)
    assert isinstance(face.fit, Fit)
    assert face.fit.kind == "cylinder"
    assert not two_sides(face)
