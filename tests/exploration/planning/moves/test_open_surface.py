"""How long the pad goes after surface that faces seem to have."""

from types import SimpleNamespace

import numpy as np
import pytest

from exploration.control.procedures.settle import AS_IT_CAME
from exploration.planning.known.surface_map import SurfaceMap
from exploration.planning.moves.open_surface import OpenSurface, OpenSurfaceConfig
from exploration.planning.open.frontier import Predicted
from exploration.planning.touching.findings import ExplorerConfig
from primitives import pose as se3
from primitives.shapes import Plane

UP = np.array([0.0, 0.0, 1.0])


def pad_that_lands_on(faces, contacts):
    """A study and a reach, whose touches name those faces in turn; None where nothing was met.

    Face 7 has so many contacts.
    """
    faces = list(faces)
    pad = SimpleNamespace(size=(10.0, 10.0), guard=SimpleNamespace(world_from_sensor=np.eye(4)))
    faces_found = SimpleNamespace(faces=[SimpleNamespace(id=7, contacts=contacts, fit=None)])
    found = SimpleNamespace(graph=faces_found, barred=[], fit_of=lambda face: None)
    study = SimpleNamespace(pad=pad, found=found, face_here=lambda: faces.pop(0))

    def touch(pose, *_):
        pad.guard.world_from_sensor = pose
        if faces[0] is None:
            faces.pop(0)
            return False
        return True

    return study, SimpleNamespace(clear=lambda pose: True, touch=touch, led=True)


def left_after(met, contacts=()):
    """How many of 30 open places on face 7, and of one on face 8, are left after touches that met `met`."""
    surface = OpenSurface(
        *pad_that_lands_on(met, contacts),
        ExplorerConfig(),
        OpenSurfaceConfig(misses=3, known=40, known_misses=4),
    )
    points = np.array([[20.0 * k, 0.0, 0.0] for k in range(31)])
    opened = Predicted(points, np.tile(UP, (31, 1)), np.array([7] * 30 + [8]))
    for k in range(len(met)):
        surface.come_down(opened, k)
    return len(surface.left(opened).points)


def test_a_face_that_was_missed_too_often_in_a_row_ends_where_it_was_felt():
    assert left_after([None, 3, None]) == 1
    assert left_after([None, 3, 7, None, 3]) > 20


def test_a_face_that_is_well_known_is_missed_oftener():
    assert left_after([None, 3, None], range(40)) > 20
    assert left_after([None, 3, None, 3], range(40)) == 1


def test_where_a_pad_met_nothing_all_that_it_would_have_felt_is_known():
    surface = OpenSurface(*pad_that_lands_on([None], ()), ExplorerConfig())
    points = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [4.0, 4.0, 0.5], [30.0, 0.0, 0.0]])
    opened = Predicted(points, np.tile(UP, (4, 1)), np.full(4, 7))
    surface.come_down(opened, 0)
    assert np.allclose(surface.left(opened).points, points[3])


def test_what_no_stroke_led_to_is_come_down_on_yet():
    study, reach = pad_that_lands_on([None], ())
    strokes = [SimpleNamespace(travel=0.2, contacts=(), ended="edge")]
    study.pad.stroke, study.note_wall = lambda heading, length: strokes[0], lambda stroke: False
    surface = OpenSurface(study, reach, ExplorerConfig())
    points = np.array([[12.0, 0.0, 0.0], [0.0, 20.0, 0.0]])
    opened = Predicted(points, np.tile(UP, (2, 1)), np.full(2, 7))
    assert np.allclose(surface.near(opened, 7), points[0])
    surface.stroke_to(points[0], 7)
    assert np.allclose(surface.near(surface.left(opened), 7), points[1])
    assert len(surface.left(opened).points) == 2
    strokes[0] = SimpleNamespace(travel=18.0, contacts=(), ended="length")
    for _ in range(ExplorerConfig().tries - 1):
        surface.stroke_to(points[1], 7)
    assert np.allclose(surface.left(opened).points, points[:1])
    assert surface.near(surface.left(opened), 7) is None
    assert surface.near(opened, 8) is None


def test_what_a_pad_lay_over_twice_is_not_come_down_on_again():
    surface = OpenSurface(*pad_that_lands_on([7, 7, 7], range(99)), ExplorerConfig())
    points = np.array(
        [[3.0, 3.0, 0.0], [-3.0, 3.0, 0.0], [-3.0, -3.0, 0.0], [7.5, 0.0, 0.0], [3.0, -3.0, 0.0]]
    )
    opened = Predicted(points, np.tile(UP, (5, 1)), np.array([7, 7, 7, 7, 8]))
    surface.come_down(opened, 0)
    assert len(surface.left(opened).points) == 5
    surface.come_down(opened, 1)
    assert np.allclose(surface.left(opened).points, points[3:])


@pytest.mark.parametrize("told", [True, False])
def test_a_pad_that_rolls_off_a_narrow_land_lies_there_as_it_came(told):
    study, reach = pad_that_lands_on([], range(99))
    flat = SimpleNamespace(kind="plane", shape=Plane(np.zeros(3), UP), convex=True)
    study.found.fit_of, landings = lambda face: flat, []

    def touch(pose, give=False, settling=None, landing=None):
        landings.append(settling)
        rolled = se3.pose(se3.rotation_exp([0.6, 0.0, 0.0]) @ pose[:3, :3], pose[:3, 3])
        study.pad.guard.world_from_sensor = pose if settling else rolled
        return settling is not None

    reach.touch, study.pad.feel, study.take_in = touch, lambda: "felt", lambda felt: 7 if told else None
    surface = OpenSurface(study, reach, ExplorerConfig(), OpenSurfaceConfig(misses=1))
    opened = Predicted(np.array([[0.0, 0.0, 0.0], [40.0, 0.0, 0.0]]), np.tile(UP, (2, 1)), np.array([7, 7]))
    home, note = surface.come_down(opened, 0)
    assert (home, note) == (
        (7, "came down on what was open") if told else (None, "what was open told no face")
    )
    assert landings == [None, AS_IT_CAME]
    assert len(surface.left(opened).points) == 2


@pytest.mark.parametrize("led", [True, False])
def test_it_comes_down_again_only_where_there_was_a_way(led):
    study, reach = pad_that_lands_on([], range(99))
    flat = SimpleNamespace(kind="plane", shape=Plane(np.zeros(3), UP), convex=True)
    study.found.fit_of, landings, reach.led = lambda face: flat, [], led

    def touch(pose, *_):
        landings.append(pose)
        study.pad.guard.world_from_sensor = se3.pose(se3.rotation_exp([0.6, 0.0, 0.0]) @ pose[:3, :3])
        return False

    reach.touch = touch
    surface = OpenSurface(study, reach, ExplorerConfig(), OpenSurfaceConfig(lain=1))
    opened = Predicted(np.array([[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]]), np.tile(UP, (2, 1)), np.array([7, 7]))
    assert surface.come_down(opened, 0) == (None, "what seemed open was not there")
    assert len(landings) == (2 if led else 1)
    assert len(surface.left(opened).points) == (0 if led else 2)


def boss_in_the_way(top, met=True):
    """A surface, whose open place something felt leaves no room at; its top was felt, or was not."""
    study, reach = pad_that_lands_on([9 if met else None], ())
    way = UP if top else np.array([1.0, 0.0, 0.0])
    reach.clear, reach.off = lambda pose: False, lambda pose, most: 4.8
    reach.felt = SimpleNamespace(points=np.array([[1.0, 0.0, 3.0]]), facing=way[None])
    at: list[np.ndarray] = []
    land = reach.touch
    reach.touch = lambda pose: at.append(pose) or land(pose)
    return OpenSurface(study, reach, ExplorerConfig()), at


def test_what_stands_on_open_surface_is_come_down_on_from_over_what_is_known_of_it():
    opened = Predicted(np.zeros((1, 3)), UP[None], np.array([7]))
    surface, at = boss_in_the_way(top=False)
    assert surface.come_down(opened, 0) == (9, "came down on what stands where surface was open")
    assert at[0][2, 3] == 4.8
    assert surface.come_down(opened, 0)[0] is None
    assert len(at) == 1
    surface, at = boss_in_the_way(top=True)
    assert surface.come_down(opened, 0) == (None, "the pad has no room on what is open")
    assert at == []
    surface, at = boss_in_the_way(top=False, met=False)
    assert surface.come_down(opened, 0) == (None, "nothing stands where surface was open")


def test_where_there_is_no_room_a_flat_face_may_end_where_it_was_felt_last():
    x, y = np.meshgrid(np.arange(-10.0, 11.0, 2.0), np.arange(-10.0, 11.0, 2.0))
    felt = SurfaceMap()
    felt.add(np.column_stack([x.ravel(), y.ravel(), 0.1 * (x.ravel() > 0)]), np.tile(UP, (x.size, 1)))
    study, reach = pad_that_lands_on([], ())
    flat = SimpleNamespace(kind="plane", shape=Plane(np.zeros(3), UP), convex=True)
    study.found.fit_of = lambda face: flat
    reach.felt, reach.clear, reach.off = felt, lambda pose: False, lambda pose, most: 0.0
    opened = Predicted(np.array([[15.0, 2.0, 0.0]]), UP[None], np.array([7]))
    assert OpenSurface(study, reach, ExplorerConfig()).come_down(opened, 0)[0] is None
    ((edge, face),) = study.found.barred
    assert face == 7
    assert edge.point[0] == 10.0
    assert edge.outward.tolist() == [1.0, 0.0, 0.0]
