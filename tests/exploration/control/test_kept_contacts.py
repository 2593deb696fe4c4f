"""What frames of a pressed pad say of a surface, against the surface itself."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.control.dwell import dwell
from exploration.control.kept_contacts import keep
from exploration.devices.guard import Collision, Guard, OverPress
from exploration.devices.simulated import simulate
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cone, Csg, Cube, Cylinder, Prism, Torus
from models.solid import Solid
from primitives import pose as se3

DOWN = np.diag([1.0, -1.0, -1.0])


def errors(tree: Csg, top: float, frames: int, presses: int = 12):
    """(n,) distance of contacts from the solid [mm] and their sigma, and how many each press yielded."""
    spec = load_sensor("lts210")
    spec = replace(spec, electronics=replace(spec.electronics, noise=0.05))
    solid, rng = Solid.from_csg(tree), np.random.default_rng(3)
    off, sigma, counts = [], [], []
    for _ in range(presses):
        turn = se3.rotation_exp([0.0, 0.0, rng.uniform(0.0, np.pi)]) @ DOWN
        start = se3.pose(turn, [rng.uniform(4.0, 8.0), rng.uniform(-1.0, 1.0), top - 0.5])
        stage, arrays = simulate(solid, [spec], rng, start_pose=start)
        kept = []
        keep(dwell(Guard(stage, arrays, [Calibration.nominal(spec)]), frames), 1, 1, kept)
        counts.append(sum(map(len, kept)))
        for contacts in kept:
            off.extend(solid.signed_distance(contacts.points))
            sigma.extend(contacts.sigma)
    return np.array(off), np.array(sigma), counts


@pytest.mark.parametrize("radius", [12.0, 20.0, 30.0])
@pytest.mark.parametrize("frames", [1, 8])
def test_a_flank_that_ends_under_the_pad_is_not_taken_for_a_strip_below_it(radius, frames):
    off, sigma, counts = errors(Cylinder(radius, 20.0).turned("y", np.pi / 2), radius, frames)
    assert np.mean(np.array(counts) > 0) > 0.5
    assert abs(off.mean()) < 0.01
    assert np.sqrt(np.mean((off / sigma) ** 2)) < 1.5


def test_a_strip_that_ends_under_the_pad_is_still_flat():
    off, sigma, counts = errors(Cube((20.0, 9.0, 30.0)).at(0.0, 0.0, -15.0), 0.0, 8)
    assert np.mean(np.array(counts) == 4) > 0.7
    assert np.sqrt(np.mean((off / sigma) ** 2)) < 1.5


def test_a_face_hardly_larger_than_the_pad_is_felt_flat():
    off, sigma, counts = errors(Cube((41.5, 20.7, 30.0)).at(0.0, 0.0, -15.0), 0.0, 8)
    assert np.mean(np.array(counts) > 0) > 0.7
    assert np.sqrt(np.mean((off / sigma) ** 2)) < 1.5


@pytest.mark.parametrize("lean", [0.0, 0.1, 0.2])
def test_a_blunt_edge_is_hardly_or_not_trusted_as_a_narrow_face(lean):
    """A pad on an edge of 135 degrees, where it is balanced, or has not settled yet."""
    gable = ((-30.0, -40.0), (30.0, -40.0), (30.0, -12.43), (0.0, 0.0), (-30.0, -12.43))
    roof = Prism(gable, 60.0).turned("x", np.pi / 2).turned("z", np.pi / 2).turned("x", lean)
    off, sigma, _ = errors(roof, 0.0, 8)
    assert np.sqrt(((off / sigma) ** 2).sum()) < 1.3 * np.sqrt(len(off)) + 1e-9


def test_the_crown_of_a_ring_yields_contacts_on_the_ring_and_not_inside_its_bend():
    spec = load_sensor("lts210")
    solid, rng = Solid.from_csg(Torus(35.0, 7.0)), np.random.default_rng(3)
    off, sigma = [], []
    for _ in range(8):
        turn = se3.rotation_exp([0.0, 0.0, rng.uniform(0.0, np.pi)]) @ DOWN
        start = se3.pose(turn, [35.0 - rng.uniform(0.0, 3.0), rng.uniform(-1.0, 1.0), 6.6])
        stage, arrays = simulate(solid, [spec], rng, start_pose=start)
        kept = []
        keep(dwell(Guard(stage, arrays, [Calibration.nominal(spec)]), 8), 1, 1, kept)
        for contacts in kept:
            off.extend(solid.signed_distance(contacts.points))
            sigma.extend(contacts.sigma)
    assert len(off) >= 8
    assert np.abs(off).max() < 0.12
    assert np.sqrt(np.mean(np.square(off) / np.square(sigma))) < 1.5


def test_a_pad_that_lies_on_the_edge_of_a_thin_wall_tells_nothing_far_beside_it():
    """What such a frame shows of a slope is noise; drawn out over the pad it would be faces in the open."""
    spec = load_sensor("lts210")
    spec = replace(spec, electronics=replace(spec.electronics, noise=0.05))
    wall, rng = Solid.from_csg(Cube((5.0, 60.0, 40.0))), np.random.default_rng(5)
    far = []
    for lean in np.linspace(0.2, 0.9, 24):
        turn = se3.rotation_exp([0.0, lean, 0.0]) @ DOWN
        start = se3.pose(
            turn, np.array([rng.uniform(1.5, 2.5), rng.uniform(-9.0, 9.0), 20.0]) + 0.4 * turn[:, 2]
        )
        stage, arrays = simulate(wall, [spec], rng, start_pose=start)
        kept = []
        keep(dwell(Guard(stage, arrays, [Calibration.nominal(spec)]), 2), 1, 1, kept)
        far += [np.abs(wall.signed_distance(contacts.points)).max() for contacts in kept]
    assert max(far, default=0.0) < 1.0


def presses(tree: Csg, poses, noise=0.05, force=4.0, sensor="lts210"):
    """(n,) greatest distance of each kept frame's contacts from the solid [mm]; the pad is let down on it."""
    spec = load_sensor(sensor)
    spec = replace(spec, electronics=replace(spec.electronics, noise=noise))
    solid, rng, off = Solid.from_csg(tree), np.random.default_rng(3), []
    for turn, x, y in poses:
        for height in np.arange(2.0, -3.0, -0.2):
            start = se3.pose(turn, [x, y, height])
            stage, arrays = simulate(solid, [spec], rng, start_pose=start)
            try:
                seen = dwell(Guard(stage, arrays, [Calibration.nominal(spec)]), 4)
            except (Collision, OverPress):
                break
            kept = []
            if seen.force > force:
                keep(seen, 1, 1, kept)
                break
        off.extend(float(np.abs(solid.signed_distance(contacts.points)).max()) for contacts in kept)
    return np.array(off)


def test_contacts_of_the_ring_round_a_hole_lie_on_the_ring():
    ring = Cylinder(14.0, 10.0).at(0, 0, -5.0) - Cylinder(9.0, 12.0).at(0, 0, -5.0)
    turns = [se3.rotation_exp([0.0, 0.0, turn]) @ DOWN for turn in np.linspace(0.0, np.pi, 5)]
    off = presses(ring, [(turn, x, 0.0) for turn in turns for x in (6.0, 11.0)])
    assert len(off) > 4
    assert off.max() < 1.8  # a pitch


def test_the_narrow_top_of_a_hollow_boss_that_is_seen_whole_yields_contacts_on_it():
    boss = Cone(9.0, 7.0, 12.0).at(0, 0, -6.0) - Cylinder(5.0, 10.0).at(0, 0, -4.0)
    turns = [
        se3.rotation_exp([lean, 0.0, 0.0]) @ se3.rotation_exp([0.0, 0.0, turn]) @ DOWN
        for turn in (0.0, 0.5, 1.0)
        for lean in (0.0, 0.04, 0.07)
    ]
    off = presses(boss, [(turn, 0.6, -0.4) for turn in turns])
    assert len(off) > 4
    assert off.max() < 0.12  # 0.6 of a pad that leans so far that it sees them eccentric


def test_a_small_pad_astride_a_sharp_edge_tells_of_no_dome():
    slab = Cube((40.0, 40.0, 8.0)).at(0.0, -20.0, -4.0)
    leans = [(lean, back) for lean in np.linspace(0.2, 0.5, 7) for back in (0.5, 1.0, 1.5, 2.0)]
    poses = [(se3.rotation_exp([-lean, 0.0, 0.0]) @ DOWN, 0.0, -back) for lean, back in leans]
    off = np.concatenate([presses(slab, poses, force=force, sensor="fingertip") for force in (1.0, 2.0, 4.0)])
    assert len(off) > 5
    assert off.max() < 0.5  # 1.3 beside a dome that is none


def test_a_step_that_the_skin_spans_is_not_taken_for_a_hollow_face():
    recess = Cube((80.0, 60.0, 20.0)).at(0, 0, -10.0) - Cube((54.0, 45.0, 10.0)).at(0, 0, 2.6)
    rng, poses = np.random.default_rng(5), []
    for _ in range(40):
        lean, turn = rng.uniform(0.05, 0.22), rng.choice([0.0, np.pi / 2]) + rng.normal(0.0, 0.05)
        turned = se3.rotation_exp([0.0, lean, 0.0]) @ se3.rotation_exp([0.0, 0.0, turn]) @ DOWN
        poses.append((turned, rng.uniform(-24.0, -12.0), rng.uniform(-8.0, 8.0)))
    off = presses(recess, poses)
    assert len(off) > 5
    assert off.max() < 0.4


def leans(width: float, beyond: float, frames: int):
    """(n,) [sigma] that contacts of a strip lean across it, whose far edge lies by the outermost taxels."""
    spec = load_sensor("lts210")
    spec = replace(spec, electronics=replace(spec.electronics, noise=0.05))
    solid, rng = Solid.from_csg(Cube((60.0, width, 30.0)).at(0.0, 0.0, -15.0)), np.random.default_rng(5)
    found = []
    for _ in range(10):
        lean = np.radians(rng.uniform(-3.0, 3.0))
        off = 0.5 * width + beyond - 9.0
        turn = se3.rotation_exp([lean, 0.0, 0.0]) @ DOWN
        start = se3.pose(turn, [rng.uniform(-4.0, 4.0), off, -0.5 + np.tan(lean) * off])
        stage, arrays = simulate(solid, [spec], rng, start_pose=start)
        kept = []
        keep(dwell(Guard(stage, arrays, [Calibration.nominal(spec)]), frames), 1, 1, kept)
        found.extend(np.arctan2(c.normals[0, 1], c.normals[0, 2]) / c.normal_sigma[0] for c in kept if len(c))
    return np.array(found)


@pytest.mark.parametrize("frames", [1, 8])
def test_a_strip_whose_edge_is_hidden_at_the_pads_end_says_that_it_may_lean(frames):
    off = np.concatenate(
        [leans(width, beyond, frames) for width in (7.4, 9.0) for beyond in (-0.5, 0.0, 0.5)]
    )
    assert len(off) > 30
    assert np.sqrt(np.mean(off**2)) < 1.6


def test_a_few_taxels_on_a_flat_face_are_refused_as_seldom_as_many():
    """Of thirteen degrees of freedom noise alone has 1.8 times its mean once in thirty presses."""
    spec, rng = load_sensor("fingertip"), np.random.default_rng(6)
    spec = replace(spec, electronics=replace(spec.electronics, noise=0.05))
    solid, told = Solid.from_csg(Cube((40.0, 40.0, 10.0))), 0
    for _ in range(150):
        at = [*rng.uniform(-8.0, 8.0, 2), 4.5]
        stage, arrays = simulate(solid, [spec], rng, start_pose=se3.pose(DOWN, at))
        kept = []
        keep(dwell(Guard(stage, arrays, [Calibration.nominal(spec)]), 8), 1, 1, kept)
        told += bool(kept)
    assert told >= 148


def test_a_notched_ring_narrower_than_the_pad_is_felt_flat():
    ring = Cylinder(48.0, 8.0) - Cylinder(40.0, 10.0)
    for turn in np.arange(-0.6, 0.7, 0.3):
        ring = ring - Cylinder(2.5, 10.0).at(46.0 * np.cos(turn), 46.0 * np.sin(turn), 0.0)
    off, sigma, counts = errors(ring.at(-38.0, 0.0, -4.0), 0.0, 8, presses=24)
    assert np.mean(np.array(counts) > 0) > 0.9
    assert np.quantile(np.abs(off / sigma), 0.95) < 2.0  # but for one over a notch, beside the ring
