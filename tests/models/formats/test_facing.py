"""Solids that are inside out in places."""

import numpy as np
import pytest
import trimesh

from models import parts
from models.formats import load as door
from models.formats.facing import seen_from_behind
from models.solid import Solid
from primitives.errors import PalpateError


def test_a_box_whose_upper_half_is_mirrored_shows_its_back():
    box = trimesh.creation.box((20.0, 20.0, 20.0))
    mirrored = box.vertices * np.where(box.vertices[:, 2:] > 0.0, [[-1.0, 1.0, 1.0]], [[1.0, 1.0, 1.0]])
    assert seen_from_behind(Solid.from_mesh(mirrored, box.faces)) > 0.1


@pytest.mark.parametrize("name", ["block", "pipe", "sphere", "spur_gear", "cavity_block"])
def test_no_part_shows_its_back(name):
    assert seen_from_behind(Solid.from_csg(parts.build(name))) == 0.0


def test_a_file_that_is_inside_out_is_refused_in_one_line(tmp_path, monkeypatch):
    monkeypatch.setattr(door, "seen_from_behind", lambda solid: 0.18)
    trimesh.creation.box((20.0, 20.0, 20.0)).export(tmp_path / "head.stl")
    with pytest.raises(PalpateError, match=r"^head.stl is inside out in places: 18% .*; repair it in CAD"):
        door.load(tmp_path / "head.stl")
