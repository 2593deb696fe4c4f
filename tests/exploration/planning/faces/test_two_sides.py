"""Two narrow sides of a plate are no bar as thick as the plate."""

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
    touch = np.arange(2 * each) // 2
    return Contacts.of(points, sign[:, None] * [0.0, 1.0, 0.0], sigma=0.06, normal_sigma=0.1, touch=touch)


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
    graph = take_in(
        PatchGraph(options=CONVEX), plate.select(slice(0, 10)), plate.select(slice(10, 12)), HOLLOW
    ).graph
    assert all(face.fit.kind == "plane" for face in graph.faces)
    graph = name_loose(PatchGraph(options=CONVEX), plate, HOLLOW).graph
    assert all(face.fit.kind == "plane" for face in graph.faces)


def test_a_bar_felt_from_three_ways_is_one() -> None:
    face = ranked_face(0, of_a_bar((0.0, 2.0, 4.0)), CONVEX)
    assert isinstance(face.fit, Fit)
    assert face.fit.kind == "cylinder"
    assert not two_sides(face)
