"""Which face meets which, drawn: faces are discs by area; lines are heavy where concave, dashed where smooth."""

from __future__ import annotations

from html import escape

import networkx as nx
import numpy as np

from primitives.arrays import Floats
from recognition.report.boundary_words import Json, neighbors, side

_SIZE = 400.0  # the drawing's side, for as many faces as fit
_FITTING = 32
_GAP = 3.0  # between discs
_MOST = 150  # faces; more would be a tangle


def graph_svg(summary: Json) -> str:
    """The adjacency graph as SVG; nothing for a boundary with too many faces."""
    faces = {int(face["id"]): face for face in summary["faces"]}
    if not 1 < len(faces) <= _MOST:
        return ""
    links = {
        (min(a, b), max(a, b)): kind for a, others in neighbors(summary).items() for b, kind in others.items()
    }
    side = _SIZE * max(1.0, np.sqrt(len(faces) / _FITTING))
    radius = _radii(faces)
    places = _places(faces, links, radius, side)
    order = ("convex", "smooth", "concave")
    lines = [
        f'<line class="{kind}" x1="{places[a][0]:.1f}" y1="{places[a][1]:.1f}" '
        f'x2="{places[b][0]:.1f}" y2="{places[b][1]:.1f}"/>'
        for (a, b), kind in sorted(links.items(), key=lambda item: order.index(item[1]))
    ]
    return (
        f'<svg class="graph" viewBox="0 0 {side:.0f} {side:.0f}" role="img" aria-label="Which face meets which">'
        f"{''.join(lines)}{''.join(_disc(faces[f], places[f], radius[f]) for f in faces)}</svg>"
    )


def _disc(face: Json, place: tuple[float, float], radius: float) -> str:
    shape, number = escape(str(face["shape"])), int(face["id"])
    what = escape(" ".join(filter(None, (f"face {number}:", shape, side(face)))))
    hollow = " hollow" if side(face) == "inside" else ""
    return (
        f'<g class="disc {shape}{hollow}" data-face="{number}" tabindex="0">'
        f'<title>{what}</title><circle cx="{place[0]:.1f}" cy="{place[1]:.1f}" r="{radius:.1f}" '
        f'style="fill: var(--{shape})"/>'
        f'<text x="{place[0]:.1f}" y="{place[1] + 4:.1f}">{number}</text></g>'
    )


def _radii(faces: dict[int, Json]) -> dict[int, float]:
    largest = max(face["area_mm2"] for face in faces.values())
    return {f: 11 + 9 * float(np.sqrt(face["area_mm2"] / largest)) for f, face in faces.items()}


def _places(
    faces: dict[int, Json], links: dict[tuple[int, int], str], radius: dict[int, float], size: float
) -> dict[int, tuple[float, float]]:
    """Kamada and Kawai's layout scaled to the drawing, then discs that overlap pushed apart."""
    graph = nx.Graph()
    graph.add_nodes_from(faces)
    graph.add_edges_from(links)
    pieces = [sorted(piece) for piece in nx.connected_components(graph)]
    graph.add_edges_from((pieces[0][0], piece[0]) for piece in pieces[1:])
    layout = nx.kamada_kawai_layout(graph)
    points = np.array([layout[f] for f in faces])
    points = points - (points.max(axis=0) + points.min(axis=0)) / 2
    spread = np.maximum(np.abs(points).max(axis=0), 1e-9)
    edge = max(radius.values()) + _GAP
    scaled = points / spread * (size / 2 - edge) + size / 2
    apart = _pushed_apart(scaled, np.array([radius[f] for f in faces]), edge, size - edge)
    return {f: (float(x), float(y)) for f, (x, y) in zip(faces, apart, strict=True)}


def _pushed_apart(points: Floats, radius: Floats, low: float, high: float) -> Floats:
    """(n, 2) points moved until no two discs overlap, as far as that goes in 300 rounds."""
    wanted = radius[:, None] + radius[None] + _GAP
    np.fill_diagonal(wanted, 0.0)
    out = points + 1e-3 * np.stack([np.cos(np.arange(len(points))), np.sin(np.arange(len(points)))], axis=1)
    for _ in range(300):
        away = out[:, None] - out[None]
        distance = np.maximum(np.linalg.norm(away, axis=2), 1e-9)
        short = np.maximum(wanted - distance, 0.0)
        if not short.any():
            break
        out = np.clip(out + 0.35 * (away / distance[..., None] * short[..., None]).sum(axis=1), low, high)
    return out
