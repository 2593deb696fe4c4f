"""The evaluator of tracks: how far a trace is from the object's edges, and contacts from its surface.

An edge that was tracked is compared with all edges of the object that are not smooth: every point of the trace
with the nearest of their points.  It is asked once the tracker has ended, and tells it nothing.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from models.boundaries.curves import refined
from models.boundary import boundary, labeled_boundary
from models.brep import Edge
from models.solid import Solid
from primitives.arrays import Floats, Ints
from primitives.evidence import Contacts
from primitives.pose import inverse, transform_points

NEAR = 0.1  # [mm] within which the share of points is told
FINE = 16  # parts that each chord of a circular edge is divided into
SPACING = 1.0  # [mm] at most between the points by which an edge counts as tracked,
LEAST = 2  # of which it has more
TOGETHER = 64  # points that are compared at once


def edge_truth(solid: Solid, *traces: Floats) -> dict[str, Any] | None:
    """How far (n, 3) points of traces are from the nearest edges, and which those are.

    An edge that is short is drawn by its ends alone: it was tracked where the way between points runs along it.
    """
    edges = [edge for edge in boundary(solid).edges if edge.kind != "smooth"]
    if not edges or not sum(map(len, traces)):
        return None
    in_part = [transform_points(inverse(solid.pose), trace) for trace in traces if len(trace)]
    distance, nearest = distance_to_edges(edges, np.concatenate(in_part))
    most = edges[int(np.bincount(nearest).argmax())]
    _, along = distance_to_edges(edges, np.concatenate([_filled(trace) for trace in in_part]))
    tracked = [edges[k] for k in np.unique(along) if np.count_nonzero(along == k) > LEAST]
    return {
        "rms_mm": float(np.sqrt(np.mean(distance**2))),
        "max_mm": float(distance.max()),
        "share_within_0_1_mm": float(np.mean(distance < NEAR)),
        "dihedral_deg": most.dihedral_deg,
        "edges": len(tracked),
        "length_mm": float(sum(edge.length for edge in tracked)),
    }


def _filled(trace: Floats) -> Floats:
    """A trace with points between its own, where those are far apart."""
    travel = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(trace, axis=0), axis=1)))
    at = np.linspace(0.0, travel[-1], int(np.ceil(travel[-1] / SPACING)) + 1)
    return np.stack([np.interp(at, travel, column) for column in trace.T], axis=1)


def surface_truth(solid: Solid, contacts: Contacts) -> dict[str, Any] | None:
    """How far contacts are from the exact surface, and their normals from its."""
    if not len(contacts):
        return None
    brep, of_triangle = labeled_boundary(solid)
    points = transform_points(inverse(solid.pose), contacts.points)
    found = solid.body.tree.nearest(points)
    distance = found.distance.copy()
    face = of_triangle[found.triangle]
    for k in np.unique(face):
        shape, mine = brep.faces[k].shape, face == k
        if shape is not None:
            distance[mine] = np.abs(shape.signed_distance(points[mine]))
    felt = contacts.has_normal
    cosine = np.sum(contacts.normals * solid.normals(contacts.points), axis=1)[felt]
    off = np.degrees(np.arccos(np.clip(cosine, -1.0, 1.0)))
    return {
        "rms_mm": float(np.sqrt(np.mean(distance**2))),
        "max_mm": float(distance.max()),
        "normal_rms_deg": float(np.sqrt(np.mean(off**2))) if len(off) else None,
        "shape": brep.faces[int(np.bincount(face).argmax())].kind,
    }


def distance_to_edges(edges: list[Edge], points: Floats) -> tuple[Floats, Ints]:
    """(n,) [mm] from (n, 3) points to the nearest edge, and which that is."""
    runs = [refined(edge, FINE) for edge in edges]
    start = np.concatenate([run[:-1] for run in runs])
    step = np.concatenate([np.diff(run, axis=0) for run in runs])
    owner = np.repeat(np.arange(len(runs)), [len(run) - 1 for run in runs])
    square = np.maximum(np.sum(step**2, axis=1), 1e-30)
    distance, nearest = np.empty(len(points)), np.empty(len(points), dtype=np.int64)
    for first in range(0, len(points), TOGETHER):
        away = points[first : first + TOGETHER, None] - start
        along = np.clip(np.einsum("nmk,mk->nm", away, step) / square, 0.0, 1.0)
        off = np.linalg.norm(away - along[:, :, None] * step, axis=2)
        at = off.argmin(axis=1)
        distance[first : first + TOGETHER] = off[np.arange(len(at)), at]
        nearest[first : first + TOGETHER] = owner[at]
    return distance, nearest
