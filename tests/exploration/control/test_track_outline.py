"""Turning at the corners of an outline."""

from types import SimpleNamespace

import numpy as np
import pytest

from exploration.control import track_outline
from exploration.control.corners import Meeting
from exploration.control.track_edge import EdgeConfig, Tracked
from primitives.arrays import frozen
from primitives.evidence import EdgeTrace
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


class Drawing:
    """A stage without a pad, on which each edge runs on along the corners (n, 2) that are told."""

    world_from_sensor = pose(np.eye(3))

    def __init__(self, corners):
        self.corners = [np.array([x, y, 0.0]) for x, y in corners]
        self.at, self.homes = 0, []

    def follow_edge(self, guard, heading, left, touch, stroke, press, config, homes):
        if self.at + 1 == len(self.corners):
            return Tracked(lambda: None, lambda: None, "length", 0.0)
        begin, end = self.corners[self.at : self.at + 2]
        self.at += 1
        length = float(np.linalg.norm(end - begin))
        way = (end - begin) / length
        points = begin + np.arange(4.0, length - 3.0)[:, None] * way
        home = next((k for k, home in enumerate(homes) if self._passes(home, begin, end)), None)
        along, up = (np.tile(axis, (len(points), 1)) for axis in (way, [0.0, 0.0, 1.0]))
        sigma = np.full(len(points), 0.02)
        trace = EdgeTrace(frozen(points), frozen(along), frozen(up), frozen(sigma), False, touch, stroke)
        last = SimpleNamespace(direction=way[:2])
        ended = "corner" if home is None else "closed"
        travel = length - 7.0 if length < 9.0 else length  # a short one is taken up past its corner
        return Tracked(lambda: trace, lambda: None, ended, travel, last=last, home=home)

    def turned(self, guard, edge, config):
        if self.at + 1 == len(self.corners):
            return None
        here, there = self.corners[self.at : self.at + 2]
        way = (there - here) / np.linalg.norm(there - here)
        pressed = here - [0.0, 0.0, 0.5]
        return Meeting(pressed, np.cross([0.0, 0.0, 1.0], way), way, 0.5 * np.pi, 0.0, 0.0)

    @staticmethod
    def _passes(home, begin, end):
        way = (end - begin) / np.linalg.norm(end - begin)
        on = float((home.point - begin) @ way)
        beside = np.linalg.norm(home.point - begin - on * way)
        return way @ home.tangent > 0.9 and beside < 1.0 and 0.0 < on + 3.0 < np.linalg.norm(end - begin)


SQUARE = [(0, 0), (60, 0), (60, 40), (0, 40)]


@pytest.mark.parametrize(
    ("corners", "lead", "edges"),
    [
        ([(30, 0), *SQUARE[1:], *SQUARE[:2]], 0, 5),  # begun in the middle of a side, by which it comes again
        ([(0, -70), (0, -30), *SQUARE, *SQUARE[:2]], 2, 4),  # a way that leads to the first corner
        ([(-50, -30), (30, -30), (30, 0), *SQUARE[1:], *SQUARE[:2]], 2, 5),  # or onto the middle of a side
    ],
)
def test_an_outline_closes_wherever_it_comes_back_to_itself(monkeypatch, corners, lead, edges):
    drawing = Drawing([*corners, *2 * SQUARE[2:], *2 * SQUARE])
    monkeypatch.setattr(track_outline, "follow_edge", drawing.follow_edge)
    monkeypatch.setattr(track_outline, "_turned", drawing.turned)
    outline = track_outline.follow_outline(drawing, np.array([1.0, 0.0, 0.0]), 2000.0, 0, 0)
    assert outline.ended == "closed"
    assert (outline.lead, len(outline.traces) - outline.lead) == (lead, edges)


def test_an_edge_of_which_hardly_anything_is_followed_is_drawn_from_corner_to_corner(monkeypatch):
    bar = [(0, 0), (60, 0), (60, 8), (0, 8)]
    drawing = Drawing([*bar, *bar, *bar])
    monkeypatch.setattr(track_outline, "follow_edge", drawing.follow_edge)
    monkeypatch.setattr(track_outline, "_turned", drawing.turned)
    outline = track_outline.follow_outline(drawing, np.array([1.0, 0.0, 0.0]), 2000.0, 0, 0)
    assert outline.ended == "closed"
    short = [trace.points[[0, -1]] for trace in outline.traces if abs(trace.tangents[0, 1]) > 0.5]
    assert np.allclose(short, [[(60, 0, 0), (60, 8, 0)], [(0, 8, 0), (0, 0, 0)]])
