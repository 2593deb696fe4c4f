"""An outline that something ends is followed the other way too, and is one outline in the end."""

from dataclasses import dataclass, field

import numpy as np

from exploration.control.track_outline import TrackedOutline
from exploration.devices.guard import Collision
from primitives.evidence import EdgeTrace
from primitives.pose import pose
from recognition.tracking.both_ways import followed_both_ways

X = np.array([1.0, 0.0, 0.0])


@dataclass
class Stage:
    """A guard that goes where it is sent."""

    world_from_sensor: np.ndarray = field(default_factory=lambda: pose(np.diag([1.0, -1.0, -1.0])))
    observers: tuple = ()
    places: list = field(default_factory=list)

    def go_to(self, target):
        self.world_from_sensor = target
        self.places.append(target[:3, 3])
        for told in self.observers:
            told(self)


def outline(*runs, ended="blocked"):
    traces = []
    for points in runs:
        points = np.asarray(points, dtype=float)
        along = np.diff(points, axis=0)[[0] * len(points)]
        along = along / np.linalg.norm(along, axis=1, keepdims=True)
        up = np.tile([0.0, 0.0, 1.0], (len(points), 1))
        traces.append(EdgeTrace(points, along, up, np.full(len(points), 0.01), False, 0, 0))
    empty = np.empty((0, 3))
    return TrackedOutline(tuple(traces), empty, ended, 10.0, (1.0,), (1.0,), (None,) * len(traces))


def along_x(first, last):
    return [[x, 0.0, 0.0] for x in np.arange(first, last, np.sign(last - first))]


def test_a_blocked_outline_is_one_with_what_was_followed_the_other_way():
    stage, ways = Stage(), []

    def follow(along):
        ways.append(along)
        if along @ X > 0:
            for x in (0.0, 6.0, 12.0):
                stage.go_to(pose(np.diag([1.0, -1.0, -1.0]), [x, 0.0, 0.0]))
            return outline(along_x(0, 12))
        assert np.allclose(stage.world_from_sensor[:3, 3], 0.0)
        return outline(along_x(1, -20), [[-20.0, y, 0.0] for y in range(5)])

    found = followed_both_ways(stage, X, follow)
    assert np.allclose(ways, [X, -X])
    over = [place for place in stage.places if place[2] > 2.9]
    assert [place[0] for place in over] == [12.0, 12.0, 6.0, 0.0]  # back over the face as it came
    across, straight = found.traces
    assert np.allclose(across.points[:, 1], [4, 3, 2, 1, 0])
    assert np.allclose(across.tangents, [0.0, -1.0, 0.0])
    assert np.allclose(straight.points[:, 0], np.arange(-19, 12))
    assert np.allclose(straight.tangents, X)
    assert np.allclose(found.corners, [[-20.0, 0.0, 0.0]])
    assert (found.ended, found.travel, len(found.forces), len(found.profiles)) == ("blocked", 20.0, 2, 2)


def test_what_came_round_or_cannot_be_gone_back_over_is_left_as_it_is():
    assert (
        len(followed_both_ways(Stage(), X, lambda along: outline(along_x(0, 9), ended="closed")).traces) == 1
    )
    assert not followed_both_ways(Stage(), X, lambda along: outline(ended="lost"))

    def meets(along):
        if along @ X < 0:
            raise Collision("something stands there")
        return outline(along_x(0, 9))

    assert np.allclose(followed_both_ways(Stage(), X, meets).traces[0].points, along_x(0, 9))
