"""The way that the stage has come: where it went once it can go back.

What it was in contact with is left off by a little on the way back.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from primitives.arrays import Floats
from primitives.pose import apart

_EVERY = 5.0  # [mm] between the poses that are kept
_LATE = 60  # poses, among which it is that a fault was backed off to
_PER_TURN = 60.0  # [mm] that count as much as two attitudes by which they differ by one
_ALIKE = 1.0 + 2.0 * float(np.cos(0.1))  # of two attitudes as near


class Trail:
    """(4, 4) poses of the stage's flange, which a change of arrays does not move."""

    def __init__(self) -> None:
        self._poses: list[Floats] = []

    def leaves(self, pose: Floats) -> bool:
        """Whether a pose of the flange is so far from the last one that it is to be noted."""
        return not self._poses or _moved(self._poses[-1], pose)

    def pass_through(self, pose: Floats) -> None:
        """Note the pose of the flange, unless it hardly moved."""
        if self.leaves(pose):
            self._poses.append(pose.copy())

    def rejoin(self, pose: Floats) -> None:
        """Forget what lies past a pose: the guard that backs off from a fault is not followed on its way."""
        late = self._poses[-_LATE:]
        if late:
            off = [apart(kept, pose) + _PER_TURN * (3.0 - _alike(kept, pose)) for kept in late]
            del self._poses[len(self._poses) - len(late) + int(np.argmin(off)) + 1 :]

    @property
    def start(self) -> Floats | None:
        """Where the way began; None where there was none."""
        return self._poses[0] if self._poses else None

    @property
    def length(self) -> int:
        """Number of poses that are kept."""
        return len(self._poses)

    def since(self, length: int) -> list[Floats]:
        """The stops of the way back from the end to where the trail had a length."""
        return self._poses[length:][::-1]

    def back(self) -> Iterator[list[Floats]]:
        """The stops of ways back from the end, each twice as long as the one before; the last to the start."""
        count, most = 1, len(self._poses)
        while most > 1:
            yield self._poses[: -min(count, most) - 1 : -1]
            if count >= most:
                return
            count *= 2


def _moved(before: Floats, now: Floats) -> bool:
    return _alike(before, now) < _ALIKE or apart(before, now) > _EVERY


def _alike(a: Floats, b: Floats) -> float:
    """1 + 2 cos of the turn between two attitudes."""
    return float(np.vdot(a[:3, :3], b[:3, :3]))
