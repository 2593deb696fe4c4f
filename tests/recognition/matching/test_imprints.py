"""The picture that a simulated skin felt, against near-duplicates whose contacts are the same."""

from dataclasses import replace

import numpy as np

from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.touching.lone_touch import Approach, touch_once
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models import parts
from models.csg import Cylinder
from models.library import Library
from models.solid import Solid
from models.symmetry import pose_error
from primitives import pose as se3
from primitives.arrays import frozen
from primitives.evidence import Contacts, Imprint
from recognition.matching import Evidence, Hypothesis, match
from recognition.matching.imprints import log_imprints

LIBRARY = Library.of(
    {name: Solid.from_csg(parts.build(name)) for name in ("bolt_plate", "bolt_plate_one_wider")}
)
TOP = float(LIBRARY["bolt_plate"].solid.bounds[1, 2])
WIDER = (26.0, 19.0)  # [mm] beside the hole that one of them has wider


def _felt(name: str, place: tuple[float, float]) -> Imprint:
    """The pad laid on the plate's top, beside a hole."""
    solid, spec = LIBRARY[name].solid, load_sensor("lts210")
    start = se3.pose(se3.frame_along(np.array([0.0, 0.0, -1.0])), np.array([*place, TOP + 10.0]))
    stage, arrays = simulate(solid, [spec], np.random.default_rng(0), start_pose=start)
    touch = touch_once(Guard(stage, arrays, [Calibration.nominal(spec)]), Approach(start, 30.0))
    assert touch.imprint is not None
    return touch.imprint


def _left(name: str, imprint: Imprint, shift: float = 0.0, turned: float = 0.001) -> float:
    covariance = frozen(np.diag([1e-4] * 3 + [turned**2] * 3))
    at = frozen(se3.pose(np.eye(3), [shift, 0.0, 0.0]))
    h = Hypothesis(name, at, 0.0, covariance, 0.0, frozen(np.zeros(1)))
    return log_imprints(h, LIBRARY[name], Evidence(Contacts.of([]), imprints=(imprint,)))


def test_a_hole_a_little_wider_is_told_by_what_is_felt_beside_it() -> None:
    imprint = _felt("bolt_plate", WIDER)
    for shift in (-0.1, 0.0, 0.1):
        assert _left("bolt_plate", imprint, shift) == 0.0
        assert _left("bolt_plate_one_wider", imprint, shift) < -4.0
    assert _left("bolt_plate", imprint, shift=3.0) < -2.0
    assert _left("bolt_plate_one_wider", imprint, turned=1.0) == 0.0


def test_an_edge_under_the_skin_says_where_along_its_face_an_object_is() -> None:
    plate = Library.of({"bolt_plate": LIBRARY["bolt_plate"].solid})
    imprint = _felt("bolt_plate", (33.0, 34.0))
    top = [[x, y, TOP] for x in (-30.0, 30.0) for y in (-10.0, 10.0)]
    sides = [[x, 40.0, z] for x in (-30.0, 30.0) for z in (-2.0, 2.0)]
    end = [[39.2, y, 0.0] for y in (-30.0, 30.0)]  # told 0.8 mm too deep
    facing = np.repeat(np.eye(3)[[2, 1, 0]], [4, 4, 2], axis=0)
    sigma = np.repeat([0.02, 0.02, 0.8], [4, 4, 2])
    contacts = Contacts.of([*top, *sides, *end], facing, sigma, 0.01, touch=imprint.touch)
    off = []
    for imprints in ((), (imprint,)):
        best = match(Evidence(contacts, imprints=imprints), plate).hypotheses[0]
        off.append(pose_error(plate["bolt_plate"].symmetry, best.pose, np.eye(4)).distance)
        sigma_told = best.translation_sigma
    assert off[0] > 0.5
    assert off[1] < 0.3
    assert sigma_told < 0.4


def test_skin_that_was_not_over_a_hole_does_not_tell_where_that_is() -> None:
    pipe = (
        Cylinder(30.0, 60.0)
        - Cylinder(20.0, 70.0)
        - Cylinder(8.0, 40.0).turned((0, 1, 0), np.pi / 2).at(25, 0, 0)
    )
    known = Library.of({"pipe": Solid.from_csg(pipe)})
    spec, felt, pictures = load_sensor("lts210"), list[Contacts](), list[Imprint]()
    for number, turn in enumerate((2.0, 2.8, 3.6)):
        out = np.array([np.cos(turn), np.sin(turn), 0.0])
        start = se3.pose(se3.frame_along(-out), 40.0 * out)
        stage, arrays = simulate(known["pipe"].solid, [spec], np.random.default_rng(number), start_pose=start)
        touch = touch_once(Guard(stage, arrays, [Calibration.nominal(spec)]), Approach(start, 30.0))
        assert touch.imprint is not None
        felt.append(replace(touch.contacts, touch=np.full(len(touch.contacts), number)))
        pictures.append(replace(touch.imprint, touch=number))
    ends = np.array([[24.0 * np.cos(a), 24.0 * np.sin(a), z] for a in (2.0, 2.8, 3.6) for z in (-30.0, 30.0)])
    felt.append(Contacts.of(ends, np.sign(ends[:, 2:]) * [[0.0, 0.0, 1.0]], 0.02, 0.01, touch=9))
    belief = match(Evidence(Contacts.concatenate(felt), imprints=tuple(pictures)), known)
    best = belief.hypotheses[0]
    assert belief.decision == "pipe"
    assert best.translation_sigma < 1.0
    assert sum(float(np.exp(h.log_weight)) for h in belief.hypotheses if h.rotation_sigma > 0.2) > 0.8
