"""How alike model and truth are where an array could have felt, and how much of that it did feel.

A place is reachable where a box, the array with its housing, covers it and is clear of the true object, in one of
24 attitudes: along the part's six directions, rolled by 0 and 90 degrees, and along twelve between two of them.
Of occupied cells (1 mm), the free tip positions are an erosion by the box, and the reachable cells the dilation of
these: a morphological opening of free space by the tool.  What no attitude reaches, U, is filled in both solids::

    IoU = (V + |U| - |T - M|) / (V + |U| + |(M - T) outside U|)

with V the volume of the truth T, and differences from M, the model, integrated exactly along columns of rays.
Our derivation.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy import ndimage
from scipy.spatial import KDTree

from models.solid import Solid
from primitives.arrays import Bools, Floats
from primitives.pose import inverse, transform_points

_CELL = 1.0  # [mm]
_PAST = 2e-3  # [mm] behind a crossing, from where the next one is looked for
_CROSSINGS = 60  # of one column, at most
_JITTER = np.array([0.31, 0.43])  # [cells] that keep columns off edges of round measure


@dataclass(frozen=True)
class Grid:
    """Cells round a solid, in its part's frame."""

    origin: Floats  # (3,) [mm] middle of the first cell
    shape: tuple[int, int, int]

    @staticmethod
    def round(solid: Solid, margin: float) -> Grid:
        """A grid that holds a solid and a margin [mm]."""
        low, high = np.asarray(solid.bounds).reshape(2, 3)
        cells = np.ceil((high - low + 2.0 * margin) / _CELL).astype(int)
        return Grid(low - margin, (int(cells[0]), int(cells[1]), int(cells[2])))

    def cell_of(self, points: Floats) -> tuple[Floats, ...]:
        """Indices of the cells that hold (n, 3) points, clipped to the grid."""
        at = np.clip(np.rint((points - self.origin) / _CELL).astype(int), 0, np.array(self.shape) - 1)
        return tuple(at.T)


@dataclass(frozen=True)
class Reach:
    """What an explorer could have come to."""

    iou: float  # where anything could be felt
    filled: float  # [mm^3] that no attitude reaches
    area: float  # share of the true surface that is reachable
    touched: float  # share of the reachable surface within `near` of what was felt


def reach(
    model: Solid | None,
    truth: Solid,
    tools: list[Floats],
    felt: Floats,
    near: float = 10.0,
    samples: int = 20_000,
) -> Reach:
    """Compare a model with the truth, both where they are placed, for tools (3,) [mm] of width, height, depth."""
    part = truth.placed(np.eye(4))
    grid = Grid.round(part, margin=max(float(max(tool[:2])) for tool in tools) + 2.0)
    solid = occupied(part, grid)
    open_to = np.zeros(grid.shape, dtype=bool)
    for turn, tool in product(attitudes(), tools):
        open_to |= _opened(solid, turn, tool)
    hidden = ~open_to & ~solid
    filled = float(hidden.sum()) * _CELL**3
    shared = 0.0
    if model is not None:
        home = model.placed(inverse(truth.pose) @ model.pose)
        missing = max(0.0, part.volume - part.shared_volume(home))
        surplus = _outside(home, part, grid, hidden)
        shared = (part.volume + filled - missing) / (part.volume + filled + surplus)
    points, normals = _surface(part, samples)
    out = points + 1.5 * _CELL * normals
    reachable = open_to[grid.cell_of(out)]
    touched = 0.0
    if len(felt):
        tree = KDTree(transform_points(inverse(truth.pose), felt))
        touched = float((tree.query(points[reachable])[0] < near).mean())
    return Reach(shared, filled, float(reachable.mean()), touched)


def attitudes() -> list[Floats]:
    """(3, 3) part_from_tool of 24 attitudes; the tool comes along its -z, from +z."""
    ways = [s * np.eye(3)[k] for k in range(3) for s in (1.0, -1.0)]
    between = [(a * np.eye(3)[i] + b * np.eye(3)[j]) / np.sqrt(2.0) for i, j in ((0, 1), (0, 2), (1, 2))
               for a in (1.0, -1.0) for b in (1.0, -1.0)]  # fmt: skip
    out = []
    for z in ways:
        x = np.eye(3)[(int(np.abs(z).argmax()) + 1) % 3]
        out += [np.column_stack([x, np.cross(z, x), z]), np.column_stack([np.cross(z, x), -x, z])]
    for z in between:
        x = np.eye(3)[int(np.abs(z).argmin())]
        out.append(np.column_stack([x, np.cross(z, x), z]))
    return out


def occupied(solid: Solid, grid: Grid) -> Bools:
    """Cells whose middle is inside."""
    inside = np.zeros(grid.shape, dtype=bool)
    heights = grid.origin[2] + _CELL * np.arange(grid.shape[2])
    for column, enter, leave in _runs(solid, grid, np.zeros(2)):
        i, j = divmod(column, grid.shape[1])
        inside[i, j, np.searchsorted(heights, enter) : np.searchsorted(heights, leave)] = True
    return inside


def _opened(solid: Bools, turn: Floats, tool: Floats) -> Bools:
    """Cells that a tool at one attitude covers somewhere without meeting the solid."""
    exact = np.allclose(np.abs(turn).max(axis=0), 1.0)
    shape = np.array(solid.shape)
    size = shape[np.abs(turn).argmax(axis=0)] if exact else np.full(3, int(np.linalg.norm(shape)) + 1)
    middle, own = (shape - 1) / 2.0, (size - 1) / 2.0
    turned = (
        ndimage.affine_transform(solid.astype(np.float32), turn, middle - turn @ own, tuple(size), order=1)
        > 0.5
    )
    wide, high = (max(1, int(v / _CELL)) for v in tool[:2])
    deep = int(tool[2] / _CELL)
    free = ~turned
    clear = _all_above(free, deep)
    tips = ndimage.minimum_filter(clear, (wide, high, 1), mode="constant", cval=True)
    columns = ndimage.maximum_filter(
        tips, (wide, high, 1), mode="constant", cval=False, origin=_mirrored(wide, high)
    )
    covered = _any_below(columns, deep)
    back = ndimage.affine_transform(
        covered.astype(np.float32), turn.T, own - turn.T @ middle, tuple(shape), order=0
    )
    return np.asarray(back > 0.5)


def _mirrored(*sizes: int) -> tuple[int, ...]:
    """Origins by which a filter of even size is the reflection of the one without."""
    return (*(-1 if size % 2 == 0 else 0 for size in sizes), 0)


def _all_above(free: Bools, deep: int) -> Bools:
    """Whether a cell and the `deep` cells above it are free; past the grid all is."""
    blocked = np.cumsum(~free[:, :, ::-1], axis=2, dtype=np.int32)[:, :, ::-1]
    beyond = np.zeros_like(blocked)
    beyond[:, :, : max(0, free.shape[2] - deep)] = blocked[:, :, deep:]
    return np.asarray(blocked == beyond)


def _any_below(tips: Bools, deep: int) -> Bools:
    """Whether a cell or one of the `deep` cells below it is marked."""
    marked = np.cumsum(tips, axis=2, dtype=np.int32)
    before = np.zeros_like(marked)
    before[:, :, deep:] = marked[:, :, : max(0, tips.shape[2] - deep)]
    return np.asarray(marked > before)


def _outside(model: Solid, truth: Solid, grid: Grid, hidden: Bools) -> float:
    """[mm^3] of the model that is neither the truth's nor hidden."""
    if model.volume - model.shared_volume(truth) < 1e-9:
        return 0.0
    extra = model.boolean(truth, "difference")
    inside = np.concatenate([np.zeros((*grid.shape[:2], 1)), np.cumsum(hidden, axis=2)], axis=2) * _CELL
    base = grid.origin[2] - _CELL / 2.0
    total = counted = 0.0
    steps = np.arange(grid.shape[2] + 1) * _CELL
    for column, enter, leave in _runs(extra, grid, _JITTER):
        i, j = divmod(column, grid.shape[1])
        total += leave - enter
        counted += float(np.diff(np.interp([enter - base, leave - base], steps, inside[i, j]))[0])
    return extra.volume * (1.0 - counted / total) if total else extra.volume


def _runs(solid: Solid, grid: Grid, jitter: Floats) -> list[tuple[int, float, float]]:
    """Column, and heights [mm] between which it is inside the solid, for every run of every column."""
    i, j = np.meshgrid(np.arange(grid.shape[0]), np.arange(grid.shape[1]), indexing="ij")
    at = grid.origin[:2] + _CELL * (np.column_stack([i.ravel(), j.ravel()]) + jitter)
    origins = np.column_stack([at, np.full(len(at), grid.origin[2] - _CELL)])
    crossed: list[list[float]] = [[] for _ in at]
    left = np.arange(len(at))
    for _ in range(_CROSSINGS):
        hits = solid.cast_rays(origins[left], np.tile([0.0, 0.0, 1.0], (len(left), 1)))
        met = hits.element >= 0
        left = left[met]
        if not len(left):
            break
        origins[left, 2] += hits.distance[met]
        for column, height in zip(left, origins[left, 2], strict=True):
            crossed[column].append(float(height))
        origins[left, 2] += _PAST
    return [
        (column, heights[k], heights[k + 1])
        for column, heights in enumerate(crossed)
        for k in range(0, len(heights) - 1, 2)
    ]


def _surface(solid: Solid, count: int) -> tuple[Floats, Floats]:
    """(n, 3) points even by area, and outward normals."""
    rng = np.random.default_rng(0)
    corners = solid.vertices[solid.triangles]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(across, axis=1)
    which = rng.choice(len(area), count, p=area / area.sum())
    a, b = np.sort(rng.random((2, count)), axis=0)
    weights = np.column_stack([a, b - a, 1.0 - b])
    return (weights[:, :, None] * corners[which]).sum(axis=1), across[which] / area[which, None]
