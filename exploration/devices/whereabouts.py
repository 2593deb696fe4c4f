"""Where a stage's axes were at the times of its reports, between them, and a moment later."""

from collections import deque

import numpy as np

from primitives.arrays import Floats

_REMEMBERED = 256  # reports
_BASE = 0.007  # [s] between reports that tell a speed, at least
_AHEAD = 0.02  # [s] at most that it is taken to last


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
        """(n,) [mm, rad] at a time: straight between the reports round it, or straight on from the last.

        Going on for t [s] with the speed of the last reports is off by a t^2 / 2 at the acceleration a: 0.01 mm
        in 5 ms at 1000 mm/s^2, less than waiting for the next report costs the loop that servoes on it.
        """
        reports = list(self._reports)
        after = reports[-1]
        if moment >= after[0]:
            before = next((r for r in reversed(reports) if after[0] - r[0] >= _BASE), after)
            if not np.isfinite(before[0]) or before is after:
                return after[1]
            speed = (after[1] - before[1]) / (after[0] - before[0])
            return np.asarray(after[1] + speed * min(moment - after[0], _AHEAD))
        for before in reversed(reports):
            if before[0] <= moment:
                if not np.isfinite(before[0]):
                    return after[1]
                share = (moment - before[0]) / (after[0] - before[0])
                return np.asarray(before[1] + share * (after[1] - before[1]))
            after = before
        return after[1]

    def surely_at(self, moment: float, braking: float) -> Floats:
        """(n,) [mm, rad] as far as it had surely come, though it may brake by `braking` [mm/s^2].

        The speed v is a mean over the reports' interval T, so it may have fallen by a T / 2 when the last came:
        a way of (v - a T / 2) t - a t^2 / 2 in t [s] is sure (our derivation).
        """
        reports = list(self._reports)
        moments, last = [when for when, _ in reports], reports[-1][1]
        t, ahead = moment - moments[-1], self.at(moment)
        base = next((moments[-1] - m for m in reversed(moments) if moments[-1] - m >= _BASE), 0.0)
        speed = float(np.linalg.norm(ahead - last)) / max(min(t, _AHEAD), 1e-9)
        if t <= 0.0 or speed <= 0.0:
            return ahead
        t = min(t, _AHEAD, max(0.0, speed / braking - 0.5 * base))
        sure = (speed - 0.5 * braking * base) * t - 0.5 * braking * t * t
        return np.asarray(last + (ahead - last) * max(0.0, sure) / float(np.linalg.norm(ahead - last)))
