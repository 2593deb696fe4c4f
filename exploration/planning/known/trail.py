"""The way that the stage has come: where it went once it can go back."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from primitives.arrays import Floats

_EVERY = 5.0  # [mm] between the poses that are kept
_TURN = 0.15  # of the attitude's matrix, the same


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

    def back(self) -> Iterator[list[Floats]]:
        """The stops of ways back from the end, each twice as long as the one before; the last to the start."""
        count, most = 1, len(self._poses)
        while most > 1:
            yield self._poses[: -min(count, most) - 1 : -1]
            if count >= most:
                return
            count *= 2


def _moved(before: Floats, now: Floats) -> bool:
    step = np.abs(now - before)
    return bool(step[:3, 3].max() > _EVERY or step[:3, :3].max() > _TURN)
