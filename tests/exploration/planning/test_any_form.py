"""What is left to an array that comes after others."""

from types import SimpleNamespace

import numpy as np

from exploration.control.sighting import Sighting
from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.any_form import AnyForm
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.touching.findings import ExplorerConfig, Findings
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.study import Study
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube
from models.solid import Solid
from primitives.evidence import NOT_FELT, Contacts
from primitives.fit import fit
from primitives.patch_graph import Face, MergeOptions, PatchGraph, ranked_face
from primitives.pose import pose

GRID = np.array([[x, y, 0.0] for x in (-5.0, 0.0, 5.0) for y in (-5.0, 0.0, 5.0)])


def face(number, *lots):
    """A flat face of lots of contacts, each of a sensor and a touch."""
    contacts = Contacts.concatenate(
        [Contacts.of(GRID, np.tile([0.0, 0.0, 1.0], (9, 1)), sensor=s, touch=t) for s, t in lots]
    )
    return Face(number, fit("plane", contacts), contacts)


def test_a_later_array_goes_on_over_faces_that_it_alone_has_felt_or_that_are_new():
    form = AnyForm.__new__(AnyForm)
    form._before = {0, 1, 2, 3, 4}
    floors = face(1, (1, 4)), face(2, (1, 5), (0, NOT_FELT))
    others = face(0, (0, 1)), face(3, (0, 2), (1, 6)), face(4, (0, NOT_FELT))
    form.found = SimpleNamespace(graph=PatchGraph((*floors, *others), ()))
    form.pad = SimpleNamespace(guard=SimpleNamespace(active=1))
    assert sorted(form._own_faces()) == [1, 2]
    form._before = {0, 1, 2}
    assert sorted(form._own_faces()) == [1, 2, 3, 4]


def test_an_edge_that_there_was_no_room_to_roll_over_is_looked_at():
    block = Solid.from_csg(Cube((60.0, 50.0, 40.0)))
    spec, start = load_sensor("lts210"), pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 60.0])
    stage, arrays = simulate(block, [spec], np.random.default_rng(0), start_pose=start)
    guard = Guard(stage, arrays, [Calibration.nominal(spec)])
    pad = Pad(guard, np.array([-90.0, -90.0, -90.0, 90.0, 90.0, 90.0]), lambda kind, detail: None)
    x, y, up = np.eye(3)
    top = np.array([[a, b, 20.0] for a in (-9.0, 0.0, 9.0) for b in (-9.0, 0.0, 9.0)])
    flat = ranked_face(4, Contacts.of(top, np.tile(up, (9, 1))), MergeOptions())
    study = Study(pad, Findings(hollow=True, graph=PatchGraph((flat,), ())), AttributionConfig(convex=False))
    study.found.barred = [(Sighting(np.array([29.0, 0.0, 20.0]), y, x, up, 1.0, 12.0), 4)]
    form = AnyForm(study, ExplorerConfig())
    form._looking = SimpleNamespace(next=lambda: None)
    move = form._look(form._frontier())
    assert move is not None
    assert move()[1] == "looked at the rim of a wall that nothing has room to face"
    assert min(abs(float(edge.point @ x) - 30.0) for edge, _ in study.found.wall_rims) < 0.3
