"""What is still open: faces that are not fully touched, and edges that were not traced.

The faces found so far, each a half-space of a convex body, predict a boundary; where a predicted point has not
been touched, exploration is not closed.  As every new face cuts the prediction, it shrinks onto the object.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import KDTree

from exploration.planning.known.felt_free import FeltFree
from exploration.planning.known.touched import Touched
from primitives.arrays import Bools, Floats, Ints
from primitives.evidence import NOT_FELT, EdgeTrace
from primitives.fit import Fit
from primitives.half_spaces import HalfSpaces
from primitives.patch_graph import Face
from primitives.shapes import Plane, Shape
from primitives.shared_error import with_shared_error
from primitives.surface_sigma import distance_sigma


@dataclass(frozen=True)
class FrontierConfig:
    """How finely the prediction is looked at."""

    spacing: float = 4.0  # [mm] between predicted points
    rim: float = 2.0  # [mm] a boundary point this near another face's surface is moved onto their edge
    traced: float = 3.0  # [mm] an edge point this near a trace is traced
    end: float = 3.0  # [mm] of an edge next to a third face that is not asked for
    few_curved: int = 12  # contacts, below which the kind of a curved face is not settled
    certain: float = 0.1  # [mm] standard deviation of the surface that is certain enough
    certain_edge: float = 0.08  # [mm] the same of an edge within its face
    about_as_bad: float = 0.5  # of the greatest deviation, from which a place serves as well as the worst
    grazing: float = 0.05  # sine of the angle at which faces that are nearly tangent are taken to meet
    least_edge: float = 4.0  # [mm] of open edge worth a touch


@dataclass(frozen=True)
class Predicted:
    """Points of the boundary that the faces so far imply."""

    points: Floats  # (n, 3) [mm]
    normals: Floats  # (n, 3) outward
    face: Ints  # (n,) face ids

    def on(self, faces: Sequence[int]) -> Predicted:
        """Those of some faces."""
        keep = np.isin(self.face, faces)
        return Predicted(self.points[keep], self.normals[keep], self.face[keep])


@dataclass(frozen=True)
class OpenEdge:
    """A run of an edge between two faces that was not traced yet."""

    point: Floats  # (3,) [mm] in the middle of the run
    tangent: Floats  # (3,)
    outward: Floats  # (3,) in the first face's tangent plane, away from its material
    faces: tuple[int, int]  # the flatter first
    length: float  # [mm] of the whole run, roughly


class Frontier:
    """The prediction of one moment."""

    def __init__(self, faces: Sequence[Face], box: Floats, config: FrontierConfig = FrontierConfig()) -> None:
        self.faces = [face for face in faces if isinstance(face.fit, Fit)]
        self.config = config
        fits = [face.fit for face in self.faces if isinstance(face.fit, Fit)]
        shapes = [_outward(fit) for fit in fits]
        self.index = {face.id: k for k, face in enumerate(self.faces)}
        self.body = HalfSpaces.of(shapes, [fit.convex or fit.kind == "plane" for fit in fits])
        self.box = box.reshape(2, 3)
        found = self.body.sample_boundary(self.box, config.spacing)
        ids = np.array([face.id for face in self.faces], dtype=np.int64)
        self.given = {face.id for face in self.faces if (face.contacts.touch == NOT_FELT).all()}
        owner = ids[found.face] if len(ids) else found.face
        asked = ~np.isin(owner, list(self.given))
        self.predicted = Predicted(found.points[asked], found.normals[asked], owner[asked])

    def untouched(self, touched: Touched, within: float) -> Predicted:
        """The predicted points with nothing touched nearby."""
        return self._those(~touched.covers(self.predicted.points, within))

    def contradicted(self, free: FeltFree) -> Predicted:
        """The predicted points beside places where the skin felt free space inside the predicted body."""
        return self._those(free.opened(self.predicted.points, self.body))

    def doubtful(self) -> Predicted:
        """The predicted points where their face, or its edge there, is not known well; the best to press first.

        Those about as bad as the worst come first, and of them the one farthest inside its face: what is pressed
        on a rim tells of the rim.
        """
        excess = self._doubts()
        worst = excess.max(initial=0.0)
        bad = excess > self.config.about_as_bad * worst
        order = np.lexsort((-np.where(bad, self._inside(), excess), ~bad))
        return self._those(order[excess[order] > 1.0])

    def _inside(self) -> Floats:
        """(n,) [mm] from a predicted point to the nearest other surface that bounds the body."""
        p = self.predicted
        distances = self.body.distances(p.points)
        distances[np.arange(len(p.points)), [self.index[face] for face in p.face]] = -np.inf
        return np.asarray(-distances.max(axis=1, initial=-np.inf))

    def _those(self, rows: Bools | Ints) -> Predicted:
        p = self.predicted
        return Predicted(p.points[rows], p.normals[rows], p.face[rows])

    def _doubts(self) -> Floats:
        """(n,) deviation of the surface, or of the edge, at a predicted point, in units of what is certain enough.

        Where two surfaces of deviations a and b meet at an angle t, their edge deviates along the first by
        sqrt((a cos t)^2 + b^2) / sin t: a shallow edge is known worse than the faces beside it.  The doubt is
        that of the face which is known less.
        """
        p, config = self.predicted, self.config
        out: Floats = np.zeros(len(p.points))
        if not len(out):
            return out
        sigma = np.zeros((len(out), len(self.faces)))
        for k, face in enumerate(self.faces):
            assert isinstance(face.fit, Fit)
            sigma[:, k] = distance_sigma(with_shared_error(face.fit, face.weighed), p.points)
            if not isinstance(face.fit.shape, Plane) and len(face.contacts) < config.few_curved:
                out[p.face == face.id] = 2.0
        rows, own = np.arange(len(out)), np.array([self.index[face] for face in p.face])
        mine = sigma[rows, own]
        out = np.maximum(out, mine / config.certain)
        distances = self.body.distances(p.points)
        distances[rows, own] = -np.inf
        other = distances.argmax(axis=1)
        near = (distances[rows, other] > -config.spacing) & (mine >= sigma[rows, other])
        for k, shape in enumerate(self.body.shapes):
            at = near & (other == k)
            cosine = np.abs((shape.normals(p.points[at]) * p.normals[at]).sum(axis=1))
            sine = np.sqrt(np.maximum(1.0 - cosine**2, config.grazing**2))
            edge = np.hypot(mine[at], sigma[at, k] * cosine) / sine
            out[at] = np.maximum(out[at], edge / config.certain_edge)
        return out

    def open_edges(self, traces: Sequence[EdgeTrace]) -> list[OpenEdge]:
        """Every untraced run of an edge, the longest first."""
        near = np.concatenate([t.points for t in traces]) if traces else np.empty((0, 3))
        tree = KDTree(near) if len(near) else None
        out: list[OpenEdge] = []
        for i in range(len(self.faces)):
            for j in range(i + 1, len(self.faces)):
                if self.given & {self.faces[i].id, self.faces[j].id}:
                    continue
                points = self._edge_points(i, j)
                if len(points) and tree is not None:
                    points = points[tree.query(points)[0] > self.config.traced]
                out.extend(self._runs(i, j, points))
        return sorted(out, key=lambda edge: -edge.length)

    def _edge_points(self, i: int, j: int) -> Floats:
        """Points on both surfaces and inside all others, away from where a third one cuts them."""
        p = self.predicted
        own = np.isin(p.face, [self.faces[i].id, self.faces[j].id])
        points = p.points[own]
        reach = self.config.spacing
        points = points[(np.abs(self.body.distances(points)[:, [i, j]]) < reach).all(axis=1)]
        for _ in range(6):
            for k in (i, j):
                shape = self.body.shapes[k]
                points = points - shape.signed_distance(points)[:, None] * shape.normals(points)
        distances = self.body.distances(points)
        on = (np.abs(distances[:, [i, j]]) < 0.05).all(axis=1)
        others = np.delete(distances, [i, j], axis=1)
        on &= others.max(axis=1, initial=-np.inf) < -self.config.end
        on &= ((points > self.box[0]) & (points < self.box[1])).all(axis=1)
        points = points[on]
        a, b = self.body.shapes[i].normals(points), self.body.shapes[j].normals(points)
        return np.asarray(points[(a * b).sum(axis=1) < 0.95])

    def _runs(self, i: int, j: int, points: Floats) -> list[OpenEdge]:
        runs: list[OpenEdge] = []
        flat = {"plane": 0, "cylinder": 1, "cone": 1, "sphere": 2, "torus": 2}
        if flat[self.body.shapes[j].kind] < flat[self.body.shapes[i].kind]:
            i, j = j, i
        left = points
        while len(left):
            member = np.zeros(len(left), dtype=bool)
            member[0] = True
            for _ in range(200):
                grown = np.asarray(KDTree(left[member]).query(left)[0] < 2.5 * self.config.spacing)
                if grown.sum() == member.sum():
                    break
                member = grown
            run, left = left[member], left[~member]
            extent = float(np.ptp(run, axis=0).max())
            if extent < self.config.least_edge:
                continue
            middle = run[np.argmin(np.linalg.norm(run - run.mean(axis=0), axis=1))][None]
            first, second = self.body.shapes[i].normals(middle)[0], self.body.shapes[j].normals(middle)[0]
            tangent = np.cross(first, second)
            tangent = tangent / np.linalg.norm(tangent)
            outward = second - (second @ first) * first
            runs.append(
                OpenEdge(
                    middle[0],
                    tangent,
                    outward / np.linalg.norm(outward),
                    (self.faces[i].id, self.faces[j].id),
                    extent,
                )
            )
        return runs


def _outward(fit: Fit) -> Shape:
    """A plane's normal turned out of the material; other shapes as they are."""
    shape = fit.shape
    return Plane(shape.origin, -shape.normal) if isinstance(shape, Plane) and not fit.convex else shape
