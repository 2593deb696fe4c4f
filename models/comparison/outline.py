"""What of a boundary moves with it and what does not, as arrays: points, directions and sizes to compare.

The center is the centroid of all edges by length (of the anchors of faces where there are no edges), so it moves
with the part and hardly with the facets.  Edges are sampled at equal shares of their length; a rim has no first
point, so circles are kept as center, normal and radius.

Where surfaces meet at an angle a, an error t of either moves their edge by t / sin a, and where they are tangent
with curvatures k1 and k2, by sqrt(2 t / |k1 - k2|) (our derivation): a fillet of 5 mm that is 0.05 mm off ends
0.7 mm elsewhere.  Such edges, and what ends on them, are given that much play, and hardly count for the center.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from models.boundaries.curves import refined
from models.brep import Brep, Edge
from models.comparison.incidence import Incidence, incidence
from primitives.arrays import Bools, Floats, Ints, frozen

SAMPLES = 9  # points along an edge
_FIRM = 0.3  # sine of the angle between faces above which their edge counts in full
_KINDS = ("plane", "cylinder", "cone", "sphere", "torus", "freeform")


@dataclass(frozen=True, eq=False)
class Outline:
    """A boundary's measures about its center; f faces, e edges, v vertices."""

    brep: Brep
    graph: Incidence
    center: Floats  # (3,) [mm] in the part frame; all points below count from it
    size: float  # [mm] root mean square distance of edges from the center
    kind: Ints  # (f,) index of the shape's name
    anchor: Floats  # (f, 3) [mm]
    direction: Floats  # (f, 3) unit; zero for spheres and freeform faces
    signed: Bools  # (f,) whether the direction's sign means something
    sizes: Floats  # (f, 2) radii [mm], or a cone's angle [rad] as mm at the face
    slack: Floats  # (f,) by how much sizes are known worse than points: small arcs and caps
    middle: Floats  # (e, 3) [mm] centroid of each edge
    samples: Floats  # (e, SAMPLES, 3) [mm]
    length: Floats  # (e,) [mm]
    dihedral: Floats  # (e,) [deg]
    circle: Bools  # (e,) whether the edge is a whole circle
    slant: Floats  # (e,) sine of the angle between the faces' normals
    bend: Floats  # (e,) [mm] 1 / |k1 - k2| across it
    spin: Floats  # (e, 3) radius times normal of circles [mm], either sign; zero for others
    vertices: Floats  # (v, 3) [mm]

    @property
    def bare(self) -> Ints:
        """Faces without edges."""
        return np.array([f.id for f in self.brep.faces if not f.loops], dtype=np.int64)


def outline(brep: Brep) -> Outline:
    """The measures of a boundary."""
    curves = [refined(edge) for edge in brep.edges]
    middles = np.reshape([_centroid(points) for points in curves], (-1, 3))
    samples = np.reshape([_sampled(points) for points in curves], (-1, SAMPLES, 3))
    length = np.array([edge.length for edge in brep.edges])
    circles = [_circle(edge) for edge in brep.edges]
    anchors = np.reshape([_anchor(brep, f) for f in range(len(brep.faces))], (-1, 3))
    slant = np.abs(np.sin(np.deg2rad([edge.dihedral_deg for edge in brep.edges])))
    firmness = np.clip((slant / _FIRM) ** 2, 1e-3, 1.0)
    weights = length * firmness if len(length) else np.array([face.area for face in brep.faces])
    points = middles if len(length) else anchors
    center = weights @ points / weights.sum()
    spread = samples - center if len(length) else anchors[:, None] - center
    size = float(np.sqrt((weights[:, None] * (spread**2).sum(axis=2)).mean(axis=1).sum() / weights.sum()))
    size = size if size > 0 else float(np.sqrt(sum(face.area for face in brep.faces)))
    shapes = [face.shape for face in brep.faces]
    return Outline(
        brep,
        incidence(brep),
        frozen(center),
        size,
        frozen([_KINDS.index(face.kind) for face in brep.faces], np.int64),
        frozen(anchors - center),
        frozen(
            np.reshape(
                [np.zeros(3) if s is None or s.kind == "sphere" else s.direction for s in shapes], (-1, 3)
            )
        ),
        frozen([s is not None and s.kind in ("plane", "cone") for s in shapes], np.bool_),
        frozen(np.reshape([_sizes(brep, f) for f in range(len(shapes))], (-1, 2))),
        frozen([_slack(brep, f) for f in range(len(shapes))]),
        frozen(middles - center),
        frozen(samples - center),
        frozen(length),
        frozen([edge.dihedral_deg for edge in brep.edges]),
        frozen([c is not None for c in circles], np.bool_),
        frozen(slant),
        frozen(_bends(brep)),
        frozen(np.reshape([np.zeros(3) if c is None else c for c in circles], (-1, 3))),
        frozen(brep.vertices.reshape(-1, 3) - center),
    )


def mirrored(whole: Outline) -> Outline:
    """The same measures of the object's image through its center."""
    return replace(
        whole,
        anchor=-whole.anchor,
        direction=-whole.direction,
        middle=-whole.middle,
        samples=-whole.samples,
        spin=-whole.spin,
        vertices=-whole.vertices,
    )


def _centroid(points: Floats) -> Floats:
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    if not steps.sum() > 0:
        return np.asarray(points.mean(axis=0))
    middle: Floats = steps @ (points[1:] + points[:-1]) / 2 / steps.sum()
    return middle


def _sampled(points: Floats) -> Floats:
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    wanted = np.linspace(0, along[-1], SAMPLES)
    return np.stack([np.interp(wanted, along, points[:, k]) for k in range(3)], axis=1)


def _circle(edge: Edge) -> Floats | None:
    if edge.vertices is not None or edge.curve != "circle":
        return None
    spokes = edge.points - edge.points[0]
    facing = np.cross(spokes[:-1], spokes[1:]).sum(axis=0)
    spin: Floats = edge.length / (2 * np.pi) * facing / np.linalg.norm(facing)
    return spin


def _bends(brep: Brep) -> Floats:
    """(e,) [mm] radius of the difference between the faces' greater curvatures."""
    curvature = np.array([_curvature(brep, f) for f in range(len(brep.faces))])
    pairs = np.array([edge.faces for edge in brep.edges], dtype=np.int64).reshape(-1, 2)
    return np.asarray(1 / np.maximum(np.abs(curvature[pairs[:, 0]] - curvature[pairs[:, 1]]), 1e-3))


def _curvature(brep: Brep, f: int) -> float:
    """[1/mm] the greater principal curvature of a face, signed by its side; zero for planes and freeform."""
    face = brep.faces[f]
    if face.shape is None or face.kind == "plane":
        return 0.0
    radius = face.shape.sizes[-1]
    if face.kind == "cone":
        radius = max(float(np.mean(face.extent)), 1e-3) * np.tan(radius)
    return (1.0 if face.convex else -1.0) / float(radius)


def _anchor(brep: Brep, f: int) -> Floats:
    """The shape's anchor; for freeform faces, and cones whose apex is far, the mean of the rim."""
    face = brep.faces[f]
    if face.shape is not None and face.kind != "cone":
        return face.shape.anchor
    mine = [_centroid(brep.edges[e].points) for loop in face.loops for e in loop]
    if mine:
        return np.asarray(np.mean(mine, axis=0))
    return np.zeros(3) if face.shape is None else face.shape.anchor


def _sizes(brep: Brep, f: int) -> tuple[float, float]:
    """Radii; a cone's angle as the drop over the face's slant height, so that all are lengths."""
    face = brep.faces[f]
    if face.shape is None or face.kind == "plane":
        return (0.0, 0.0)
    if face.kind == "cone":
        return (face.shape.sizes[0] * abs(face.extent[1] - face.extent[0]), 0.0)
    first, *others = face.shape.sizes
    return (first, others[0] if others else 0.0)


def _slack(brep: Brep, f: int) -> float:
    """Error of a radius over error of points (our derivation): an arc of angle t rises r (1 - cos(t / 2))."""
    face = brep.faces[f]
    if face.shape is None or face.kind in ("plane", "cone"):
        return 1.0
    if face.kind == "sphere":
        rise = face.extent[1] / face.shape.sizes[0] if face.extent[1] > 0 else 2.0
    else:
        arc, radius = (
            (face.extent[1], face.shape.sizes[0])
            if face.kind == "cylinder"
            else (face.extent[0], face.shape.sizes[1])
        )
        rise = 1 - np.cos(min(arc / radius, np.pi) / 2) if arc > 0 else 1.0
    return float(1 / min(max(rise, 1e-3), 1.0))
