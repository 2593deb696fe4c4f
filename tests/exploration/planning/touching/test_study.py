"""What contacts become on an object that turns out not to be convex."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.touching.findings import Findings
from exploration.planning.touching.study import Study, Wall
from primitives.evidence import Contacts
from primitives.fit import fit
from primitives.patch_graph import Face, ranked_face


def tread(height, x, width, touch):
    """Thirty contacts of a level face, whose middle is at x."""
    points = np.random.default_rng(touch).uniform(-0.5, 0.5, (30, 3)) * [width, 20.0, 0.01] + [x, 0.0, height]
    return Contacts.of(points, np.eye(3)[[2] * 30], sigma=0.01, normal_sigma=0.005, touch=touch)


def test_a_narrow_step_held_against_a_convex_object_is_a_face_of_a_hollow_one():
    study = Study(SimpleNamespace(felt=[]), Findings(), AttributionConfig())
    study.take_in(tread(0.0, 0.0, 20.0, touch=1))
    study.take_in(tread(20.0, 40.0, 4.0, touch=2))
    assert len(study.found.graph.faces) == 1
    assert len(study.loose) == 30
    study.reconsider()
    heights = sorted(float(face.contacts.points[:, 2].mean()) for face in study.found.graph.faces)
    np.testing.assert_allclose(heights, [0.0, 20.0], atol=0.01)
    assert not len(study.loose)


def test_a_wall_met_slanting_may_stand_along_either_side_of_the_housing_that_went_ahead():
    laid, half = np.diag([1.0, -1.0, -1.0, 1.0]), np.array([9.0, 14.0])
    way = np.array([0.6, 0.8, 0.0])
    along_y, along_x = Wall(12.0 * way, way, np.eye(3)[2], laid, half).readings()
    np.testing.assert_allclose(along_y.heading, [0.0, 1.0, 0.0])
    np.testing.assert_allclose(along_y.point, [0.0, 14.0, 0.0])
    np.testing.assert_allclose(along_x.point, [9.0, 0.0, 0.0])
    straight = Wall(np.array([9.0, 0.0, 0.0]), np.eye(3)[0], np.eye(3)[2], laid, half)
    assert straight.readings() == [straight]


def test_what_is_told_to_stand_beside_the_object_is_no_face_of_it_and_is_not_stroked():
    pad = SimpleNamespace(felt=[], on_told=lambda: True)  # and nothing to stroke with
    study = Study(pad, Findings(), AttributionConfig())
    assert study.face_here() is None
    assert not len(study.loose)


def test_a_stroke_that_the_table_stops_at_one_corner_of_the_array_met_no_wall():
    table = SimpleNamespace(stopped=lambda front: (front[:, 1] < -12.0).any())
    laid = np.diag([1.0, -1.0, -1.0, 1.0])
    pad = SimpleNamespace(felt=[], told=table, size=(18.0, 28.8))
    pad.guard = SimpleNamespace(world_from_sensor=laid)
    pad.tool = SimpleNamespace(high=np.array([10.0, 15.0, 0.0]))
    stroke = SimpleNamespace(ended="wall", heading=np.array([1.0, 0.0]), met=None)
    study = Study(pad, Findings(), AttributionConfig())
    assert not study.note_wall(stroke)
    pad.told = None
    assert study.note_wall(stroke)
    assert len(study.walls) == 1


def of_a_ball(longitudes, latitudes, touch):
    """Contacts of a ball of 40 mm round the origin, over ranges [rad]."""
    rng = np.random.default_rng(touch)
    around, up = rng.uniform(*longitudes, 40), rng.uniform(*latitudes, 40)
    out = np.column_stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)])
    points = 40.0 * out + rng.normal(scale=0.02, size=(40, 3))
    return Contacts.of(points, out, sigma=0.03, normal_sigma=0.01, touch=touch)


def test_a_strip_read_as_a_cylinder_is_part_of_the_ball_once_that_is_known():
    study = Study(SimpleNamespace(felt=[]), Findings(), AttributionConfig(convex=False))
    options = study.found.graph.options
    narrow = of_a_ball((-0.5, 0.5), (-0.02, 0.02), touch=1)
    strip = Face(0, fit("cylinder", narrow), narrow)  # as noise may have it
    dome = ranked_face(1, of_a_ball((-0.5, 0.5), (0.2, 0.9), touch=2), options)
    assert dome.fit.kind == "sphere"
    study.found.graph = replace(study.found.graph, faces=(strip, dome))
    study.seen = [("an edge", 1)]
    assert study.merge()
    (whole,) = study.found.graph.faces
    assert whole.fit.kind == "sphere"
    assert len(whole.contacts) == 80
    assert study.seen == [("an edge", whole.id)]
    assert not study.merge()
