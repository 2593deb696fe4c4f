from dataclasses import replace

import numpy as np
import pytest
import trimesh

from exploration.devices.simulated import simulate
from exploration.sensing.calibration import Calibration, correct
from exploration.sensing.spec import load_sensor
from models.solid import Solid
from primitives.errors import PalpateError
from primitives.pose import pose

LTS = load_sensor("lts210")
DOWN = np.diag([1.0, -1.0, -1.0])
QUIET = replace(LTS, electronics=replace(LTS.electronics, noise=0.0))


@pytest.fixture(scope="module")
def block():
    mesh = trimesh.creation.box((60.0, 60.0, 40.0))
    return Solid.from_mesh(mesh.vertices, mesh.faces)


def pressed(surface, spec, seed=0, **options):
    """Frames of a press from 3 mm above to 0.5 mm deep, across the block's edge."""
    above = pose(DOWN, [28.0, 2.0, 23.0])
    stage, (array,) = simulate(surface, [spec], np.random.default_rng(seed), start_pose=above, **options)
    stage.go_to(pose(DOWN, [28.0, 2.0, 19.5]))
    frames = []
    while stage.moving:
        frames.append(array.read())
    return stage, array, [*frames, array.read()]


@pytest.mark.parametrize("name", ["lts210", "piezoresistive", "conductive_elastomer"])
def test_the_same_seed_gives_the_same_frames_and_another_does_not(block, name):
    runs = [np.stack([f.counts for f in pressed(block, load_sensor(name), seed)[2]]) for seed in (7, 7, 8)]
    assert (runs[0] == runs[1]).all()
    assert (runs[0] != runs[2]).any()


def test_free_space_without_rays_reads_as_with_them(block, monkeypatch):
    frames = {}
    for name in ("fast", "slow"):
        if name == "slow":
            monkeypatch.setattr("exploration.devices.free_space_bound.FreeSpaceBound.holds", lambda *_: False)
        high = pose(DOWN, [28.0, 2.0, 120.0])
        stage, (array,) = simulate(block, [LTS], np.random.default_rng(3), start_pose=high)
        stage.go_to(pose(DOWN, [28.0, 2.0, 19.5]))
        frames[name] = []
        while stage.moving:
            frames[name].append(array.read().counts)
    assert (np.stack(frames["fast"]) == np.stack(frames["slow"])).all()


def test_frames_come_every_period_and_are_numbered(block):
    _, array, frames = pressed(block, LTS)
    assert [f.index for f in frames] == list(range(len(frames)))
    assert np.diff([f.time for f in frames]) == pytest.approx(np.full(len(frames) - 1, array.period))


def test_a_pressed_edge_shows_the_press_depth_and_its_half_height(block):
    _, _, frames = pressed(block, QUIET)
    depth = correct(frames[-1], Calibration.nominal(QUIET), LTS.array).depth
    assert depth[:, :6] == pytest.approx(np.full((10, 6), 0.5), abs=0.01)
    assert depth[:, 13:] == pytest.approx(np.zeros((10, 3)), abs=0.01)
    crossing = np.interp(-0.25, -depth[5, 5:13], LTS.array.x[5:13])
    assert crossing == pytest.approx(2.0, abs=0.1)


def test_rows_are_sampled_one_after_another(block):
    slow = replace(QUIET, electronics=replace(QUIET.electronics, scan=0.005, bits=16, plateau=20000.0))
    stage, (array,) = simulate(
        block, [slow], np.random.default_rng(0), start_pose=pose(DOWN, [28.0, 2.0, 19.5])
    )
    stage.move(np.array([100.0, 0, 0, 0, 0, 0]))
    for _ in range(14):
        frame = array.read()
    depth = correct(frame, Calibration.nominal(slow), LTS.array).depth
    place = depth.sum(axis=1) / 0.5 * 1.8
    assert place[1] - place[8] == pytest.approx(100.0 * 0.005 * 7 / 9, rel=0.05)
    assert frame.time == pytest.approx(14 * 0.005 - 0.005)


def test_collision_and_overpress_are_events_told_once(block):
    stage, (array,) = simulate(
        block, [QUIET], np.random.default_rng(0), start_pose=pose(DOWN, [0.0, 0.0, 15.5])
    )
    array.read()
    assert {e.kind for e in stage.events()} == {"collision", "overpress"}
    assert stage.events() == ()


def test_arrays_on_one_stage_share_its_clock(block):
    finger = load_sensor("fingertip")
    _, arrays = simulate(block, [LTS, finger], np.random.default_rng(0), start_pose=pose(None, [0, 0, 300.0]))
    times = [a.read().time for a in arrays]
    assert times[0] == times[1]
    facing = [(a.flange_from_sensor @ [0, 0, 1, 0])[:3] for a in arrays]
    assert facing[0] @ facing[1] == pytest.approx(-1.0)


def test_an_array_that_is_not_in_use_must_meet_nothing(block):
    finger = load_sensor("fingertip")
    for gap, met in ((1.0, set()), (-1.0, {("collision", "fingertip")})):
        at = pose(None, [0.0, 0.0, 20.0 + gap + 63.0])
        stage, (pad, _) = simulate(block, [LTS, finger], np.random.default_rng(0), start_pose=at)
        pad.read()
        assert {(event.kind, event.source) for event in stage.events()} == met


def test_the_noise_asked_for_is_the_noise_given(block):
    _, (array,) = simulate(
        block, [LTS], np.random.default_rng(0), noise=0.05, start_pose=pose(DOWN, [0, 0, 19.6])
    )
    counts = np.stack([array.read().counts for _ in range(50)])
    assert counts.std(axis=0).mean() == pytest.approx(0.05 * 120.0, rel=0.05)
    assert array.spec.electronics.noise == 0.05


def test_no_sensor_is_a_known_error(block):
    with pytest.raises(PalpateError, match="at least one sensor"):
        simulate(block, [], np.random.default_rng(0))
