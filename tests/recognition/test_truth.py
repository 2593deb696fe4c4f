"""The evaluator against closed forms."""

import numpy as np
import pytest

from models.csg import Cone, Cube, Cylinder, Sphere
from models.solid import Solid
from primitives.pose import pose, random_rotation
from recognition.truth import TruthOptions, evaluate

FEW = TruthOptions(samples=3000)


def solid(tree, world=None):
    return Solid.from_csg(tree, 0.01).placed(np.eye(4) if world is None else world)


def test_a_solid_compared_with_itself_is_perfect():
    world = pose(random_rotation(np.random.default_rng(0)), [10.0, 20.0, 30.0])
    same = solid(Cylinder(15.0, 40.0), world)
    found = evaluate(same, same, FEW).as_dict()
    assert found["iou"] == pytest.approx(1.0)
    assert found["hausdorff_mm"] < 1e-9
    assert found["face_shape_accuracy"] == 1.0
    assert found["extent_error_mm"] == {"median": 0.0, "max": 0.0}
    assert found["world_from_part"]["translation_mm"] == [10.0, 20.0, 30.0]


def test_a_block_grown_on_one_side_has_the_numbers_of_arithmetic():
    truth = solid(Cube((40.0, 30.0, 20.0)))
    found = evaluate(solid(Cube((42.0, 30.0, 20.0)).at(1.0, 0.0, 0.0)), truth, FEW)
    assert found.iou == pytest.approx(40 / 42, abs=1e-9)
    assert found.hausdorff == pytest.approx(2.0, abs=0.01)
    # from the truth only its +x face is off, less near its rim; from the model that face and 2 mm of four sides
    back = (26 * 16 * 4 + (100 * 8 / 3 - 8 * 4)) / 5200
    forth = (600 * 4 + 2 * 100 * 4 / 3) / 5400
    assert found.surface_rms == pytest.approx(np.sqrt((back + forth) / 2), rel=0.02)
    assert max(found.extent_errors) == pytest.approx(2.0)
    assert min(found.extent_errors) == 0.0


def test_shifted_spheres_have_the_overlap_of_two_caps():
    radius, shift = 20.0, 4.0
    found = evaluate(solid(Sphere(radius).at(0, 0, shift)), solid(Sphere(radius)), FEW)
    height = radius - shift / 2
    lens = 2 * np.pi * height**2 * (3 * radius - height) / 3
    union = 2 * 4 / 3 * np.pi * radius**3 - lens
    assert found.iou == pytest.approx(lens / union, rel=1e-3)
    assert found.hausdorff == pytest.approx(shift, abs=0.02)


def test_a_face_of_the_wrong_shape_costs_its_share_of_the_area():
    truth = solid(Cylinder(10.0, 40.0))
    found = evaluate(solid(Cone(10.2, 9.8, 40.0)), truth, FEW)
    caps = 2 * np.pi * 100
    assert found.face_shape_accuracy == pytest.approx(caps / (caps + 2 * np.pi * 10 * 40), rel=1e-3)
    assert found.missed_faces == 1
    assert len(found.extent_errors) == 4


def test_the_numbers_do_not_depend_on_the_run():
    a, b = solid(Sphere(20.0)), solid(Sphere(20.1))
    assert evaluate(a, b, FEW).as_dict() == evaluate(a, b, FEW).as_dict()


def test_a_mesh_without_labels_has_the_faces_that_its_triangles_tell():
    truth = solid(Cube((40.0, 30.0, 20.0)) - Cylinder(6.0, 30.0))
    mesh = Solid.from_mesh(truth.vertices, truth.triangles)
    for model, wanted in ((truth, mesh), (mesh, truth)):
        found = evaluate(model, wanted, FEW)
        assert found.iou == pytest.approx(1.0)
        assert found.face_shape_accuracy == pytest.approx(1.0)
        assert (
            max(found.extent_errors) < 2.0 * np.pi * 0.01
        )  # round the hole, by as much as facets lie off it


def test_a_surface_that_no_shape_explains_is_compared_by_distance_alone(monkeypatch):
    monkeypatch.setattr("recognition.truth._RECOVERED", 0)
    model = solid(Cube((40.0, 30.0, 20.0)))
    found = evaluate(model, Solid.from_mesh(model.vertices, model.triangles), FEW).as_dict()
    assert found["iou"] == pytest.approx(1.0)
    assert found["face_shape_accuracy"] is None
    assert found["missed_faces"] is None
    assert found["extent_error_mm"]["median"] is None


def test_a_face_that_the_truth_lacks_costs_its_share_too():
    truth = Cube((40.0, 30.0, 20.0))
    bevel = Cube((80.0, 80.0, 80.0)).turned("y", np.pi / 4).at(-37.0, 0.0, -37.0 + 10.0)
    found = evaluate(solid(truth & bevel), solid(truth), FEW)
    assert found.missed_faces == 0
    assert found.extra_faces == 1
    assert 0.9 < found.face_shape_accuracy < 1.0
