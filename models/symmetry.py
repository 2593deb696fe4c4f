"""The proper rotations that carry a part onto itself, their Schoenflies name, and poses compared up to them.

Finite groups of rotations are C_n, D_n, T, O and I, told apart by their order and axes; a solid of revolution
has C_inf, with two equal ends D_inf, and a ball K.  Mirror planes are left out: no motion of a part uses them.
A pose `world_from_part @ rotation` is the same to the eye and the touch as `world_from_part`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from models.brep import Brep
from models.comparison.likeness import SameConfig, colored
from models.comparison.motions import motions
from models.comparison.outline import Outline, outline
from primitives.arrays import Floats, frozen
from primitives.pose import frame_along, inverse, pose, quaternion_wxyz, rotation_exp, rotation_log

_ALIKE = 1e-2  # [rad] between rotations that are one, and between axes that are one


@dataclass(frozen=True, eq=False)
class SymmetryGroup:
    """The rotations about the part's center that change nothing; `C1` is only the identity."""

    name: str  # C1, C2, ..., D2, ..., T, O, I, C_inf, D_inf or K
    rotations: Floats  # (k, 4, 4) part_from_part, the identity first; up to turns about a continuous axis
    center: Floats  # (3,) [mm] in the part frame
    axis: Floats | None  # (3,) unit: of revolution, or of the C_n or D_n, n > 2, in the part frame
    order: float  # how many rotations; inf for a continuous group

    @property
    def continuous(self) -> bool:
        """Whether any turn about the axis, or any turn at all, is one of the group."""
        return not np.isfinite(self.order)


@dataclass(frozen=True)
class PoseError:
    """How far a pose is from the nearest of those that are the same."""

    angle: float  # [rad]
    distance: float  # [mm] between the part's centers


def symmetry(brep: Brep, tolerance: float | SameConfig = SameConfig()) -> SymmetryGroup:  # noqa: B008
    """The group of a boundary, to within `tolerance` [mm] at every corner, edge and face."""
    config = tolerance if isinstance(tolerance, SameConfig) else SameConfig(tolerance=tolerance)
    whole = outline(brep)
    axes = _axes(whole)
    still = np.eye(3)[None]
    if len(axes) == 0 and _round(whole, None, config.tolerance):
        return _group("K", still, whole.center, None, np.inf)
    turns = _turns(whole, config)
    if len(axes) and _round(whole, axes[0], config.tolerance):
        flips = [r for r in turns if (r @ axes[0]) @ axes[0] < 0]
        name, flip = ("D_inf", flips[:1]) if flips else ("C_inf", [])
        half = [_half_turn(axes[0])[None]] if flip else []
        return _group(name, np.concatenate([still, *half]), whole.center, axes[0], np.inf)
    name, axis = _named(turns)
    return _group(name, turns, whole.center, axis, float(len(turns)))


def nearest_pose(group: SymmetryGroup, world_from_part: Floats, wanted: Floats) -> Floats:
    """(..., 4, 4) of all poses that are the same as one (4, 4), those turned least from the (..., 4, 4) wanted."""
    turns = wanted[..., :3, :3]
    if group.name == "K":
        at_center = pose(np.eye(3), group.center)
        turn = world_from_part[:3, :3].T @ turns
        return np.asarray(world_from_part @ at_center @ pose(turn) @ inverse(at_center))
    same = world_from_part @ group.rotations
    if group.continuous and group.axis is not None:
        same = same @ _about(group, _twist(same, wanted[..., None, :, :], group.axis))
    cosines = np.einsum("...sij,...ij->...s", same[..., :3, :3], turns)
    least = np.argmax(cosines, axis=-1)[..., None, None, None]
    same = np.broadcast_to(same, (*wanted.shape[:-2], *same.shape[-3:]))
    return np.asarray(np.take_along_axis(same, least, axis=-3)[..., 0, :, :])


def pose_error(group: SymmetryGroup, estimated: Floats, true: Floats) -> PoseError:
    """Least angle and distance of centers between two world_from_part poses, up to the group."""
    same = nearest_pose(group, estimated, true)
    apart = (same - true)[:3] @ np.append(group.center, 1.0)
    turn = rotation_log(same[:3, :3].T @ true[:3, :3])
    return PoseError(float(np.linalg.norm(turn)), float(np.linalg.norm(apart)))


def grouped(turns: Floats, center: Floats, axis: Floats | None, order: float) -> SymmetryGroup:
    """The group of (k, 3, 3) rotations, the identity first; of order inf: up to turns about an axis or any."""
    if np.isfinite(order):
        name, axis = _named(turns)
    else:
        name = "K" if axis is None else "D_inf" if len(turns) > 1 else "C_inf"
    return _group(name, turns, center, axis, order)


def _group(name: str, turns: Floats, center: Floats, axis: Floats | None, order: float) -> SymmetryGroup:
    rotations = pose(turns, center - turns @ center)
    return SymmetryGroup(name, frozen(rotations), center, None if axis is None else frozen(axis), order)


def _turns(whole: Outline, config: SameConfig) -> Floats:
    """(k, 3, 3) different rotations that carry the boundary onto itself, angles made exact fractions."""
    found = [np.eye(3)]
    for carried in motions(whole, whole, colored(whole, whole, config), config):
        turn = carried.b_from_a[:3, :3]
        if all(np.linalg.norm(turn - other) > _ALIKE for other in found):
            found.append(turn)
    return np.stack([_exact(turn, len(found)) for turn in found])


def _exact(turn: Floats, order: int) -> Floats:
    """The rotation with its angle the nearest multiple of a turn over a fold that the order allows."""
    vector = rotation_log(turn)
    angle = float(np.linalg.norm(vector))
    folds = [n for n in range(2, order + 1) if order % n == 0]
    steps = [2 * np.pi * round(angle * n / (2 * np.pi)) / n for n in folds]
    near = min(steps, key=lambda step: abs(step - angle), default=0.0)
    return rotation_exp(vector / angle * near) if angle > _ALIKE and abs(near - angle) < _ALIKE else turn


def _named(turns: Floats) -> tuple[str, Floats | None]:
    """Schoenflies name of (k, 3, 3) rotations, and the main axis if one stands out."""
    order = len(turns)
    if order == 1:
        return "C1", None
    vectors = rotation_log(turns[1:])
    axes = vectors / np.linalg.norm(vectors, axis=1, keepdims=True)
    fold = 1 + (np.abs(axes @ axes.T) > 1 - _ALIKE).sum(axis=1)
    most = int(fold.argmax())
    axis, n = axes[most] * np.sign(axes[most][np.abs(axes[most]).argmax()]), int(fold[most])
    if n == order:
        return f"C{n}", axis
    if order == 2 * n:
        return f"D{n}", axis if n > 2 else None
    return {12: "T", 24: "O", 60: "I"}.get(order, f"order {order}"), None


def _axes(whole: Outline) -> Floats:
    """(m, 3) directions that an axis of revolution would have to be along; none for concentric spheres."""
    offsets = np.concatenate([whole.anchor, whole.middle])
    far = np.linalg.norm(offsets, axis=1)
    lines = [whole.direction, whole.spin / max(whole.size, 1e-300), offsets[far > 1e-3 * whole.size]]
    every = np.concatenate(lines)
    length = np.linalg.norm(every, axis=1)
    every, length = every[length > 1e-9], length[length > 1e-9]
    return np.asarray(every / length[:, None])


def _round(whole: Outline, axis: Floats | None, t: float) -> bool:
    """Whether any turn about an axis through the center, or about any, changes nothing."""
    kinds = {face.kind for face in whole.brep.faces}
    if "freeform" in kinds or not whole.circle.all() or len(whole.vertices):
        return False
    if axis is None:
        return kinds == {"sphere"} and float(np.linalg.norm(whole.anchor, axis=1).max()) <= t
    points, reach = np.concatenate([whole.anchor, whole.middle]), np.linalg.norm(whole.spin, axis=1)
    planes = np.array([face.kind == "plane" for face in whole.brep.faces])
    points = points[~np.concatenate([planes, np.zeros(len(whole.middle), dtype=bool)])]
    off = np.linalg.norm(np.cross(points, axis), axis=1)
    tilt = np.linalg.norm(np.cross(whole.direction, axis), axis=1).max() * whole.size
    spin = np.linalg.norm(np.cross(whole.spin, axis), axis=1)
    slack = np.concatenate([whole.slack[~planes], np.ones(len(reach))])
    return bool((off <= t * slack).all() and tilt <= 10 * t and (spin <= t).all())


def _half_turn(axis: Floats) -> Floats:
    return rotation_exp(np.pi * frame_along(axis)[:, 0])


def _twist(part: Floats, wanted: Floats, axis: Floats) -> Floats:
    """(...) [rad] turns about `axis` of parts that bring them nearest to `wanted`: twist without swing."""
    q = quaternion_wxyz(np.swapaxes(part[..., :3, :3], -1, -2) @ wanted[..., :3, :3])
    return np.asarray(2 * np.arctan2(q[..., 1:] @ axis, q[..., 0]))


def _about(group: SymmetryGroup, angle: Floats) -> Floats:
    assert group.axis is not None
    turn = rotation_exp(angle[..., None] * group.axis)
    return pose(turn, group.center - turn @ group.center)
