"""What has been commanded and is not to be seen yet.

A stage obeys a twist `latency` seconds after it was told, and a frame is old by the time it is read.  Where the
array will be once everything that was said so far has been done is where the next command begins: controllers aim
from there, so that latency costs them nothing but what the object springs on them (Smith's predictor, for a
plant that integrates).
"""

import numba
import numpy as np

from primitives.arrays import Floats
from primitives.pose import exp

_ROOM = 64  # twists, at first


class Pending:
    """The twists of the last `latency` seconds, in the sensor's frame."""

    def __init__(self, latency: float) -> None:
        self.latency = latency
        self._times, self._twists = np.empty(_ROOM), np.empty((_ROOM, 6))
        self._first = self._end = 0  # of those that may still be on their way

    def say(self, time: float, twist: Floats) -> None:
        """A (6,) twist [mm/s, rad/s] was commanded at `time` [s] and holds until the next."""
        if self._end == len(self._times):
            self._make_room()
        self._times[self._end], self._twists[self._end] = time, twist
        self._end += 1
        while self._end > self._first + 1 and self._times[self._first + 1] <= time - self.latency:
            self._first += 1

    def motion(self, time: float) -> Floats:
        """(4, 4) sensor_now_from_sensor_soon: what is still to be done at `time` [s].

        Twists are added up, as they may be over times in which the pad hardly turns.
        """
        return exp(_still(self._times, self._twists, self._first, self._end, time, self.latency))

    def _make_room(self) -> None:
        kept = slice(self._first, self._end)
        size = max(_ROOM, 2 * (self._end - self._first))
        times, twists = np.empty(size), np.empty((size, 6))
        self._first, self._end = 0, self._end - self._first
        times[: self._end], twists[: self._end] = self._times[kept], self._twists[kept]
        self._times, self._twists = times, twists


@numba.njit(cache=True, error_model="numpy")
def _still(times: Floats, twists: Floats, first: int, end: int, time: float, latency: float) -> Floats:
    """(6,) the twists from `first` to `end` [mm, rad], each times what is left of it at `time`."""
    out = np.zeros(6)
    ended = time
    for k in range(end - 1, first - 1, -1):
        began = max(times[k], time - latency)
        if ended > began:
            for i in range(6):
                out[i] += twists[k, i] * (ended - began)
            ended = began
    return out
