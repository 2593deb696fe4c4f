"""What a tracked edge does when a limit stops the pad before anything was followed."""

from types import SimpleNamespace

import pytest

from exploration.devices.guard import Collision, OverPress
from recognition.tracking import edge
from recognition.tracking.edge import EdgeTrack, track_edge

SEEN = SimpleNamespace()


def run_at(places):
    """A run that is found again in so many other places."""
    run = SimpleNamespace(pad=None, places=places, warnings=[], find=lambda: None)

    def elsewhere():
        run.places -= 1

    run.find_elsewhere = elsewhere
    return run


@pytest.mark.parametrize("fault", [OverPress, Collision])
@pytest.mark.parametrize("stage", ["reach_edge", "lie_over"])
def test_a_limit_passed_on_the_way_to_an_edge_sends_the_pad_to_another_place(monkeypatch, fault, stage):
    tried = []

    def stopped(*_):
        tried.append(stage)
        if len(tried) == 1:
            raise fault("46 N would be more than the limit")
        return SEEN

    monkeypatch.setattr(edge, "reach_edge", lambda pad: SEEN)
    monkeypatch.setattr(edge, "lie_over", lambda pad, seen: None)
    monkeypatch.setattr(edge, stage, stopped)
    monkeypatch.setattr(edge, "_followed", lambda *_: EdgeTrack(traces=("one",), ended="closed"))
    run = run_at(2)
    monkeypatch.setattr(EdgeTrack, "points", property(lambda self: self.traces))
    assert track_edge(run, 20.0, lambda note: None).ended == "closed"
    assert run.places == 1
