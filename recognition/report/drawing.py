"""A solid as a small SVG: what is seen of its faces in bands of light, with its visible edges and outlines.

Seen from afar (parallel rays).  Which face is seen at each pixel, and how bright, comes from ray casts; each
patch of one face and one brightness becomes a polygon (`traced`).  Lines are exact: the boundary's edges, and on
curved faces where the normal is square to the view, found by linear interpolation in each triangle; each is kept
where a ray from the eye reaches it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.boundaries.curves import refined
from models.boundary import labeled_boundary
from models.brep import Brep
from models.solid import Solid
from primitives.arrays import Bools, Floats, Ints
from primitives.outlines import simplified, traced

COLORS = {
    "plane": "#8fb4d6",
    "cylinder": "#e6b04a",
    "cone": "#bd5233",
    "sphere": "#1f8a70",
    "torus": "#5f4b91",
    "freeform": "#d4d1c9",
}

_STUB = 3.0  # [px] a piece no longer is what `slack` lets through at the end of a hidden line


@dataclass(frozen=True)
class DrawingConfig:
    """How the drawing is made."""

    size: int = 200  # [px] sides of the square
    margin: int = 14  # [px]
    fine: int = 2  # rays for each pixel, along each side
    bands: int = 7  # of light
    azimuth: float = -0.9  # [rad] of the eye, from x
    elevation: float = 0.48  # [rad] of the eye
    slack: float = 0.008  # of the solid's size: how far behind what is seen a line may lie
    paper: str = "#f4f2ee"
    ink: str = "#20262c"


def drawing_svg(solid: Solid, config: DrawingConfig | None = None) -> str:
    """The SVG as text, of a solid in its own frame."""
    c = config or DrawingConfig()
    home = solid.placed(np.eye(4))
    brep, face_of = labeled_boundary(home)
    view = _View.of(home, c)
    fills = _fills(home, brep, face_of, view)
    lines = [line for run in _edges(brep) + _outlines(home, brep, face_of, view) for line in view.seen(run)]
    path = "".join(_path(line, closed=False) for line in lines)
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {10 * c.size} {10 * c.size}" '
        f'width="{c.size}" height="{c.size}" stroke-linejoin="round" stroke-linecap="round">'
        f'<rect width="{10 * c.size}" height="{10 * c.size}" rx="80" fill="{c.paper}"/>'
        f'<g stroke-width="9" fill-rule="evenodd">{fills}</g>'
        f'<path d="{path}" fill="none" stroke="{c.ink}" stroke-width="11"/></svg>\n'
    )


@dataclass(frozen=True, eq=False)
class _View:
    solid: Solid
    config: DrawingConfig
    frame: Floats  # (3, 3) rows: right, up, towards the eye
    center: Floats  # (3,) [mm]
    scale: float  # [px / mm]
    reach: float  # [mm] of the eye from the center

    @staticmethod
    def of(solid: Solid, c: DrawingConfig) -> _View:
        a, e = c.azimuth, c.elevation
        back = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
        right = np.array([-np.sin(a), np.cos(a), 0.0])
        frame = np.stack([right, np.cross(back, right), back])
        flat = solid.vertices @ frame.T
        low, high = flat.min(axis=0), flat.max(axis=0)
        scale = (c.size - 2 * c.margin) / float((high - low)[:2].max())
        reach = float(np.linalg.norm(high - low))
        return _View(solid, c, frame, (low + high) / 2 @ frame, scale, reach)

    def pixels(self, points: Floats) -> Floats:
        """(n, 2) of (n, 3) points."""
        flat = (points - self.center) @ self.frame[:2].T * self.scale
        pixels: Floats = flat * [1, -1] + self.config.size / 2
        return pixels

    def cast(self, pixels: Floats) -> tuple[Floats, Ints, Floats]:
        """What rays through (n, 2) pixels meet: depth towards the eye (n,), triangle (n,), normal (n, 3)."""
        flat = (pixels - self.config.size / 2) * [1, -1] / self.scale
        origins = self.center + flat @ self.frame[:2] + self.reach * self.frame[2]
        hits = self.solid.cast_rays(origins, np.broadcast_to(-self.frame[2], origins.shape).copy())
        return self.reach - hits.distance, hits.element, hits.normals

    def seen(self, run: Floats) -> list[Floats]:
        """The visible pieces of (n, 3) points along a line, as pixels."""
        at = self.pixels(run)
        steps = np.linalg.norm(np.diff(at, axis=0), axis=1)
        place = np.concatenate([[0.0], np.cumsum(steps)])
        if not place[-1] > 0.5:
            return []
        wanted = np.unique(np.concatenate([place, np.linspace(0, place[-1], int(np.ceil(place[-1])) + 1)]))
        points = np.stack([np.interp(wanted, place, run[:, k]) for k in range(3)], axis=1)
        depth, _, _ = self.cast(self.pixels(points))
        own = (points - self.center) @ self.frame[2]
        visible = ~(depth > own + self.config.slack * self.reach)
        pieces = [part for part in _runs(visible) if visible.all() or np.ptp(wanted[part]) > _STUB]
        return [simplified(self.pixels(points[part]), 0.15) for part in pieces]


def _fills(solid: Solid, brep: Brep, face_of: Ints, view: _View) -> str:
    c = view.config
    n = c.size * c.fine
    rows, columns = np.mgrid[0:n, 0:n]
    centers = (np.stack([columns, rows], axis=2).reshape(-1, 2) + 0.5) / c.fine
    _, triangle, normals = view.cast(centers)
    key = view.frame.T @ np.array([-0.35, 0.62, 0.70])
    light = 0.60 + 0.44 * np.clip(normals @ key, 0, 1)
    band = np.minimum((light - 0.60) / 0.44 * c.bands, c.bands - 1).astype(np.int64)
    label = np.where(triangle >= 0, face_of[triangle] * c.bands + band, -1).reshape(n, n)
    out = []
    for value in np.unique(label[label >= 0]).tolist():
        face, level = divmod(value, c.bands)
        color = _shaded(COLORS[brep.faces[face].kind], 0.60 + 0.44 * (level + 0.5) / c.bands)
        loops = [simplified(loop / c.fine, 0.55) for loop in traced(label == value)]
        path = "".join(_path(loop, closed=True) for loop in loops if len(loop) > 3)
        if path:
            out.append(f'<path d="{path}" fill="{color}" stroke="{color}"/>')
    return "".join(out)


def _edges(brep: Brep) -> list[Floats]:
    return [
        refined(edge) if len(edge.points) < 40 else edge.points
        for edge in brep.edges
        if edge.kind != "smooth"
    ]


def _outlines(solid: Solid, brep: Brep, face_of: Ints, view: _View) -> list[Floats]:
    """Runs of points where a curved face turns away from the eye."""
    out: list[Floats] = []
    vertices, triangles = solid.vertices, solid.triangles
    for face in brep.faces:
        if face.shape is None or face.kind == "plane":
            continue
        corners = triangles[face_of == face.id]
        facing = np.zeros(len(vertices))
        used = np.unique(corners)
        facing[used] = face.shape.normals(vertices[used]) @ view.frame[2]
        facing[np.abs(facing) < 1e-9] = 1e-9
        crossing = corners[np.abs(np.sign(facing[corners]).sum(axis=1)) < 3]
        out += _chained(vertices, facing, crossing)
    return out


def _chained(vertices: Floats, facing: Floats, triangles: Ints) -> list[Floats]:
    """Runs of the points on triangles' sides where `facing` (v,) changes sign."""
    links: dict[tuple[int, int], list[tuple[int, int]]] = {}
    for triangle in triangles.tolist():
        sides = [tuple(sorted(pair)) for pair in zip(triangle, triangle[1:] + triangle[:1], strict=True)]
        a, b = ((p, q) for p, q in sides if facing[p] * facing[q] < 0)
        links.setdefault(a, []).append(b)
        links.setdefault(b, []).append(a)
    runs = []
    starts = [s for s, others in links.items() if len(others) == 1] + list(links)
    for start in starts:
        run, at = [start], start
        while links[at]:
            following = links[at].pop()
            links[following].remove(at)
            run.append(following)
            at = following
        if len(run) > 1:
            p, q = np.array(run).T
            share = facing[p] / (facing[p] - facing[q])
            runs.append(vertices[p] + share[:, None] * (vertices[q] - vertices[p]))
    return runs


def _runs(visible: Bools) -> list[slice]:
    """Stretches of two visible points or more."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], visible, [False]]).astype(int)))
    return [slice(a, b) for a, b in edges.reshape(-1, 2).tolist() if b - a > 1]


def _path(points: Floats, closed: bool) -> str:
    """Path data in tenths of a pixel, each point relative to the one before."""
    tenths = np.rint(points * 10).astype(int)
    (x, y), steps = tenths[0], np.diff(tenths, axis=0)
    moves = "".join(f"{a:+d}{b:+d}" for a, b in steps.tolist() if a or b)
    return f"M{x} {y}l{moves}" + ("z" if closed else "") if moves else ""


def _shaded(color: str, light: float) -> str:
    rgb = (min(255, round(int(color[i : i + 2], 16) * light)) for i in (1, 3, 5))
    return "#" + "".join(f"{x:02x}" for x in rgb)
