"""Looks at the rims of round holes."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exploration.control.procedures.tare import tare
from exploration.devices.guard import Guard
from exploration.devices.simulated import simulate
from exploration.planning.faces.attribution import AttributionConfig
from exploration.planning.faces.consistency import drop_poor
from exploration.planning.moves.round_holes import RoundHoles
from exploration.planning.open.round_rims import RoundRim
from exploration.planning.touching.findings import Findings
from exploration.planning.touching.pad import Pad
from exploration.planning.touching.reach import Reach
from exploration.planning.touching.study import Study
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import load_sensor
from models.csg import Cube, Cylinder
from models.solid import Solid
from primitives import pose as se3
from primitives.evidence import Contacts
from primitives.patch_graph import MergeOptions, PatchGraph, ranked_face

UP = np.array([0.0, 0.0, 1.0])


def rim(height, up=1.0, radius=6.0, x=0.0, measured=True):
    return RoundRim(np.array([x, 0.0, height]), up * UP, radius, 0.02, 0, measured)


@pytest.mark.parametrize(
    ("sensor", "wall", "rolled"),
    [("lts210", 1.5, False), ("lts210", 3.0, False), ("optical", 1.5, False), ("lts210", 5.0, True)],
)
def test_a_look_at_the_end_of_a_thin_tube_makes_a_face_of_it_and_measures_its_bore(sensor, wall, rolled):
    """Also where a pad that rolled over the ring has left a face of it that is too poor to keep."""
    tube = Solid.from_csg(Cylinder(16.0, 40.0) - Cylinder(16.0 - wall, 99.0))
    spec, start = load_sensor(sensor), se3.pose(se3.frame_along(-UP), [0.0, 0.0, 60.0])
    stage, arrays = simulate(tube, [spec], np.random.default_rng(0), noise=0.05, start_pose=start)
    guard = Guard(stage, arrays, [Calibration.nominal(arrays[0].spec)])
    tare(guard)
    box = np.array([-80.0, -80.0, -80.0, 80.0, 80.0, 80.0])
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    ring = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(24)])
    points = np.concatenate([16.0 * ring + z * UP for z in (-8.0, 0.0, 8.0)])
    side = ranked_face(1, Contacts.of(points, np.tile(ring, (3, 1)), 0.01, 0.01), MergeOptions())
    pad = Pad(guard, box, lambda kind, detail: None)
    poor = (16.0 - 0.5 * wall) * ring[::4] + (20.0 + 0.6 * (-1.0) ** np.arange(6)[:, None]) * UP
    aslant = ranked_face(2, Contacts.of(poor, np.tile(UP, (6, 1)), 0.05, 0.1), MergeOptions())
    graph = PatchGraph((side, aslant) if rolled else (side,), ())
    assert len(drop_poor(graph).faces) == 1
    found = Findings(hollow=True, graph=graph)
    holes = RoundHoles(study := Study(pad, found, AttributionConfig(convex=False)), Reach(pad))
    guess = 13.0 - wall if rolled else 15.0 - wall  # cells of the ring are felt up to 3 mm inside its bore
    rim = RoundRim(20.0 * UP, UP, guess, 1.0, 2 if rolled else 1, outer=16.0)
    assert holes.next([rim])()[1] == "looked at the rim of a round hole"
    (seen,) = study.found.rims
    assert seen.radius == pytest.approx(16.0 - wall, abs=0.05)
    end = drop_poor(study.found.graph).faces[-1]
    assert seen.face == end.id != 1
    assert np.median(end.contacts.points[:, 2]) == pytest.approx(20.0, abs=0.08)
    assert holes.next([rim]) is None


def looking(faces=(), size=(28.8, 18.0)):
    """The looks of an exploration that knows so many faces, with a pad of a size."""
    pad = SimpleNamespace(size=size, guard=SimpleNamespace(world_from_sensor=np.eye(4)))
    study = SimpleNamespace(pad=pad, found=Findings(graph=PatchGraph(tuple(faces), ())))
    return RoundHoles(study, SimpleNamespace())


def test_how_narrow_a_ring_is_for_a_pad_depends_on_the_pad():
    ring = replace(rim(20.0, radius=10.0), outer=17.0)
    assert looking()._slim(ring)
    assert not looking(size=(12.0, 12.0))._slim(ring)


def test_a_wider_rim_is_looked_for_where_none_of_the_guessed_width_was_seen():
    looks = looking()
    looks._missed.append(rim(5.0, radius=6.0))
    assert looks.next([rim(5.0, radius=7.0)]) is None
    assert looks.next([rim(5.0, radius=14.0)]) is not None
    looks._seen.note(rim(5.0).center)
    assert looks.next([rim(5.0, radius=14.0)]) is None


def test_the_end_of_a_tube_is_looked_at_as_a_ring_and_not_as_the_far_end_of_its_bore():
    ring, bore = replace(rim(20.0, radius=9.0), outer=14.0), rim(19.5, radius=13.5)
    behind = rim(19.5, up=-1.0, radius=12.0)  # of a thin disc
    looks = looking()
    assert looks.next([bore, ring]).args == (ring,)
    assert looks.next([behind, ring]).args == (behind,)
    looks._missed.append(ring)
    assert looks.next([bore, ring]).args == (bore,)


def test_a_face_ends_at_what_stands_beside_a_hole_and_not_at_a_boss_or_far_off():
    def flat(number, normal, at):
        aside = np.cross(normal, UP)
        points = at + np.array([a * aside + b * UP for a in (-6.0, 0.0, 6.0) for b in (-3.0, 3.0)])
        return ranked_face(number, Contacts.of(points, np.tile(normal, (6, 1))), MergeOptions())

    x = np.eye(3)[0]
    edge, boss, far = flat(0, x, 7.0 * x), flat(1, x, -9.0 * x), flat(2, x, 60.0 * x)
    ((shape, side),) = looking([edge, boss, far])._ends(rim(0.0))
    assert side * shape.signed_distance(np.array([[8.0, 0.0, 0.0]]))[0] > 0.9


def test_a_flange_does_not_end_at_the_neck_behind_it():
    turn = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
    ring = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(24)])
    neck = np.concatenate([16.0 * ring + deep * UP for deep in (-6.0, -9.0, -12.0)])
    barrel = ranked_face(1, Contacts.of(neck, np.tile(ring, (3, 1))), MergeOptions())

    def flange(outer):
        points = np.concatenate([radius * ring for radius in np.arange(11.0, outer, 1.5)])
        return ranked_face(0, Contacts.of(points, np.tile(UP, (len(points), 1))), MergeOptions())

    mouth = replace(rim(0.0, radius=10.0), face=0)
    assert not looking([flange(24.0), barrel])._ends(mouth)
    assert len(looking([flange(15.5), barrel])._ends(mouth)) == 1


@pytest.mark.parametrize(("hole", "wide"), [(Cube((9.0, 9.0, 99.0)), 9.0 / np.sqrt(np.pi)), (None, None)])
def test_an_opening_that_is_not_round_is_told_apart_from_none(hole, wide):
    block = Cube((60.0, 50.0, 40.0)) - hole if hole is not None else Cube((60.0, 50.0, 40.0))
    spec, start = load_sensor("lts210"), se3.pose(se3.frame_along(-UP), [0.0, 0.0, 60.0])
    stage, arrays = simulate(
        Solid.from_csg(block), [spec], np.random.default_rng(0), noise=0.05, start_pose=start
    )
    guard = Guard(stage, arrays, [Calibration.nominal(arrays[0].spec)])
    tare(guard)
    pad = Pad(guard, np.array([-80.0, -80.0, -80.0, 80.0, 80.0, 80.0]), lambda kind, detail: None)
    points = np.array([[x, y, 20.0] for x in (-20.0, 0.0, 20.0) for y in (-16.0, 16.0)])
    top = ranked_face(1, Contacts.of(points, np.tile(UP, (6, 1)), 0.01, 0.01), MergeOptions())
    study = Study(pad, Findings(hollow=True, graph=PatchGraph((top,), ())), AttributionConfig(convex=False))
    RoundHoles(study, Reach(pad)).next([RoundRim(20.0 * UP, UP, 4.0, 0.5, 1)])()
    assert study.found.rims == []
    assert len(study.found.refuted) == 1
    RoundHoles(study, Reach(pad)).next([RoundRim(np.array([0.0, 24.0, 20.0]), UP, 5.0, 0.5, 1)])()
    assert [rim.radius for rim in study.found.odd] == ([] if wide is None else [pytest.approx(wide, abs=0.8)])
