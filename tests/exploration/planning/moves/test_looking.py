"""Which way an object lies, for looking at it from afar."""

from types import SimpleNamespace

import numpy as np
import pytest

from exploration.devices.guard import Collision
from exploration.planning.moves.looking import LOOK_AGAIN, Looking, own_axes
from exploration.planning.open.views import View
from primitives import pose as se3
from primitives.evidence import Contacts
from primitives.fit import fit
from primitives.patch_graph import Face
from primitives.shapes import Plane, Sphere, Torus

RING = Torus([5.0, 0, 0], [0.0, 0.6, 0.8], 22.0, 6.0)
FLOOR = Plane([0, 0, -6.0], [0.6, 0, -0.8])


def face(shape, count):
    """Contacts all over a shape, as a face."""
    points = shape.project(np.random.default_rng(0).uniform(-30, 30, (count, 3)))
    contacts = Contacts.of(points, shape.normals(points), touch=np.arange(count))
    return Face(0, fit(shape.kind, contacts), contacts)


@pytest.mark.parametrize(
    ("shapes", "along"),
    [([(RING, 60)], RING.axis), ([(RING, 60), (FLOOR, 20)], FLOOR.normal), ([(Sphere([0, 0, 0], 9.0), 30)], None)],
)  # fmt: skip
def test_the_first_is_that_of_a_flat_face_or_else_of_a_round_one(shapes, along):
    axes = own_axes([face(*shape) for shape in shapes])
    assert np.allclose(axes.T @ axes, np.eye(3))
    if along is not None:
        assert np.abs(axes.T @ along).max() == pytest.approx(1.0, abs=1e-3)


class Space:
    """Of which cells were set aside."""

    def __init__(self):
        self.aside = []

    def set_aside(self, places):
        self.aside.append(places)


def looking(meets, told=None, face=1):
    """A look from afar at a ring, which meets something or nothing, and what it sets aside."""
    swept = Space()
    guard = SimpleNamespace(world_from_sensor=np.eye(4), go_to=lambda pose: None)
    pad = SimpleNamespace(swept=swept, guard=guard, told=told, come_down=lambda *how: meets)
    pad.on_told = lambda: told is not None
    felt = SimpleNamespace(points=RING.project(np.random.default_rng(0).uniform(-30, 30, (40, 3))))
    reach = SimpleNamespace(felt=felt, led=True, come_out=lambda: None)
    reach.go = lambda start: guard.__setattr__("world_from_sensor", start) or True
    study = SimpleNamespace(pad=pad, face_here=lambda: face)
    return Looking(study, reach), swept


VIEW = View(se3.pose(translation=[0.0, 0.0, 0.0]), np.zeros((5, 3)))


def test_what_lies_behind_something_that_was_met_may_be_looked_at_from_another_side():
    look, swept = looking(meets=True)
    look._look(VIEW)
    assert not swept.aside
    look._look(VIEW)  # met again where nothing felt ends the view
    assert len(swept.aside) == 1


def test_what_was_looked_at_and_met_nothing_is_done_with():
    look, swept = looking(meets=False)
    look._look(VIEW)
    assert len(swept.aside) == 1


TABLE = SimpleNamespace(surface=SimpleNamespace(signed_distance=lambda points: points[:, 2] + 100.0))


def test_an_array_that_looks_again_looks_no_more_after_some_looks_in_vain():
    look, _ = looking(meets=False)
    look.config = LOOK_AGAIN
    for _ in range(LOOK_AGAIN.vain - 1):
        look._look(VIEW)
    look.study.pad.come_down = lambda *how: True
    look._look(VIEW)
    assert look._vain == 0  # what was met makes up for all of them
    look.study.pad.come_down = lambda *how: False
    for _ in range(LOOK_AGAIN.vain):
        look._look(VIEW)
    assert look.next() is None


def test_a_view_that_ends_on_the_table_is_done_with():
    look, swept = looking(meets=True, told=TABLE, face=None)
    look._look(VIEW)
    assert len(swept.aside) == 1


def test_the_table_is_no_part_of_what_is_looked_at():
    look, _ = looking(meets=True, told=TABLE)
    ball = look._ball()
    felt = look.reach.felt
    felt.points = np.concatenate([felt.points, [[400.0, 0.0, -100.3], [0.0, 400.0, -99.8]]])
    assert look._ball().radius == pytest.approx(ball.radius)


def test_what_is_told_makes_up_for_no_look_in_vain():
    look, _ = looking(meets=True, told=TABLE, face=None)
    look._look(VIEW)
    assert look._vain == 1
    assert look._unnamed == 0


def test_looks_that_meet_what_names_no_face_are_made_no_more_after_some():
    look, _ = looking(meets=True, face=None)
    look._left = 1000
    for _ in range(look.config.unnamed - 1):
        look._look(VIEW)
    look.study.face_here = lambda: 1
    look._look(VIEW)
    assert look._unnamed == 0
    look.study.face_here = lambda: None
    for _ in range(look.config.unnamed):
        look._look(VIEW)
    assert look.next() is None


def test_a_look_that_a_collision_stopped_on_the_way_twice_is_not_tried_again():
    look, swept = looking(meets=True)

    def collide(start):
        raise Collision("collision of lts210 by 0.10 mm")

    look.reach.go = collide
    for aside in (0, 1):
        with pytest.raises(Collision):
            look._look(VIEW)
        assert len(swept.aside) == aside
