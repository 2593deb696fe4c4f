"""Colors of two boundaries that are equal for what may be the same in both, sizes and angles included.

A size is no number to hash: rounding parts equals that lie on either side of a boundary.  So the sizes of both
boundaries are laid side by side, each with its error, and those whose intervals overlap, or are linked by
others that do, share a cluster: equal objects never differ in color, unequal ones nearly always.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.comparison.incidence import Colors, combined, joined, refined
from models.comparison.outline import Outline
from primitives.arrays import Floats, Ints


@dataclass(frozen=True)
class SameConfig:
    """How near two boundaries must come to be the same."""

    tolerance: float = 0.1  # [mm] between corners, between edges, between radii: twice that of a usual mesh
    dihedral: float = 2.0  # [deg] between dihedral angles
    changing: float = 10.0  # [deg] between medians of angles that change along an edge, which sampling moves
    area: float = 0.03  # of the area, which facets blur
    gate: float = 0.05  # of the size: how far a first guess may misplace a point


def colored(a: Outline, b: Outline, config: SameConfig) -> tuple[Colors, Colors]:
    """Colors of both graphs' nodes, equal where sizes, angles and distances from the center agree too."""
    t, half = config.tolerance, a.graph.nodes
    first = np.concatenate([_measured(a), _measured(b)])
    reach = np.concatenate([_reach(a, t, config), _reach(b, t, config)])
    labels = np.concatenate([_labels(a), _labels(b)])
    columns = [clustered(first[:, k], reach[:, k]) for k in range(first.shape[1])]
    colors = refined(combined(labels, *columns), joined(a.graph, b.graph))
    return colors[:half], colors[half:]


def play(whole: Outline, t: float) -> tuple[Floats, Floats]:
    """(e,) and (v,) [mm] how far edges and corners may be off where all surfaces are within t."""
    own = np.minimum(t / np.maximum(whole.slant, 1e-9), np.sqrt(2 * t * whole.bend))
    edges, corners = np.maximum(own, t), np.full(len(whole.vertices), t)
    ended = [(edge.id, v) for edge in whole.brep.edges for v in edge.vertices or ()]
    if ended:
        edge, corner = np.array(ended).T
        np.maximum.at(corners, corner, edges[edge])
        np.maximum.at(edges, edge, corners[corner])
    return edges, corners


def clustered(values: Floats, reach: Floats) -> Ints:
    """(n,) cluster of each value; two are in one if their intervals, value +- reach, are linked by overlaps."""
    order = np.argsort(values - reach, kind="stable")
    high = np.maximum.accumulate((values + reach)[order])
    breaks = np.concatenate([[False], (values - reach)[order][1:] > high[:-1]])
    out = np.empty(len(values), dtype=np.int64)
    out[order] = np.cumsum(breaks)
    return out


def _measured(whole: Outline) -> Floats:
    """(n, 4) sizes and distances of the graph's nodes; zero where a node has none."""
    f, e, v = whole.graph.faces, whole.graph.edges, whole.graph.vertices
    out = np.zeros((whole.graph.nodes, 4))
    out[:f, :2] = whole.sizes
    out[whole.bare, 2] = np.linalg.norm(whole.anchor[whole.bare], axis=1)
    out[f : f + e, 0], out[f : f + e, 1] = whole.length, whole.dihedral
    out[f : f + e, 2] = np.linalg.norm(whole.middle, axis=1)
    out[f : f + e, 3] = np.linalg.norm(whole.spin, axis=1)
    out[f + e : f + e + v, 2] = np.linalg.norm(whole.vertices, axis=1)
    return out


def _reach(whole: Outline, t: float, config: SameConfig) -> Floats:
    f, e, v = whole.graph.faces, whole.graph.edges, whole.graph.vertices
    out = np.full((whole.graph.nodes, 4), t)
    out[:f, :2] = t * whole.slack[:, None]
    blur = np.where(whole.circle, 0.0, 0.005 * whole.length)
    loose, corners = play(whole, t)
    turned = np.rad2deg(np.arcsin(np.minimum(1.0, np.sqrt(2 * t / whole.bend))))
    changing = np.array([edge.curve == "other" for edge in whole.brep.edges], dtype=bool)
    out[f : f + e, 0] = np.pi * loose + blur
    out[f : f + e, 1] = np.where(changing, config.changing, config.dihedral) / 2
    out[f : f + e, 1] += np.where(whole.slant < 0.3, turned, 0.0)
    out[f : f + e, 2] = 1.5 * loose + blur
    out[f : f + e, 3] = loose
    out[f + e : f + e + v, 2] = 1.5 * corners
    return out


def _labels(whole: Outline) -> Colors:
    """What has no size and does not hang on a threshold: an edge may be called smooth by one maker only."""
    names = whole.graph.labels.copy()
    first = whole.graph.faces
    names[first : first + whole.graph.edges] = combined(
        np.array([edge.vertices is None for edge in whole.brep.edges], dtype=np.int64)
    )
    return names
