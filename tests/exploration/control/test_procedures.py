"""Exploratory procedures in closed loop: noisy array, late stage, noisy encoders; the test knows the object."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.control.procedures.approach import approach, retreat
from exploration.control.procedures.compliance import compliance
from exploration.control.procedures.elasticity import elasticity
from exploration.control.procedures.enclosure import enclosure
from exploration.control.procedures.hardness import HardnessConfig, hardness
from exploration.control.procedures.land import land
from exploration.control.procedures.press import press
from exploration.control.procedures.surface_normal import surface_normal
from exploration.control.procedures.texture import TextureConfig, texture
from exploration.control.procedures.thermal import thermal
from exploration.devices.guard import Guard
from exploration.devices.simulated import PoseNoise, simulate
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import Thermal, load_sensor
from models.csg import Cube, Cylinder, Sphere
from models.material import MadeOf, Material, Materials
from models.solid import Solid
from primitives import pose as se3

DOWN = np.diag([1.0, -1.0, -1.0])
PLATE = Cube((120.0, 80.0, 40.0))
LATE = 0.02  # [s]
QUICK = HardnessConfig(relative=0.05)


def over(tree=PLATE, materials=None, at=(0.0, 0.0, 25.0), seed=0, layer=None, surface=None):
    spec = load_sensor("lts210")
    spec = replace(spec, electronics=replace(spec.electronics, noise=0.05), thermal=layer)
    surface = surface or MadeOf(Solid.from_csg(tree), materials or Materials())
    stage, arrays = simulate(
        surface,
        [spec],
        np.random.default_rng(seed),
        pose_noise=PoseNoise(0.05, 0.02, 0.0, np.radians(0.02)),
        start_pose=se3.pose(DOWN, at),
        latency=LATE,
    )
    guard = Guard(stage, arrays, [Calibration.nominal(spec)])
    guard.pending.latency = LATE
    return guard


def landed(*args, **kwargs):
    guard = over(*args, **kwargs)
    assert land(guard, guard.world_from_sensor[:3, 2].copy(), 40.0, 25.0)
    return guard


@pytest.mark.parametrize("stiffness", [0.06, 0.25])
def test_stiffness_is_found_with_the_skin_taken_off(stiffness):
    felt = hardness(landed(materials=Materials(Material(stiffness))), QUICK)
    assert felt
    assert abs(felt.stiffness / stiffness - 1.0) < min(0.1, 4.0 * felt.sigma / stiffness)
    assert felt.hardness == pytest.approx(felt.stiffness * 28.8 * 18.0, rel=0.02)
    assert felt.share == pytest.approx(stiffness / (0.1 + stiffness), rel=0.05)


def test_of_a_rigid_object_only_a_bound_is_told():
    felt = hardness(landed(), QUICK)
    assert felt.stiffness is None
    assert felt.bound > 2.0


def test_nothing_under_the_pad_cannot_be_pressed_and_says_so():
    nothing = press(over())
    assert not nothing
    assert "contact" in nothing.reason


def test_pressing_keeps_within_the_limits_of_the_guard():
    guard = landed(materials=Materials(Material(0.2)))
    forces = []
    guard.observers = (lambda seen: forces.append(seen.force),)
    assert press(guard)
    assert max(forces) < guard.limits.force


def test_compliance_is_that_of_two_springs_in_series():
    felt = compliance(landed(materials=Materials(Material(0.1))), force=20.0)
    one = 20.0 / (0.1 * 28.8 * 18.0)
    assert felt.distance == pytest.approx(2.0 * one, rel=0.03)
    assert felt.skin == pytest.approx(one, rel=0.03)
    assert felt.object == pytest.approx(one, rel=0.06)


class Clay(MadeOf):
    """A plate that stays pressed in: a share of the deepest that the pad has been, as a height below its own."""

    def clings_to(self, stage, stays):
        object.__setattr__(self, "stage", stage)
        object.__setattr__(self, "stays", stays)
        object.__setattr__(self, "sunk", 0.0)
        return self

    uniform = None

    def materials_at(self, points):
        object.__setattr__(self, "sunk", max(self.sunk, self.stays * (20.0 - self.stage._true[2, 3])))
        return np.full(len(points), np.inf), np.full(len(points), self.sunk)

    def grain_at(self, points):
        return np.full(len(points), -1.0)


@pytest.mark.slow
@pytest.mark.parametrize("stays", [0.0, 0.3])
def test_what_stays_of_a_press_is_the_permanent_set(stays):
    clay = Clay(Solid.from_csg(PLATE), Materials())
    guard = over(surface=clay)
    clay.clings_to(guard.stage, stays)
    assert land(guard, np.array([0.0, 0.0, -1.0]), 40.0, 25.0)
    before = clay.sunk
    felt = elasticity(guard)
    assert felt
    assert abs(felt.permanent_set - (clay.sunk - before)) < 4.0 * max(felt.sigma, 0.015)


@pytest.mark.parametrize("roughness", [0.01, 0.04])
def test_roughness_is_found_within_its_sigma(roughness):
    guard = landed(materials=Materials(Material(roughness=roughness)))
    felt = texture(guard, np.array([1.0, 0.0]), config=TextureConfig(length=15.0))
    assert felt
    assert felt.felt
    assert abs(felt.roughness - roughness) < 4.0 * felt.sigma
    assert felt.roughness == pytest.approx(roughness, rel=0.35)
    assert felt.noise == pytest.approx(0.025, rel=0.1)


def test_a_smooth_face_is_not_called_rough():
    felt = texture(landed(), np.array([1.0, 0.0]), config=TextureConfig(length=15.0))
    assert felt.roughness < 0.004


def test_a_stroke_leaves_edges_out_of_the_texture():
    guard = landed(Cube((60.0, 50.0, 40.0)), Materials(Material(roughness=0.03)))
    felt = texture(guard, np.array([1.0, 0.0]))
    assert felt
    assert felt.roughness == pytest.approx(0.03, rel=0.4)


def test_two_places_give_the_normal_of_a_cylinder():
    guard = landed(Cylinder(20.0, 80.0).turned("x", np.pi / 2))
    felt = surface_normal(guard, np.array([1.0, 0.0]))
    assert felt.places == 2
    truth = np.array([felt.point[0], 0.0, felt.point[2]])
    assert felt.normal @ truth / np.linalg.norm(truth) > np.cos(np.radians(0.5))


def test_a_pin_is_enclosed_by_one_circle():
    felt = enclosure(landed(Cylinder(5.0, 40.0), at=(1.0, 1.0, 25.0)))
    assert felt.enclosed
    assert felt.round
    assert felt.extent[0] == pytest.approx(10.0, abs=0.3)
    np.testing.assert_allclose(felt.center, [0.0, 0.0, 20.0], atol=0.25)


def test_a_bar_is_enclosed_by_its_length_and_width():
    felt = enclosure(landed(Cube((14.0, 9.0, 40.0)), at=(0.5, 0.0, 25.0)))
    assert felt.enclosed
    assert not felt.round
    np.testing.assert_allclose(felt.extent, [14.0, 9.0], atol=0.7)
    assert felt.area == pytest.approx(126.0, rel=0.05)
    assert abs(felt.axis[0]) > 0.99


def test_a_part_larger_than_the_pad_is_not_enclosed():
    assert not enclosure(landed()).enclosed


def test_approach_stops_at_the_force():
    met = approach(over(), np.array([0.0, 0.0, -1.0]), 30.0, 20.0)
    assert met.stopped == "force"
    assert 20.0 <= met.force < 30.0


def test_approach_stops_on_a_sharp_contact_before_the_force():
    met = approach(over(Cylinder(0.8, 40.0)), np.array([0.0, 0.0, -1.0]), 30.0, 20.0)
    assert met.stopped == "sharp"


def test_approach_stops_on_heat():
    hot = over(materials=Materials(temperature=300.0), layer=Thermal(0.1))
    met = approach(hot, np.array([0.0, 0.0, -1.0]), 30.0, 55.0)
    assert met.stopped == "heat"
    assert met.temperature > 50.0


def test_approach_to_nothing_is_false():
    assert not approach(over(Sphere(5.0), at=(100.0, 0.0, 30.0)), np.array([0.0, 0.0, -1.0]), 20.0, 20.0)


def test_temperature_is_what_the_layer_settles_to():
    guard = landed(materials=Materials(temperature=45.0), layer=Thermal(0.5, noise=0.1))
    felt = thermal(guard)
    assert felt.celsius == pytest.approx(45.0, abs=0.2)
    assert felt.time_constant == pytest.approx(0.5, rel=0.1)


def test_an_array_without_a_thermal_layer_says_so():
    felt = thermal(landed())
    assert not felt
    assert "no thermal layer" in felt.reason


def test_procedures_end_where_the_next_can_begin():
    guard = landed(materials=Materials(Material(0.2)))
    assert compliance(guard, cycles=1)
    assert hardness(guard, QUICK)
    retreat(guard, 10.0)
    assert approach(guard, guard.world_from_sensor[:3, 2].copy(), 20.0, 10.0).stopped == "force"
