"""Modes of one round face share the room that one contact has there, whether edges hold them or not."""

import numpy as np
import pytest

from models.csg import Cube, Cylinder
from models.library import Library
from models.solid import Solid
from primitives.evidence import Contacts
from primitives.pose import exp, inverse, pose, transform_points
from primitives.shapes import Cone, Sphere, Torus
from primitives.shapes import Cylinder as Round
from recognition.matching import Hypothesis
from recognition.matching.align import refine
from recognition.matching.facets import facets_of
from recognition.matching.room import Lone
from recognition.matching.round_room import rooms_round, sliding
from recognition.matching.span import spread_of
from recognition.matching.target import target_of

AXIS = np.array([0.6, 0.0, 0.8])
ORIGIN = np.array([5.0, -8.0, 3.0])
PIN = Library.of(
    {"pin": Solid.from_csg(Cylinder(10.0, 60.0) | Cube((80.0, 80.0, 20.0)).at(0.0, 0.0, -40.0))}
)["pin"]


@pytest.mark.parametrize("shape", [
    Round(ORIGIN, AXIS, 12.0), Sphere(ORIGIN, 12.0), Cone(ORIGIN, AXIS, 0.3), Torus(ORIGIN, AXIS, 20.0, 6.0),
])  # fmt: skip
def test_twists_that_slide_leave_the_shape_as_it_is(shape):
    rng = np.random.default_rng(0)
    middle, points = rng.normal(size=3) * 20.0, ORIGIN + rng.normal(size=(40, 3)) * 15.0
    before = shape.signed_distance(points)
    for twist in sliding(shape, middle):
        motion = pose(translation=middle) @ exp(0.3 * twist) @ pose(translation=-middle)
        assert np.allclose(shape.signed_distance(transform_points(motion, points)), before, atol=1e-9)


def test_an_edge_that_holds_a_pose_along_the_face_takes_none_of_its_room():
    rng = np.random.default_rng(0)
    around, height = rng.uniform(0.0, 2.0 * np.pi, 40), rng.uniform(-10.0, 10.0, 40)
    normals = np.column_stack([np.cos(around), np.sin(around), np.zeros(40)])
    points, target = 10.0 * normals + height[:, None] * [0.0, 0.0, 1.0], target_of(PIN)
    shape = Round(np.zeros(3), np.array([0.0, 0.0, 1.0]), 10.0)
    poses = np.stack([pose(translation=[0.0, 0.0, z])[:3] for z in (0.0, 8.0, 0.0)])
    poses[2, :, 3] = [0.0, 30.0, -40.0]  # beside the pin
    seen, each = Contacts.of(points, normals, 0.3, 0.04), np.ones(40)
    told = refine(poses.copy(), seen.points, seen.normals, each > 0, seen.sigma, seen.normal_sigma, each,
                  facets_of(PIN.solid.body), 1.0, 0).information  # fmt: skip
    held = told.copy()
    held[0, 2, 2] += 100.0
    worlds = [np.vstack([at, [0.0, 0.0, 0.0, 1.0]]) for at in poses]
    made = [Hypothesis("pin", inverse(at), 0.0, np.eye(6), 0.0, np.zeros(1)) for at in worlds]
    middle = Lone(points[0], normals[0], True, 0.3, 0.04)
    free, edged = (rooms_round(shape, made, PIN, target, poses, h, points, middle) for h in (told, held))
    assert edged[0].log_volume == pytest.approx(free[0].log_volume)
    volumes = [spread_of(h[0], poses[0], points, PIN, target)[1] for h in (told, held)]
    assert volumes[0] - volumes[1] > 1.0
    assert free[0].face == free[1].face != free[2].face
