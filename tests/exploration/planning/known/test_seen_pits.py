"""Narrow holes over many frames: of the object, of the pad, or of neither."""

from types import SimpleNamespace

import numpy as np
import pytest

from exploration.planning.known import seen_pits
from exploration.planning.known.seen_pits import SeenPits
from exploration.sensing.lines.pits import Pit
from primitives.pose import pose


def looked_at(monkeypatch, where, at):
    """What frames with a pit at (2,) places on the pad tell, the pad being at (3,) places."""
    seen = SeenPits()
    for place, origin in zip(where, at, strict=True):
        monkeypatch.setattr(seen_pits, "pits", lambda _, p=place: [Pit(np.array(p), 0.3, 2.0)])
        seen.look(SimpleNamespace(image=None, world_from_sensor=pose(np.eye(3), np.array(origin))))
    return seen.sure


def test_what_stays_with_the_object_is_one_and_what_stays_with_the_pad_or_comes_once_is_none(monkeypatch):
    moved = [(0.0, 0.0, 0.0), (3.0, 0.0, 0.0), (6.0, 0.0, 0.0)]
    (pit,) = looked_at(monkeypatch, [(8.0, 1.0), (5.1, 1.0), (2.0, 1.1)], moved)
    assert pit.center == pytest.approx([8.0, 1.0, -0.3], abs=0.2)
    assert pit.normal @ [0.0, 0.0, -1.0] == pytest.approx(1.0)
    assert looked_at(monkeypatch, [(8.0, 1.0)] * 3, moved) == []
    assert looked_at(monkeypatch, [(8.0, 1.0)] * 3, [(0.0, 0.0, 0.0)] * 3) == []
    assert looked_at(monkeypatch, [(8.0, 1.0), (5.0, 1.0)], moved[:2]) == []
