"""When frames were complete, from when they were heard.

An array sends at its own even rate; a port, a driver and a busy machine hand frames on late, never early, and two
together when they were held up.  So the true times lie on a straight line over the frame's number, and every
frame was heard on it or above it.  The slope is the median of the times that `_BASE` frames took, which a hold-up
or a lost frame does not move; the line lies as high as it can below the latest frames, where those that were not
held up lie (our derivation).  What every frame takes alike stays in it: that is the latency, which is measured
where it matters.
"""

from collections import deque

import numpy as np

_KEPT = 512  # frames that tell the slope
_BASE = 64  # frames from one to the other of two that tell it, and fewest at all
_LATEST = 160  # frames that the line is drawn under
_ANEW = 8  # frames after which the line is drawn again
_MISSED = 48  # frames in a row that are all late: one before them never came
_SOON, _FAR = 8, 20.0  # frames and periods: the same of many that were lost at once, while nobody listened
_LEAST = 0.01  # periods from one stamp to the next
_AWAY = 2.0  # [s] without a frame, after which nothing before tells of the next


class FrameTimes:
    """One array's; `period` [s] is what it is said to keep."""

    def __init__(self, period: float) -> None:
        self._period = period
        self._heard, self._numbers = np.empty(_KEPT), np.empty(_KEPT)
        self._forget()

    def _forget(self) -> None:
        self._count, self._number = 0, 0
        self._start, self._step = -np.inf, self._period
        self._above = deque([0.0] * _MISSED, _MISSED)  # [periods] that the last frames lie above the line
        self._last = -np.inf

    def stamp(self, heard: float, missing: int = 0, broken: bool = False) -> float:
        """[s] when a frame was complete that was `heard` then, after so many that the array says were lost.

        `broken`: there were bytes before it that are no frame, so that one may have been lost, however many.
        """
        if heard - self._last > _AWAY:
            self._forget()
        self._number += 1 + missing
        self._keep(heard)
        above = heard - self._line(self._number)
        if above < 0.0 or self._count < _ANEW or self._count % _ANEW == 0:
            self._draw()
        self._look_for_missed(above / self._step, broken)
        stamp = min(heard, self._line(self._number))
        self._last = max(stamp, self._last + _LEAST * self._period)
        return self._last

    def _line(self, number: float) -> float:
        return self._start + self._step * number

    def _keep(self, heard: float) -> None:
        self._heard[self._count % _KEPT], self._numbers[self._count % _KEPT] = heard, self._number
        self._count += 1

    def _draw(self) -> None:
        """The highest line of the slope that lies below the latest frames."""
        order = np.arange(max(0, self._count - _KEPT), self._count) % _KEPT
        numbers, heard = self._numbers[order], self._heard[order]
        if len(order) > 2 * _BASE:
            passed = (heard[_BASE:] - heard[:-_BASE]) / (numbers[_BASE:] - numbers[:-_BASE])
            self._step = float(np.clip(np.median(passed), 0.5 * self._period, 2.0 * self._period))
        self._start = float((heard[-_LATEST:] - self._step * numbers[-_LATEST:]).min())

    def _look_for_missed(self, above: float, broken: bool) -> None:
        """An array that does not count its frames loses one in silence, and all that follow seem late."""
        if self._count <= 2 * _BASE + _ANEW:  # the slope is not known yet
            return
        self._above.append(above)
        if above < 0.5:  # the least of the last is no whole frame
            return
        last = 1 if broken else _SOON if self._many_lost() else _MISSED
        missed = round(min(list(self._above)[-last:]))
        if missed > 0:
            latest = [(self._count - 1 - k) % _KEPT for k in range(last)]
            self._numbers[latest] += missed
            self._number += missed
            self._above.extend([0.0] * _MISSED)

    def _many_lost(self) -> bool:
        """Whether the last frames are far too late, and yet come one by one as the array sends them."""
        first, last = (self._heard[(self._count - k) % _KEPT] for k in (_SOON, 1))
        live = last - first > 0.8 * (_SOON - 1) * self._step
        return bool(live and min(list(self._above)[-_SOON:]) > _FAR)
