"""The cells that a box passes through, asked at every tick of every motion; and whether all of them are known."""

import numba
import numpy as np

from primitives.arrays import Bools, Floats


@numba.njit(cache=True, error_model="numpy")
def sweep(
    swept: Bools,
    origin: Floats,
    cell: float,
    last: Floats,
    noted: tuple[float, float],
    pose: Floats,
    low: Floats,
    high: Floats,
) -> None:
    """Set `swept`, in place, where a cell's middle lies between two (3,) corners [mm] of a (4, 4) pose.

    `origin` (3,) is the middle of the first cell.  Nothing is done until the pose is so far [mm, of its matrix]
    from the (4, 4) `last`, which then becomes it.
    """
    step, turn = noted
    moved = False
    for i in range(3):
        for j in range(4):
            moved |= not abs(pose[i, j] - last[i, j]) < (step if j == 3 else turn)
    if not moved:
        return
    last[:] = pose
    _visit(swept, origin, cell, pose, low, high, True)


@numba.njit(cache=True, error_model="numpy")
def holds(swept: Bools, origin: Floats, cell: float, pose: Floats, low: Floats, high: Floats) -> bool:
    """Whether `swept` is set wherever a cell's middle lies between two (3,) corners [mm] of a (4, 4) pose."""
    return bool(_visit(swept, origin, cell, pose, low, high, False))


@numba.njit(cache=True, error_model="numpy")
def _visit(
    swept: Bools, origin: Floats, cell: float, pose: Floats, low: Floats, high: Floats, mark: bool
) -> bool:
    """Mark the cells whose middles lie in a box, or else tell whether all of them are marked."""
    first, end, at = np.empty(3, np.int64), np.empty(3, np.int64), np.empty(3)
    for i in range(3):
        middle, half = pose[i, 3], 0.0
        for j in range(3):
            middle += pose[i, j] * 0.5 * (low[j] + high[j])
            half += abs(pose[i, j]) * 0.5 * (high[j] - low[j])
        first[i] = max(0, int(np.ceil((middle - half - origin[i]) / cell)))
        end[i] = min(swept.shape[i], int(np.floor((middle + half - origin[i]) / cell)) + 1)
    for a in range(first[0], end[0]):
        at[0] = origin[0] + cell * a - pose[0, 3]
        for b in range(first[1], end[1]):
            at[1] = origin[1] + cell * b - pose[1, 3]
            for c in range(first[2], end[2]):
                at[2] = origin[2] + cell * c - pose[2, 3]
                inside = True
                for j in range(3):
                    along = at[0] * pose[0, j] + at[1] * pose[1, j] + at[2] * pose[2, j]
                    inside &= low[j] < along < high[j]
                if inside and mark:
                    swept[a, b, c] = True
                elif inside and not swept[a, b, c]:
                    return False
    return True
