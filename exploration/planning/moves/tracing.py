"""Edges where known faces meet, followed: their outline is evidence of its own."""

from __future__ import annotations

import numpy as np

from exploration.control.track_edge import Tracked, follow_edge
from exploration.planning.open.frontier import OpenEdge
from exploration.planning.touching.findings import Attempts, Done, Findings, outward_normal
from exploration.planning.touching.pad import Pad
from exploration.planning.ways.transit import Support
from primitives import pose as se3


class Tracing:
    """Lays the pad beside an edge and follows it."""

    def __init__(self, pad: Pad, found: Findings, tried: Attempts) -> None:
        self.pad, self.found, self.tried = pad, found, tried

    def trace(self, edge: OpenEdge) -> Done:
        """Lie on the flatter face with the edge under the pad, and follow it both ways."""
        self.tried.note(edge.point)
        guard = self.pad.guard
        face = self.found.graph.face(edge.faces[0])
        normal = np.cross(edge.outward, edge.tangent)
        normal = normal * np.sign(normal @ outward_normal(face, edge.point))
        target = se3.pose(se3.frame_along(-normal, edge.tangent), edge.point - 2.0 * edge.outward)
        self.pad.travel(target, Support(edge.point, normal), standoff=6.0)
        if not self.pad.touch(target, standoff=6.0, overtravel=6.0):
            return None, "an edge was not where the faces meet"
        touch, cost, longest = guard.cost.touches, guard.cost, self.pad.config.longest
        cost.strokes += 1
        best = ahead = follow_edge(guard, edge.tangent, longest, touch, cost.strokes)
        if _unblocked(ahead).ended != "closed":
            cost.strokes += 1
            back = follow_edge(guard, -edge.tangent, longest, touch, cost.strokes)
            best = max((ahead, _unblocked(back)), key=lambda tracked: tracked.travel)
        self.pad.lie(np.empty((0, 3)))
        if best.trace is None:
            return edge.faces[0], "an edge could not be traced"
        self.found.traces.append((best.trace, edge.faces))
        graph, edge_id = self.found.graph.add_trace(best.trace, edge.faces[0])
        self.found.graph = graph.attach(edge_id, edge.faces[1])
        return edge.faces[0], "traced an edge"


def _unblocked(tracked: Tracked) -> Tracked:
    """What was tracked.  Raises the fault that ended it: what the pad ran into stands beside a known edge."""
    if tracked.fault is not None:
        raise tracked.fault
    return tracked
