"""Surfaces of any solid -> primitives added and subtracted in order: cells, labels, the shortest list.

What touch must give: fits whose contacts lie on them, most contacts with outward normals, and at least one
contact on every face that the body shall have; one that nothing touched is closed by its neighbors or stays open.

Planes that no face has are added where cells would stay undecided, and where a list that leaves some of them wrong
may need them for its primitives to end at (`separators`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import HalfspaceIntersection

from models.csg import Polyhedron
from primitives.arrays import Bools, Floats
from primitives.errors import PalpateError
from primitives.shapes import Plane, Shape, Sphere, Torus
from recognition.assembly.arrangement import arrange
from recognition.assembly.closure import NotClosed, greatest_ball
from recognition.assembly.exchange import exchanged
from recognition.assembly.labels import solid_cells
from recognition.assembly.lists import Listed, Step, Target
from recognition.assembly.piece import Piece, ended_with
from recognition.assembly.pieces import pieces, ring_piece, round_piece, slab_cube
from recognition.assembly.prisms import prism
from recognition.assembly.search import shortest
from recognition.assembly.separators import felt_ends, one_sided, separators, stops
from recognition.assembly.vocabulary import Vocabulary, frame_of

_ROOM = 0.15  # of the contacts' extent, by which the sampled room reaches past them
_FARTHER = 0.2  # of the contacts' extent, at an open end
_VOTE = 6.0  # [nats] of a contact on the wrong side
_ENDS = 20.0  # [nats] left wrong or contradicted, from which stops are tried
_SPACE = 10.0  # [nats] per contact, of the whole volume wrongly filled

Touched = Sequence[tuple[Floats, Floats]]  # per surface (n, 3) points and (n, 3) outward normals


def concave_pieces(
    shapes: Sequence[Shape],
    touched: Touched,
    free: Floats | None = None,
    inferred: Sequence[bool] | None = None,
) -> tuple[Piece, ...] | NotClosed:
    """The list whose solid the contacts bound; `touched[i]` are those of surface i, which may be `inferred`."""
    points = np.concatenate([p for p, _ in touched])
    normals = np.concatenate([n for _, n in touched])
    if not len(points):
        return NotClosed("no contact has a normal, so nothing says which side is solid")
    low, high = points.min(axis=0), points.max(axis=0)
    room = np.stack([low, high]) + np.outer([-1, 1], [_ROOM * float(np.linalg.norm(high - low))] * 3)
    nowhere = np.empty((0, 3)) if free is None else free
    measured, apart = len(shapes), [*shapes, *separators(shapes)]
    whole = [*apart, *one_sided(apart, touched)]
    told = [False] * measured if inferred is None else list(inferred)
    heard = np.repeat(told, [len(p) for p, _ in touched])
    found = _explained(whole, points, normals, nowhere, room, told, heard)
    if (
        not isinstance(found, NotClosed)
        and found.listed.wrong + found.against > _ENDS
        and (more := [*stops(whole), *felt_ends(whole, touched, told)])
    ):
        again = _explained([*whole, *more], points, normals, nowhere, room, told, heard)
        if not isinstance(again, NotClosed) and again.cost < found.cost:
            found = again
    if isinstance(found, NotClosed):
        return found
    vocabulary = found.vocabulary
    corners = np.array(np.meshgrid(*np.stack([low, high]).T)).reshape(3, -1).T
    # What takes away reaches farther where it is open than what it is taken from: else a film is left there.
    farther = corners + _FARTHER * (corners - corners.mean(axis=0))
    made = [
        ended_with(_piece(step, vocabulary, points, room), points)
        if step.operation == "add"
        else _piece(step, vocabulary, farther, room)
        for step in found.listed.steps
    ]
    return tuple(replace(piece, ends=_felt(piece.ends, measured)) for piece in made)


@dataclass(frozen=True)
class _Explained:
    vocabulary: Vocabulary
    listed: Listed
    against: float  # [nats] of contacts that contradict the labels of their cells

    @property
    def cost(self) -> float:
        return self.listed.cost + self.against


def _explained(
    shapes: Sequence[Shape],
    points: Floats,
    normals: Floats,
    free: Floats,
    room: Floats,
    inferred: Sequence[bool],
    heard: Bools,
) -> _Explained | NotClosed:
    """The shortest list that the cells between the surfaces ask for, of which the first may be `inferred`.

    Those after them are no faces'.
    """
    nobody = np.zeros(len(shapes), dtype=bool)
    nobody[: len(inferred)] = inferred
    no_face = np.arange(len(shapes)) >= len(inferred)
    found = arrange(shapes, points, normals, free, room, inferred=nobody, heard=heard, stops=no_face)
    solid = solid_cells(found)
    if not solid.any():
        return NotClosed("the contacts' normals leave no cell solid")
    scale = _SPACE * len(points) / max(float(found.volume.sum()), 1e-9)
    against_solid = found.free_votes + found.swept_votes
    weight = _VOTE * (found.solid_votes + against_solid) + scale * found.volume
    target = Target(Vocabulary(shapes, found.outside), solid, weight)
    best = exchanged(shortest(target), target)
    if not best.steps:
        return NotClosed("no list of primitives explains the contacts")
    against = _VOTE * float(np.where(solid, against_solid, found.solid_votes).sum())
    return _Explained(target.vocabulary, best, against)


def _felt(
    ends: tuple[tuple[int | None, int | None], ...], measured: int
) -> tuple[tuple[int | None, int | None], ...]:
    """Ends at separators are no surface's."""

    def kept(k: int | None) -> int | None:
        return k if k is not None and k < measured else None

    return tuple((kept(a), kept(b)) for a, b in ends)


def contradicts_convex(shapes: Sequence[Shape], convex: Bools, touched: Touched, allowed: float) -> bool:
    """Whether contacts lie outside a surface that a convex body, less its holes, would be inside of."""
    for shape, inside in zip(shapes, convex, strict=True):
        for points, _ in touched:
            away = shape.signed_distance(points) * (1.0 if inside else -1.0)
            if len(away) and float(np.quantile(away, 0.9)) > allowed:
                return True
    return False


def _piece(step: Step, vocabulary: Vocabulary, corners: Floats, room: Floats) -> Piece:
    candidate, shapes = step.candidate, vocabulary.shapes
    if candidate.kind == "cube":
        assert candidate.frame is not None
        axes = vocabulary.frames[candidate.frame]
        frame = frame_of(vocabulary.directions, axes)
        turned = [
            k is not None and vocabulary.directions[k].axis @ c < 0
            for k, c in zip(axes, frame.T, strict=True)
        ]
        slabs = [(b, a) if t else (a, b) for (a, b), t in zip(candidate.slabs, turned, strict=True)]
        made = slab_cube(frame, slabs, shapes, corners)
    elif candidate.kind == "prism":
        made = _prism(candidate.sides, shapes, corners) or _polyhedron(candidate.sides, shapes, room)
    else:
        assert candidate.body is not None
        shape = shapes[candidate.body]
        if isinstance(shape, Sphere):
            made = pieces([shape], [True], np.zeros(1), corners)[0]
            made = replace(made, body=candidate.body)
        elif isinstance(shape, Torus):
            made = ring_piece(candidate.body, shape, [_side(shapes, *side) for side in candidate.sides])
        else:
            slab = candidate.slabs[0] if candidate.slabs else (None, None)
            made = round_piece(candidate.body, shape, slab, shapes, corners)
    return replace(made, operation=step.operation)


def _prism(sides: Sequence[tuple[int, bool]], shapes: Sequence[Shape], corners: Floats) -> Piece | None:
    """The sides as one prism, where all of them stand along or across one axis."""
    planes = {i: _side(shapes, i, outside) for i, outside in sides}
    found = prism(planes, [], corners)
    return found[0] if found is not None and len(found[1]) == len(planes) else None


def _side(shapes: Sequence[Shape], plane: int, outside: bool) -> Plane:
    """A plane that looks out of what lies on one side of it."""
    shape = shapes[plane]
    assert isinstance(shape, Plane)
    return Plane(shape.origin, -shape.normal) if outside else shape


def _polyhedron(sides: Sequence[tuple[int, bool]], shapes: Sequence[Shape], room: Floats) -> Piece:
    """The corners where the sides and the room's walls meet, each face in order round its normal."""
    rows = []
    for side in sides:
        plane = _side(shapes, *side)
        rows.append([*plane.normal, -float(plane.normal @ plane.origin)])
    low, high = room
    walls = np.concatenate([np.eye(3), -np.eye(3)])
    halves = np.array([*rows, *np.column_stack([walls, -np.concatenate([high, -low])])])
    return Piece("polyhedron", "add", _corners_of(halves), np.eye(4), None, ())


def _corners_of(halves: Floats) -> Polyhedron:
    inside = greatest_ball(halves, 1e-6)
    if inside is None:
        raise PalpateError("the sides of a prism hold no space")
    raw = np.asarray(HalfspaceIntersection(halves, inside).intersections)
    raw = raw[np.isfinite(raw).all(axis=1)]
    size = float(np.ptp(raw, axis=0).max())
    _, first = np.unique(np.round(raw / (1e-7 * size)), axis=0, return_index=True)
    corners = raw[np.sort(first)]
    faces = []
    for normal, offset in zip(halves[:, :3], halves[:, 3], strict=True):
        mine = np.flatnonzero(np.abs(corners @ normal + offset) < 1e-6 * size)
        if len(mine) < 3:
            continue
        arms = corners[mine] - corners[mine].mean(axis=0)
        first_arm = arms[np.argmax((arms**2).sum(axis=1))]
        turn = np.arctan2(np.cross(first_arm, arms) @ normal, arms @ first_arm)
        faces.append(tuple(int(k) for k in mine[np.argsort(turn)]))
    return Polyhedron(tuple(map(tuple, corners.tolist())), tuple(faces))
