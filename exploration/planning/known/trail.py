"""The way that the stage has come: where it went once it can go back."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from primitives.arrays import Floats
from primitives.pose import apart

_EVERY = 5.0  # [mm] between the poses that are kept
_ALIKE = 1.0 + 2.0 * float(np.cos(0.1))  # of two attitudes as near


class Trail:
    """(4, 4) poses of the stage's flange, which a change of arrays does not move."""

    def __init__(self) -> None:
        self._poses: list[Floats] = []

    def pass_through(self, pose: Floats) -> None:
        """Note the pose of the flange, unless it hardly moved."""
        if not self._poses or _moved(self._poses[-1], pose):
            self._poses.append(pose.copy())

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
    alike = float(np.vdot(before[:3, :3], now[:3, :3]))  # 1 + 2 cos of the turn between them
    return alike < _ALIKE or apart(before, now) > _EVERY
