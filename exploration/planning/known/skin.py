"""What the skin shows in passing, every few mm of whatever the array does in contact.

Places that it leaves free, holes too narrow for a taxel to be free over, and images of the flat faces it lies on.
"""

from __future__ import annotations

from dataclasses import dataclass

from exploration.control.feel import feel
from exploration.control.free_cells import free_cells
from exploration.control.procedures.approach import touched
from exploration.devices.guard import Observation
from exploration.planning.known.felt_free import FeltFree
from exploration.planning.known.mosaic import Mosaic
from exploration.planning.known.seen_pits import SeenPits
from exploration.planning.known.told import Told
from primitives import pose as se3
from primitives.arrays import Floats


@dataclass(frozen=True)
class SkinConfig:
    """How often it is looked at."""

    every: float = 3.0  # [mm] between looks


class Skin:
    """Grows with every look; what lies on what is `told` to stand beside the object makes no picture of it."""

    def __init__(self, told: Told | None = None, config: SkinConfig = SkinConfig()) -> None:
        self.config, self._told = config, told
        self.free, self.pits, self.mosaic = FeltFree(), SeenPits(), Mosaic()
        self._last: Floats | None = None  # (4, 4) where it was looked at last

    def look(self, seen: Observation) -> None:
        """Take in what an observation shows, if anything touches and the array has gone on since the last."""
        here = seen.world_from_sensor
        if self._last is not None and se3.apart(here, self._last) < self.config.every:
            return
        felt = feel(seen.image) if touched(seen.image) else None
        if felt:
            self._last = here
            self.free.add(free_cells(seen, felt))
            self.pits.look(seen)
            self.mosaic.look(seen, None if self._told is None else self._told.beside)

    def dwell(self, seen: Observation) -> None:
        """Picture what a pad shows that lies still: pressed in full, its frames averaged.

        In passing it is looked at when it first touches, when a place shows hardly more than noise.
        """
        if feel(seen.image):
            self.mosaic.look(seen, None if self._told is None else self._told.beside)
