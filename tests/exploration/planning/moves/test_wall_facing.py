"""What becomes of a wall once it was looked at."""

from types import SimpleNamespace

import numpy as np
import pytest

from exploration.planning.moves import wall_facing
from exploration.planning.moves.wall_facing import Walls
from exploration.planning.touching.findings import Findings
from exploration.planning.touching.study import Wall

X, UP = np.eye(3)[0], np.eye(3)[2]


def wall(x: float, stopped: bool = True) -> Wall:
    return Wall(np.array([x, 0.0, 0.0]), X, UP, np.eye(4), np.array([9.0, 14.0]), stopped)


@pytest.fixture
def walls(monkeypatch):
    """Walls of a study that met two, one of them only seen ahead; `there` says what looking finds."""
    pad = SimpleNamespace(tool=SimpleNamespace(carried=()), felt=[])
    study = SimpleNamespace(pad=pad, found=Findings(), walls=[wall(50.0, stopped=False), wall(0.0)])
    made = Walls(study)
    made.there, made.led = None, True

    def looked(_study, reach, _wall):
        reach.led = made.led
        return made.there, "looked"

    monkeypatch.setattr(wall_facing, "face_wall", looked)
    return made


def test_a_wall_that_is_not_there_is_forgotten_and_the_object_stays_convex(walls):
    walls.look(walls.next())
    assert walls.next() is None
    assert len(walls.study.walls) == 1
    assert not walls.study.found.hollow
    assert (
        walls.study.pad.here.normal is UP
    )  # who met nothing goes on from in front of the face that it stood on


def test_one_looked_at_in_vain_is_open_again_once_the_object_is_known_to_be_hollow(walls):
    met = walls.next()
    walls.look(met)
    walls.recall()
    walls.recall()
    assert [wall for wall in walls.study.walls if wall.stopped] == [met]


def test_one_that_stops_a_stroke_at_the_same_place_again_is_believed(walls):
    walls.look(walls.next())
    walls.study.walls.append(wall(4.0))
    walls.look(walls.next())
    assert walls.study.found.hollow


@pytest.mark.parametrize(("there", "led"), [(3, True), (None, False)])
def test_one_that_was_touched_or_that_no_way_leads_to_is_believed(walls, there, led):
    walls.there, walls.led = there, led
    assert walls.look(walls.next())[0] == there
    assert walls.study.found.hollow
    assert len(walls.study.walls) == 2
