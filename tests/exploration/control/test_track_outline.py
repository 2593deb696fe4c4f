"""Turning at the corners of an outline."""

from types import SimpleNamespace

import numpy as np

from exploration.control import track_outline
from exploration.control.corners import Meeting
from exploration.control.track_edge import EdgeConfig
from primitives.pose import pose

NORTH = np.array([0.0, 1.0, 0.0])


def test_a_corner_that_is_hidden_from_one_place_is_looked_for_from_a_little_beyond(monkeypatch):
    places, seen_from = [], [10.0]

    class Guard:
        world_from_sensor = pose(np.eye(3), [10.0, 0.0, -0.5])

        def go_to(self, target):
            self.world_from_sensor = target

    def meeting(seen, last, config, lines=()):
        places.append(seen.world_from_sensor[0, 3])
        corner = Meeting(np.array([12.0, 1.0, -0.5]), -NORTH, NORTH, 1.6, 2.0, 0.0)
        return corner if places[-1] >= seen_from[0] else None

    monkeypatch.setattr(track_outline, "meeting", meeting)
    monkeypatch.setattr(track_outline, "sure_lines", lambda image, most: ())
    monkeypatch.setattr(
        track_outline,
        "dwell",
        lambda guard, frames: SimpleNamespace(image=None, world_from_sensor=guard.world_from_sensor),
    )
    last = SimpleNamespace(direction=np.array([1.0, 0.0]), ahead=np.inf, opens=np.inf)
    edge = SimpleNamespace(last=last, corner=None)
    for seen_from[0], looked in ((10.0, [10.0]), (12.0, [10.0, 10.0, 11.0, 11.0, 12.0])):
        guard = Guard()
        places.clear()
        met = track_outline._turned(guard, edge, EdgeConfig())
        assert met is not None
        assert places == looked
        assert np.allclose(guard.world_from_sensor[:3, 3], [12.0, 4.0, -0.5])
    guard, seen_from[0] = Guard(), np.inf
    assert track_outline._turned(guard, edge, EdgeConfig()) is None
    assert guard.world_from_sensor[0, 3] == 10.0  # where a bend is followed on from
