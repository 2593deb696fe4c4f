"""One named primitive of a model, which surfaces made its sides, and where a side that none made ends."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from models.csg import Csg, Cube, Cylinder, Prism
from primitives.arrays import Floats
from primitives.pose import pose, rotation_exp
from primitives.shapes import Plane

EXACT = 1e-6  # [rad] directions that were made equal agree within this
_PAST = 1.0  # [mm] at least, by which an open side reaches past the body
_Z, _AXES = 2, 3
_ROUND = 1.0  # [mm] open sides end at a multiple of this


@dataclass(frozen=True)
class Piece:
    """One primitive, and which surface made each of its sides."""

    kind: str  # "cube", "cylinder", "cone", "sphere", "torus", "prism", "polyhedron" or "mesh"
    operation: str  # "intersect" or "add", or "subtract" for a hole
    solid: Csg  # centered, axis along z
    world_from_piece: Floats  # (4, 4)
    body: int | None  # the round surface, if there is one
    ends: tuple[
        tuple[int | None, int | None], ...
    ]  # per axis (three, or z alone) the surfaces below and above
    why: str = ""  # it is there, where no cells asked for it: what was felt did, once the body stood

    @property
    def surfaces(self) -> tuple[int, ...]:
        """All that made it."""
        sides = [s for pair in self.ends for s in pair if s is not None]
        return tuple(sides if self.body is None else [self.body, *sides])

    @property
    def placed(self) -> Csg:
        """In the world."""
        return self.solid.placed(self.world_from_piece)

    def size(self, axis: int) -> float:
        """[mm] along one of its axes; TypeError where it is neither a box nor a bar along z."""
        if isinstance(self.solid, Cube):
            return self.solid.size[axis]
        if isinstance(self.solid, Cylinder | Prism) and axis == _Z:
            return self.solid.height
        raise TypeError(f"a {self.kind} is not measured along an axis")

    def longer(self, axis: int, above: bool, by: float) -> Piece:
        """Grown by so many mm at one end, where no surface ends it any more; TypeError as for `size`."""
        size = self.size(axis) + by
        if isinstance(self.solid, Cube):
            x, y, z = (size if k == axis else own for k, own in enumerate(self.solid.size))
            solid: Csg = replace(self.solid, size=(x, y, z))
        else:
            assert isinstance(self.solid, Cylinder | Prism)
            solid = replace(self.solid, height=size)
        shift = np.zeros(3)
        shift[axis] = 0.5 * by if above else -0.5 * by
        row = axis if len(self.ends) == _AXES else 0
        ends = tuple(
            pair if k != row else ((pair[0], None) if above else (None, pair[1]))
            for k, pair in enumerate(self.ends)
        )
        return replace(
            self, solid=solid, world_from_piece=self.world_from_piece @ pose(translation=shift), ends=ends
        )


def ended_with(piece: Piece, points: Floats) -> Piece:
    """A box or a bar along z whose open sides end with the last of (n, 3) points; of another kind, itself."""
    if not isinstance(piece.solid, Cube | Cylinder | Prism):
        return piece
    own = (points - piece.world_from_piece[:3, 3]) @ piece.world_from_piece[:3, :3]
    rows = list(enumerate(piece.ends)) if piece.kind == "cube" else [(_Z, piece.ends[-1])]
    for axis, pair in rows:
        past = 0.5 * piece.size(axis) - np.array([-own[:, axis].min(), own[:, axis].max()])
        for above, end in enumerate(pair):
            if end is None and 0.0 < past[above] < piece.size(axis):
                piece = piece.longer(axis, bool(above), -float(past[above]))
    return piece


def tree_of(named: Sequence[Piece]) -> Csg:
    """The pieces one after another, each added, taken away or kept to."""
    tree = named[0].placed
    for piece in named[1:]:
        tree = _OPERATIONS[piece.operation](tree, piece.placed)
    return tree


_OPERATIONS: dict[str, Callable[[Csg, Csg], Csg]] = {
    "add": lambda tree, piece: tree | piece,
    "subtract": lambda tree, piece: tree - piece,
    "intersect": lambda tree, piece: tree & piece,
}


def _crossed(origin: Floats, axis: Floats, end: Plane) -> float:
    """[mm] along an axis through a point, at which it crosses a plane."""
    return float((end.origin - origin) @ end.normal) / float(axis @ end.normal)


def span(origin: Floats, axis: Floats, ends: Sequence[Plane | None], corners: Floats) -> tuple[float, float]:
    """Where a piece begins and ends along an axis through a point; open ends are past the corners, rounded."""
    along = (corners - origin) @ axis
    low, high = (_crossed(origin, axis, e) if e is not None else None for e in ends)
    if low is None and high is None:
        middle = 0.5 * float(along.min() + along.max())
        half = 0.5 * _round_up(float(np.ptp(along)) + 2 * _PAST)
        return middle - half, middle + half
    if high is None and low is not None:
        return low, low + _round_up(float(along.max()) - low + _PAST)
    if low is None and high is not None:
        return high - _round_up(high - float(along.min()) + _PAST), high
    assert low is not None
    assert high is not None
    return low, high


def _round_up(length: float) -> float:
    return float(np.ceil(length / _ROUND) * _ROUND)


def upright(axis: Floats) -> Floats:
    """The least (3, 3) rotation that takes z to the axis."""
    across = np.cross([0.0, 0.0, 1.0], axis)
    sine = float(np.linalg.norm(across))
    if sine < 1e-12:
        return np.eye(3) if axis[2] > 0 else rotation_exp([np.pi, 0.0, 0.0])
    return rotation_exp(across / sine * np.arctan2(sine, axis[2]))


def along(origin: Floats, axis: Floats, low: float, high: float) -> Floats:
    """(4, 4) pose of what stands along an axis from `low` to `high` [mm], its middle at the origin."""
    return pose(upright(axis), origin + 0.5 * (low + high) * axis)
