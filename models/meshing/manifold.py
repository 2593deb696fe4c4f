"""Bodies from trees and meshes, and booleans of them: the only manifold3d import.

A manifold remembers, for every triangle of a boolean's result, which run of triangles it came from; each leaf of a
tree is such a run, so that every triangle of the result knows which exact surface it stands for.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Any

import manifold3d
import numpy as np
from numpy.typing import ArrayLike

from models.body import Body, LabeledSurface
from models.csg import Csg, Difference, Intersection, Leaf, Operation, Placed
from models.meshing.facets import facets
from models.meshing.flat_facets import Facets
from models.meshing.flush import below, common_frame, flush, leaf_poses
from primitives.arrays import Floats, Ints
from primitives.errors import PalpateError
from primitives.pose import inverse
from primitives.shapes import Shape

# Flat regions are made of these.
CrossSection, FillRule = manifold3d.CrossSection, manifold3d.FillRule
JoinType, OpType = manifold3d.JoinType, manifold3d.OpType


def body_of_tree(tree: Csg, tolerance: float) -> Body | None:
    """The body of a tree, its facets within `tolerance` [mm] of the exact surfaces; None where nothing is left."""
    result, surfaces, first = _made(tree, tolerance)
    return _labeled(result, surfaces, first) if _whole(result) else None


def body_again(tree: Csg, tolerance: float, vertices: Floats, triangles: Ints, labels: Ints) -> Body:
    """What `body_of_tree` made before, from its arrays; its manifold is made when it is asked for."""
    surfaces = tuple(
        surface
        for number, leaf in enumerate(tree.leaves())
        for surface in _surfaces_of(facets(leaf.primitive, tolerance), leaf, number)
    )
    return Body(lambda: _made(tree, tolerance)[0], vertices, triangles, labels, surfaces)


def body_of_mesh(vertices: ArrayLike, triangles: ArrayLike) -> Body:
    """The body inside a closed mesh of (v, 3) vertices [mm] and (t, 3) triangles, normals out."""
    mesh = manifold3d.Mesh64(
        vert_properties=np.array(vertices, dtype=np.float64, order="C"),
        tri_verts=np.array(triangles, dtype=np.uint64, order="C"),
    )
    return _unlabeled(_closed(manifold3d.Manifold(mesh)))


def body_of_field(field: Callable[[Floats], Floats], low: Floats, high: Floats, step: float) -> Body:
    """The body where a field, asked at (n, 3) places, is negative, between two (3,) corners [mm].

    It is asked on a grid of `step` [mm] or less, and taken for linear between its nodes along each axis.
    """
    step = min(step, 0.5 * float((high - low).min()))  # two cells along each axis, at least
    count = np.ceil((high - low) / step).astype(int) + 2
    axes = [low[k] + step * np.arange(count[k]) for k in range(3)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    heights: Any = field(nodes.reshape(-1, 3)).reshape(count).tolist()  # lists, for they are read one by one
    x0, y0, z0 = low.tolist()

    def inward(x: float, y: float, z: float) -> float:
        u, v, w = (x - x0) / step, (y - y0) / step, (z - z0) / step
        i, j, k = int(u), int(v), int(w)
        u, v, w = u - i, v - j, w - k
        sides = []
        for row in (heights[i], heights[i + 1]):
            near, far = row[j], row[j + 1]
            at_near, at_far = near[k] + w * (near[k + 1] - near[k]), far[k] + w * (far[k + 1] - far[k])
            sides.append(at_near + v * (at_far - at_near))
        return float(u * (sides[0] - sides[1]) - sides[0])

    return _unlabeled(_closed(manifold3d.Manifold.level_set(inward, [*low, *high], step)))


def body_of_labels(
    vertices: Floats, triangles: Ints, labels: Ints, surfaces: tuple[LabeledSurface, ...]
) -> Body:
    """As `body_of_mesh`, each triangle standing for the surface that its label (t,) counts; -1 for none."""
    result, identity = _manifold_of_labels(vertices, triangles, labels)
    return _labeled(_closed(result), surfaces, {identity: -1})


def body_within(
    body: Body, labels: Ints, surfaces: tuple[LabeledSurface, ...], keeper: Csg, tolerance: float
) -> Body | None:
    """What of a body with (t,) labels lies in `keeper`, whose surfaces follow `surfaces`; None for nothing."""
    mine, identity = _manifold_of_labels(body.vertices, body.triangles, labels)
    other, others, first = _made(keeper, tolerance)
    result = mine ^ other
    if not _whole(result):
        return None
    first = {original: start + len(surfaces) for original, start in first.items()} | {identity: -1}
    return _labeled(result, (*surfaces, *others), first)


def combined(a: Any, b: Any, operation: str) -> Body:
    """`union`, `intersection` or `difference` of two manifolds."""
    result = {"union": a.__add__, "intersection": a.__xor__, "difference": a.__sub__}[operation](b)
    return _unlabeled(result)


def composed(parts: Sequence[Any]) -> Body:
    """Of manifolds that do not meet."""
    return _unlabeled(manifold3d.Manifold.compose(list(parts)))


def _whole(result: Any) -> bool:
    return result.status() == manifold3d.Error.NoError and not result.is_empty()


def _closed(result: Any) -> Any:
    if not _whole(result):
        reason = str(result.status()).rsplit(".", 1)[-1]
        raise PalpateError(f"the mesh is not a closed solid ({reason}); repair it in a mesh editor first")
    return result


def _made(tree: Csg, tolerance: float) -> tuple[Any, tuple[LabeledSurface, ...], dict[int, int]]:
    """The manifold of a tree, all its leaves' surfaces, and which is the first of each leaf's run."""
    first: dict[int, int] = {}
    surfaces: list[LabeledSurface] = []
    parts: list[Any] = []
    frame = common_frame(tree)
    leaves, poses = list(tree.leaves()), list(leaf_poses(tree, inverse(frame)))
    meshes = [facets(leaf.primitive, tolerance) for leaf in leaves]
    for number, (leaf, mesh, vertices) in enumerate(zip(leaves, meshes, flush(meshes, poses), strict=True)):
        identity = int(manifold3d.Manifold.reserve_ids(1))
        parts.append(_manifold_of(mesh, vertices, identity))
        first[identity] = len(surfaces)
        surfaces += _surfaces_of(mesh, leaf, number)
    result = _evaluate(tree, iter(parts), inverse(frame))
    if not np.array_equal(frame, np.eye(4)):
        result = result.transform(frame[:3])
    return result, tuple(surfaces), first


def _manifold_of_labels(vertices: Floats, triangles: Ints, labels: Ints) -> tuple[Any, int]:
    """A manifold that remembers (t,) labels, one more than each, and the number that its runs carry."""
    identity = int(manifold3d.Manifold.reserve_ids(1))
    mesh = manifold3d.Mesh64(
        vert_properties=np.array(vertices, dtype=np.float64, order="C"),
        tri_verts=np.array(triangles, dtype=np.uint64, order="C"),
        run_index=np.array([0, triangles.size], dtype=np.uint64),
        run_original_id=np.array([identity], dtype=np.uint32),
        face_id=(np.asarray(labels) + 1).astype(np.uint64),
    )
    return manifold3d.Manifold(mesh), identity


def _labeled(result: Any, surfaces: tuple[LabeledSurface, ...], first: dict[int, int]) -> Body:
    """The body of a manifold whose runs tell which surface each triangle stands for."""
    mesh = result.to_mesh64()
    labels = np.empty(len(mesh.tri_verts), dtype=np.int64)
    for i, original in enumerate(mesh.run_original_id):
        run = slice(mesh.run_index[i] // 3, mesh.run_index[i + 1] // 3)
        labels[run] = np.asarray(mesh.face_id[run], dtype=np.int64) + first[int(original)]
    vertices, triangles = np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts)
    return Body(lambda: result, vertices, triangles, labels, surfaces)


def _manifold_of(mesh: Facets, vertices: Floats, identity: int) -> Any:
    made = manifold3d.Mesh64(
        vert_properties=np.array(vertices, order="C"),
        tri_verts=mesh.triangles.astype(np.uint64),
        run_index=np.array([0, mesh.triangles.size], dtype=np.uint64),
        run_original_id=np.array([identity], dtype=np.uint32),
        face_id=mesh.surface.astype(np.uint64),
    )
    return manifold3d.Manifold(made)


def _surfaces_of(mesh: Facets, leaf: Leaf, number: int) -> list[LabeledSurface]:
    moved = [shape and shape.transformed(leaf.part_from_primitive) for shape in mesh.surfaces]
    return [LabeledSurface(*_outward(shape, leaf.adds), number) for shape in moved]


def _outward(shape: Shape | None, adds: bool) -> tuple[Shape | None, bool]:
    if shape is not None and shape.kind == "plane":
        return (shape if adds else shape.with_parts(shape.anchor, -shape.direction, ())), True
    return shape, adds


def _evaluate(tree: Csg, parts: Iterator[Any], frame_from_tree: Floats) -> Any:
    """The manifold of a tree in the frame above, from those of its leaves, each in its own frame."""
    if isinstance(tree, Placed):
        inside, frame = below(tree, frame_from_tree)
        result = _evaluate(tree.child, parts, inside)
        return result if frame is None else result.transform(frame[:3])
    if not isinstance(tree, Operation):
        return next(parts)
    operands = [_evaluate(child, parts, frame_from_tree) for child in tree.children]
    operation = manifold3d.OpType.Add
    if isinstance(tree, Intersection):
        operation = manifold3d.OpType.Intersect
    elif isinstance(tree, Difference):
        operation = manifold3d.OpType.Subtract
    return manifold3d.Manifold.batch_boolean(operands, operation)


def _unlabeled(result: Any) -> Body:
    mesh = result.to_mesh64()
    vertices, triangles = np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts)
    return Body(lambda: result, vertices, triangles, np.full(len(triangles), -1), ())
