"""What exploration concluded, through a recording and back."""

import numpy as np
import pytest

from exploration.planning.touching.findings import Findings
from exploration.recordings.mcap import Recorder
from primitives.errors import PalpateError
from primitives.evidence import Contacts
from primitives.fit import Fit, NoFit
from primitives.patch_graph import PatchGraph
from primitives.plate import Plate
from primitives.shapes import Cone, Cylinder, Sphere
from recognition.running.evidence_log import EvidenceLog, explored

BOX = np.array([[-300.0] * 3, [300.0] * 3])
PLATE = Plate(np.eye(4), 8.0, (np.array([[0.0, 0.0], [9.5, 0.0], [0.0, 7.25]]),), (), step=True)


def touched(shape, stroke, rng):
    points = shape.project(shape.anchor + 20.0 * rng.normal(size=(30, 3)))
    points = points + 0.01 * rng.normal(size=points.shape)
    return Contacts.of(points, shape.normals(points), 0.01, 0.02, stroke, stroke)


@pytest.fixture
def found():
    rng = np.random.default_rng(0)
    shapes = [
        Sphere(np.array([5.0, 1.0, 2.0]), 25.0),
        Cylinder(np.array([80.0, 0.0, 0.0]), np.array([0.0, 0.6, 0.8]), 12.0),
        Cone(np.array([0.0, 90.0, 0.0]), np.array([0.0, 0.0, 1.0]), 0.4),
    ]
    graph = PatchGraph()
    for stroke, shape in enumerate(shapes):
        graph, _ = graph.add_stroke(touched(shape, stroke, rng))
    graph, _ = graph.add_stroke(Contacts.of([[200.0, 0.0, 0.0]], touch=9))
    return Findings(graph=graph)


def test_faces_come_back_as_they_were_after_every_move(found, tmp_path):
    path = tmp_path / "episode.mcap"
    whole, found.graph = found.graph, PatchGraph()
    with Recorder(path) as recorder:
        log = EvidenceLog(lambda kind, detail: recorder.event(0.0, kind, detail), BOX)
        for count in range(1, len(whole.faces) + 1):
            found.graph = PatchGraph(whole.faces[:count])
            log.note(found)
        found.inside, found.plates = [np.array([[1.0, 2.0, 3.0]])], [PLATE]
        log.note(found)
    again = explored(path)
    assert again is not None
    assert again.ended == "cut short"
    np.testing.assert_array_equal(again.free, [[1.0, 2.0, 3.0]])
    np.testing.assert_array_equal(again.box, BOX)
    (plate,) = again.plates
    assert plate.thick == PLATE.thick
    assert (plate.lies, plate.step) == (False, True)
    np.testing.assert_array_equal(plate.pose, PLATE.pose)
    np.testing.assert_array_equal(plate.there[0], PLATE.there[0])
    assert plate.missing == ()
    for old, new in zip(whole.faces, again.graph.faces, strict=True):
        assert old.id == new.id
        np.testing.assert_array_equal(old.contacts.points, new.contacts.points)
        np.testing.assert_array_equal(old.contacts.normals, new.contacts.normals)
        np.testing.assert_array_equal(old.contacts.stroke, new.contacts.stroke)
        if isinstance(old.fit, NoFit):
            assert isinstance(new.fit, NoFit)
            continue
        assert isinstance(new.fit, Fit)
        assert (new.fit.kind, new.fit.convex) == (old.fit.kind, old.fit.convex)
        np.testing.assert_allclose(
            new.fit.shape.signed_distance(BOX), old.fit.shape.signed_distance(BOX), atol=1e-9
        )
        np.testing.assert_array_equal(new.fit.covariance, old.fit.covariance)
        np.testing.assert_array_equal(new.fit.inliers, old.fit.inliers)


def test_a_recording_of_something_else_tells_nothing_and_a_strange_one_is_named(found, tmp_path):
    path = tmp_path / "episode.mcap"
    with Recorder(path) as recorder:
        recorder.event(0.0, "ended", {})
    assert explored(path) is None
    with Recorder(path) as recorder:
        recorder.event(0.0, "faces", {"faces": [{"id": 0}]})
    with pytest.raises(PalpateError, match="not as this version writes them"):
        explored(path)


def test_what_the_stage_adds_to_sigmas_comes_back_and_is_believed(found, tmp_path):
    path = tmp_path / "episode.mcap"
    found.graph = found.graph.scattered(0.04)
    with Recorder(path) as recorder:
        EvidenceLog(lambda kind, detail: recorder.event(0.0, kind, detail), BOX).note(found)
    again = explored(path)
    assert again is not None
    assert again.graph.options.scatter == 0.04
    assert np.allclose(again.graph.faces[0].contacts.sigma, 0.01)
    assert np.allclose(again.contacts.sigma[:90], np.hypot(0.01, 0.04))
