"""Which face meets which, drawn: faces are discs by area; lines are heavy where concave, dashed where smooth."""

from __future__ import annotations

from html import escape

import networkx as nx
import numpy as np

from recognition.report.boundary_words import Json, neighbors, side

_SIZE = 400.0  # the drawing's side
_MOST = 150  # faces; more would be a tangle


def graph_svg(summary: Json) -> str:
    """The adjacency graph as SVG; nothing for a boundary with too many faces."""
    faces = {int(face["id"]): face for face in summary["faces"]}
    if not 1 < len(faces) <= _MOST:
        return ""
    links = {
        (min(a, b), max(a, b)): kind for a, others in neighbors(summary).items() for b, kind in others.items()
    }
    places, radius = _places(faces, links), _radii(faces)
    order = ("convex", "smooth", "concave")
    lines = [
        f'<line class="{kind}" x1="{places[a][0]:.1f}" y1="{places[a][1]:.1f}" '
        f'x2="{places[b][0]:.1f}" y2="{places[b][1]:.1f}"/>'
        for (a, b), kind in sorted(links.items(), key=lambda item: order.index(item[1]))
    ]
    return (
        f'<svg class="graph" viewBox="0 0 {_SIZE:.0f} {_SIZE:.0f}" role="img" aria-label="Which face meets which">'
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
    most = 20.0 if len(faces) <= 40 else 13.0
    least = 10.0 if len(faces) <= 40 else 7.0
    return {
        f: least + (most - least) * float(np.sqrt(face["area_mm2"] / largest)) for f, face in faces.items()
    }


def _places(faces: dict[int, Json], links: dict[tuple[int, int], str]) -> dict[int, tuple[float, float]]:
    """Kamada and Kawai's layout, each connected piece first spread on a circle, scaled to the drawing."""
    graph = nx.Graph()
    graph.add_nodes_from(faces)
    graph.add_edges_from(links)
    pieces = [sorted(piece) for piece in nx.connected_components(graph)]
    graph.add_edges_from((pieces[0][0], piece[0]) for piece in pieces[1:])
    layout = nx.kamada_kawai_layout(graph)
    points = np.array([layout[f] for f in faces])
    points = points - (points.max(axis=0) + points.min(axis=0)) / 2
    spread = np.maximum(np.abs(points).max(axis=0), 1e-9)
    scaled = points / spread * (_SIZE / 2 - 26) + _SIZE / 2
    return {f: (float(x), float(y)) for f, (x, y) in zip(faces, scaled, strict=True)}
