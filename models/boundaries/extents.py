"""How far a face reaches on its surface: the two lengths, and the shape with its anchor put on the face.

===========  ============================================  ==============================================
shape        anchor and axis                               extent [mm]
===========  ============================================  ==============================================
plane        point nearest the face's centroid; normal     length and width of the least rectangle round it
cylinder     on the axis, middle of the face; axis         length along the axis, arc length round it
cone         apex; from the apex into the cone             distances from the apex where it begins and ends
sphere       center; pole of the face                      diameter of the rim circle (0 if whole), height
torus        center; axis                                  arc length round the tube, round the axis
freeform     none                                          length and width of the least rectangle round it
===========  ============================================  ==============================================
"""

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from primitives.arrays import Floats
from primitives.pose import frame_along
from primitives.shapes import Cone, Cylinder, Plane, Shape, Sphere, Torus

Extent = tuple[float, float]
_EQUAL = 0.01  # [1] of the area, by which rectangles round a felt face differ for nothing


def anchored(shape: Shape | None, corners: Floats, rim: Floats) -> tuple[Shape | None, Extent]:
    """The shape anchored on the face with (t, 3, 3) triangles and (m, 3) rim points, and the face's extent."""
    match shape:
        case Plane():
            points = rim if len(rim) else corners.reshape(-1, 3)
            return Plane(shape.project(_centroid(corners)[None])[0], shape.normal), rectangle(
                points, shape.normal
            )
        case Cylinder():
            return _cylinder(shape, corners, rim)
        case Cone():
            along = ((rim if len(rim) else corners.reshape(-1, 3)) - shape.apex) @ shape.axis
            least = min(float(((corners - shape.apex) @ shape.axis).min()), float(along.min()))
            begin, end = float(along.min()), float(along.max())
            return shape, (0.0 if least < 0.01 * begin or not len(rim) else begin, end)
        case Sphere():
            return shape, _cap(shape, corners, rim)
        case Torus():
            return shape, _tube(shape, corners)
    a, b, c = np.moveaxis(corners, 1, 0)
    facing = np.cross(b - a, c - a).sum(axis=0)
    return None, rectangle(corners.reshape(-1, 3), facing if facing.any() else np.array([0.0, 0.0, 1.0]))


def rectangle(points: Floats, normal: Floats) -> Extent:
    """Length and width of the least rectangle, by area, round (n, 3) points seen along `normal`.

    Of equal ones the longest: an acute triangle has three, among which noise would choose.
    """
    flat = (points - points.mean(axis=0)) @ frame_along(normal)[:, :2]
    try:
        outline = flat[ConvexHull(flat).vertices]
    except (QhullError, ValueError):
        return 0.0, 0.0
    sides = np.roll(outline, -1, axis=0) - outline
    sides = sides / np.linalg.norm(sides, axis=1, keepdims=True)
    lengths = _spans(outline, sides, sides)
    widths = _spans(outline, sides, np.stack([-sides[:, 1], sides[:, 0]], axis=1))
    areas = lengths * widths
    best = int(np.argmax(np.where(areas <= areas.min() * (1 + _EQUAL), np.maximum(lengths, widths), -np.inf)))
    pair = float(lengths[best]), float(widths[best])
    return max(pair), min(pair)


def _spans(outline: Floats, sides: Floats, ways: Floats) -> Floats:
    """(k,) how long a convex outline, counterclockwise with the unit `sides`, is along each of (k, 2) unit ways.

    Farthest along a way lies the corner at which the sides turn past the way's own left (Shamos 1978).
    """
    turn = np.unwrap(np.arctan2(sides[:, 1], sides[:, 0]))
    total = np.zeros(len(ways))
    for way in (ways, -ways):
        left = np.arctan2(way[:, 1], way[:, 0]) + np.pi / 2
        corner = np.searchsorted(turn, turn[0] + np.mod(left - turn[0], 2 * np.pi))
        near = (corner[:, None] + np.array([-1, 0, 1])) % len(outline)
        total += np.einsum("ijk,ik->ij", outline[near], way).max(axis=1)
    return total


def pole(shape: Sphere, corners: Floats) -> Floats:
    """(3,) unit direction from the center through the middle of a face; z for one that lies evenly all round."""
    a, b, c = np.moveaxis(corners, 1, 0)
    facing = np.cross(b - a, c - a).sum(axis=0) / 2
    if not _one_sided(facing, a, b, c):
        return np.array([0.0, 0.0, 1.0])
    length = float(np.linalg.norm(facing))
    outward = np.sign(((a + b + c) / 3 - shape.center) @ facing).sum()
    middle: Floats = facing / length * (1.0 if outward >= 0 else -1.0)
    return middle


def _one_sided(facing: Floats, a: Floats, b: Floats, c: Floats) -> bool:
    """Whether a face looks one way enough to have a pole, which rounding must not choose."""
    area = float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()) / 2
    return float(np.linalg.norm(facing)) > 0.05 * area


def _centroid(corners: Floats) -> Floats:
    a, b, c = np.moveaxis(corners, 1, 0)
    weight = np.linalg.norm(np.cross(b - a, c - a), axis=1)
    if not weight.any():  # a sliver, whose corners lie on a line
        weight = np.ones(len(corners))
    center: Floats = weight @ corners.mean(axis=1) / weight.sum()
    return center


def _cylinder(shape: Cylinder, corners: Floats, rim: Floats) -> tuple[Shape, Extent]:
    along = ((rim if len(rim) else corners.reshape(-1, 3)) - shape.origin) @ shape.axis
    low, high = float(along.min()), float(along.max())
    middle = Cylinder(shape.origin + shape.axis * (low + high) / 2, shape.axis, shape.radius)
    local = (corners - shape.origin) @ shape.frame
    angles = np.arctan2(local[..., 1], local[..., 0])
    return middle, (high - low, shape.radius * _covered(angles))


def _tube(shape: Torus, corners: Floats) -> Extent:
    local = (corners - shape.center) @ shape.frame
    across = np.hypot(local[..., 0], local[..., 1]) - shape.radius
    round_tube = _covered(np.arctan2(local[..., 2], across))
    return shape.minor_radius * round_tube, shape.radius * _covered(np.arctan2(local[..., 1], local[..., 0]))


def _covered(angles: Floats) -> float:
    """[rad] of the circle that (t, 3) triangles cover: 2 pi less the widest gap between them."""
    start = angles[:, :1]
    offset = np.angle(np.exp(1j * (angles - start)))
    low, high = (start[:, 0] + offset.min(axis=1)) % (2 * np.pi), np.ptp(offset, axis=1)
    order = np.argsort(low)
    begin, end = low[order], np.maximum.accumulate((low + high)[order])
    gaps = np.append(begin[1:], begin[0] + 2 * np.pi) - end
    widest = float(gaps.max())
    return 2 * np.pi - widest if widest > 1e-6 else 2 * np.pi


def _cap(shape: Sphere, corners: Floats, rim: Floats) -> Extent:
    a, b, c = np.moveaxis(corners - shape.center, 1, 0)
    if not len(rim) or not _one_sided(np.cross(b - a, c - a).sum(axis=0) / 2, a, b, c):
        return 0.0, 2 * shape.radius
    axis = pole(shape, corners)
    offsets = (rim - shape.center) @ axis
    top = shape.radius if _pierced(a, b, c, axis) else float(((corners - shape.center) @ axis).max())
    across = np.linalg.norm(rim - shape.center - offsets[:, None] * axis, axis=1)
    return 2 * float(across.max()), top - float(offsets.min())


def _pierced(a: Floats, b: Floats, c: Floats, axis: Floats) -> bool:
    """Whether the ray from the origin along `axis` meets one of the triangles."""
    volumes = np.stack([np.cross(p, q) @ axis for p, q in ((a, b), (b, c), (c, a))])
    same = (volumes >= -1e-9).all(axis=0) | (volumes <= 1e-9).all(axis=0)
    return bool((same & ((a + b + c) @ axis > 0)).any())
