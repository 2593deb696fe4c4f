"""Where a stage's axes were at the times of its reports, and between them."""

from collections import deque

import numpy as np

from primitives.arrays import Floats

_REMEMBERED = 256  # reports


class Whereabouts:
    """Joint positions over the last seconds; written by one thread, read by others."""

    def __init__(self, axes: int) -> None:
        self._reports: deque[tuple[float, Floats]] = deque([(-np.inf, np.zeros(axes))], maxlen=_REMEMBERED)

    @property
    def known(self) -> bool:
        """Whether any report has come."""
        return bool(np.isfinite(self.moment))

    @property
    def moment(self) -> float:
        """[s] for which the newest report holds."""
        return self._reports[-1][0]

    @property
    def joints(self) -> Floats:
        """(n,) [mm, rad] as the newest report says."""
        return self._reports[-1][1]

    def note(self, moment: float, joints: Floats) -> None:
        """A report."""
        self._reports.append((moment, joints))

    def at(self, moment: float) -> Floats:
        """(n,) [mm, rad] at a time, straight between the reports before and after it."""
        reports = list(self._reports)
        after = reports[-1]
        for before in reversed(reports):
            if before[0] <= moment:
                if after[0] <= moment or not np.isfinite(before[0]):
                    return after[1]
                share = (moment - before[0]) / (after[0] - before[0])
                return np.asarray(before[1] + share * (after[1] - before[1]))
            after = before
        return after[1]
