"""What has been commanded and is not to be seen yet.

A stage obeys a twist `latency` seconds after it was told, and a frame is old by the time it is read.  Where the
array will be once everything that was said so far has been done is where the next command begins: controllers aim
from there, so that latency costs them nothing but what the object springs on them (Smith's predictor, for a
plant that integrates).
"""

from collections import deque

import numpy as np

from primitives.arrays import Floats
from primitives.pose import exp


class Pending:
    """The twists of the last `latency` seconds, in the sensor's frame."""

    def __init__(self, latency: float) -> None:
        self.latency = latency
        self._said: deque[tuple[float, Floats]] = deque()

    def say(self, time: float, twist: Floats) -> None:
        """A (6,) twist [mm/s, rad/s] was commanded at `time` [s] and holds until the next."""
        self._said.append((time, np.asarray(twist, dtype=float)))
        while len(self._said) > 1 and self._said[1][0] <= time - self.latency:
            self._said.popleft()

    def motion(self, time: float) -> Floats:
        """(4, 4) sensor_now_from_sensor_soon: what is still to be done at `time` [s].

        Twists are added up, as they may be over times in which the pad hardly turns.
        """
        still = np.zeros(6)
        ended = time
        for began, twist in reversed(self._said):
            began = max(began, time - self.latency)
            if ended > began:
                still += twist * (ended - began)
                ended = began
        return exp(still)
