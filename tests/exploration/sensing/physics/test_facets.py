"""Merged facets are the mesh that they were made from, and fewer."""

import numpy as np
import pytest

from exploration.sensing.physics.facets import facets_of
from models.csg import Cube, Cylinder, Prism, Torus
from models.solid import Solid

ELL = ((0.0, 0.0), (30.0, 0.0), (30.0, 10.0), (10.0, 10.0), (10.0, 30.0), (0.0, 30.0))
BODIES = {
    "cube": Cube((30.0, 20.0, 10.0)),
    "disc": Cylinder(20.0, 5.0),
    "ring": Torus(20.0, 6.0),
    "ell": Prism(ELL, 10.0),
    "bored": Cube((30.0, 20.0, 10.0)) - Cylinder(5.0, 20.0),
}


def loops(facets):
    return np.split(facets.loop, facets.start[1:-1])


def areas(facets):
    """(f, 3) area of each facet along its own winding."""
    fans = [np.cross(loop[1:-1] - loop[0], loop[2:] - loop[0]).sum(axis=0) for loop in loops(facets)]
    return 0.5 * np.array(fans)


@pytest.mark.parametrize("name", BODIES)
def test_facets_have_the_area_of_the_mesh_and_look_out_of_it(name):
    solid = Solid.from_csg(BODIES[name])
    facets = facets_of(solid)
    own = areas(facets)
    assert np.linalg.norm(own, axis=1).sum() == pytest.approx(solid.area, rel=1e-9)
    assert np.abs(own / np.linalg.norm(own, axis=1)[:, None] - facets.normals).max() < 1e-5


def test_a_cap_is_one_facet_and_a_side_of_two_triangles_too():
    facets = facets_of(Solid.from_csg(BODIES["disc"]))
    corners = np.sort(np.diff(facets.start))
    assert set(corners[:-2].tolist()) == {4}
    assert corners[-1] == corners[-2] == len(corners) - 2


def test_a_ring_has_half_as_many_facets_as_triangles():
    solid = Solid.from_csg(BODIES["ring"])
    assert len(facets_of(solid).normals) == len(solid.triangles) / 2


def test_a_face_that_is_not_convex_or_has_a_hole_stays_in_triangles():
    for name in ("ell", "bored"):
        facets = facets_of(Solid.from_csg(BODIES[name]))
        flat = np.abs(facets.normals[:, 2]) > 0.999
        assert flat.sum() > 2
        assert set(np.diff(facets.start)[flat].tolist()) == {3}


@pytest.mark.parametrize("name", BODIES)
def test_every_facet_is_convex(name):
    facets = facets_of(Solid.from_csg(BODIES[name]))
    for loop, normal in zip(loops(facets), facets.normals, strict=True):
        sides = np.roll(loop, -1, axis=0) - loop
        assert (np.cross(sides, np.roll(sides, -1, axis=0)) @ normal).min() > -1e-6
