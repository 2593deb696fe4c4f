"""What the skin shows in passing."""

from types import SimpleNamespace

import numpy as np

from exploration.planning.known.mosaic import Lattice
from exploration.planning.known.skin import Skin
from exploration.sensing.frame import TactileImage, TaxelArray
from primitives.pose import pose, rotation_exp

ARRAY = TaxelArray("small", 10, 16, (1.8, 1.8))
DOWN = rotation_exp([np.pi, 0.0, 0.0])
LATTICE = Lattice.over(np.array([[-8.0, -8.0, 0.0], [8.0, 8.0, 0.0]]), np.eye(3)[:, :2], 0.5, 0.0)


def pressed(x, depth=0.6):
    image = TactileImage(ARRAY, np.full(ARRAY.shape, depth), np.full(ARRAY.shape, 0.03), 1.0, 0.1, 0.0)
    return SimpleNamespace(image=image, world_from_sensor=pose(DOWN, [x, 0.0, -0.6]))


def known(skin):
    return skin.mosaic.picture(np.zeros(3), np.array([0.0, 0.0, 1.0]), LATTICE).known.any()


def test_a_picture_grows_where_the_pad_is_pressed_and_not_where_it_hangs_in_the_air():
    skin = Skin()
    skin.look(pressed(0.0, 0.0))
    assert not known(skin)
    skin.look(pressed(0.0))
    assert known(skin)


def test_what_lies_on_what_is_told_to_stand_beside_the_object_makes_no_picture_of_it():
    skin = Skin(SimpleNamespace(beside=lambda places: places[:, 0] < 1.0))
    skin.look(pressed(0.0))
    seen = skin.mosaic.picture(np.zeros(3), np.array([0.0, 0.0, 1.0]), LATTICE).known
    assert seen[:12].any()
    assert not seen[24:].any()


def test_what_a_pad_shows_that_lies_still_is_pictured_though_it_touched_there_before():
    skin = Skin()
    light = pressed(0.0, 0.1)
    light.world_from_sensor = pose(DOWN, [0.0, 0.0, -0.1])
    skin.look(light)
    assert not known(skin)
    skin.look(pressed(0.0))
    assert not known(skin)
    skin.dwell(pressed(0.0))
    assert known(skin)
