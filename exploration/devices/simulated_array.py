"""A simulated array: each frame is the gap at the stage's true pose, run through rubber and electronics.

What a real array cannot know (the surface, the true pose, the unit's gains) is private here: truth belongs to
the evaluator.
"""

import numpy as np

from exploration.devices.protocols import StageEvent
from exploration.devices.simulated_stage import SimulatedStage
from exploration.sensing.elastomer import pressure
from exploration.sensing.electronics import Memory, draw_unit, read_out
from exploration.sensing.frame import TaxelArray, TaxelFrame
from exploration.sensing.gap import Indentation, indentation
from exploration.sensing.housing import clearance
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Floats, frozen
from primitives.pose import inverse
from primitives.surface import Surface


class SimulatedArray:
    """An array on a simulated stage."""

    def __init__(
        self,
        surface: Surface,
        spec: SensorSpec,
        stage: SimulatedStage,
        flange_from_sensor: Floats,
        rng: np.random.Generator,
    ) -> None:
        self._surface, self._spec, self._stage, self._rng = surface, spec, stage, rng
        self._mount = frozen(flange_from_sensor)
        self._unit = draw_unit(spec, rng)
        self._memory = Memory.fresh(spec)
        self._index = 0
        self._due = 0
        self._last = 0.0
        self._touching = False
        self._clear_until: tuple[Floats, float] | None = None

    @property
    def array(self) -> TaxelArray:
        """Its layout."""
        return self._spec.array

    @property
    def spec(self) -> SensorSpec:
        """Its data sheet."""
        return self._spec

    @property
    def flange_from_sensor(self) -> Floats:
        """(4, 4) where it is mounted."""
        return self._mount

    @property
    def period(self) -> float:
        """Seconds from one frame to the next."""
        return self._spec.period

    def read(self) -> TaxelFrame:
        """The next frame, after the time that it takes."""
        stage, spec = self._stage, self._spec
        self._due = max(self._due + 1, int(np.ceil(stage._time / spec.period - 1e-6)))
        end = self._due * spec.period
        stage._advance(end)
        begin = end - spec.electronics.scan
        felt = self._feel(begin, end)
        self._watch(end, felt)
        counts, self._memory = read_out(
            pressure(felt, spec), spec, self._unit, self._memory, end - self._last, self._rng
        )
        self._last = end
        frame = TaxelFrame(frozen(counts), begin, self._index)
        self._index += 1
        return frame

    def _feel(self, begin: float, end: float) -> Indentation:
        rows = self._spec.array.rows
        if begin == end or rows == 1:
            return indentation(self._surface, self._stage._at(end) @ self._mount, self._spec)
        times = begin + (end - begin) * np.arange(rows) / (rows - 1)
        poses = np.stack([self._stage._at(t) @ self._mount for t in times])
        felt = indentation(self._surface, poses, self._spec)
        skin_rows = felt.modes.shape[-2]
        taken = np.clip(np.arange(skin_rows) - (skin_rows - rows) // 2, 0, rows - 1)
        modes = felt.modes[taken, :, np.arange(skin_rows)].transpose(1, 0, 2)
        return Indentation(modes, felt.deepest.max())

    def _watch(self, time: float, felt: Indentation) -> None:
        deepest = float(felt.deepest)
        if deepest > 0.0 and not self._touching:
            self._stage._touch()
        self._touching = deepest > 0.0
        if deepest >= self._spec.elastomer.thickness - 1e-6:
            over = deepest - self._spec.elastomer.thickness
            self._stage._events.append(StageEvent("overpress", time, over, self.array.name))
        where = self._stage._true @ self._mount
        if self._clear_until is not None:
            moved = inverse(self._clear_until[0]) @ where
            reach = float(np.linalg.norm(self._spec.housing.size))
            turned = float(np.linalg.norm(moved[:3, :3] - np.eye(3))) * reach
            if float(np.linalg.norm(moved[:3, 3])) + turned < self._clear_until[1]:
                return
        free = clearance(self._surface, where, self._spec)
        self._clear_until = (where, free) if free > 0 else None
        if free < 0.0:
            self._stage._events.append(StageEvent("collision", time, -free, self.array.name))
