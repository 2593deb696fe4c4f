"""A simulated array: each frame is the gap at the stage's true pose, run through rubber and electronics.

What a real array cannot know (the surface, the true pose, the unit's gains) is private here: truth belongs to
the evaluator.
"""

from math import ceil

import numpy as np

from exploration.devices.free_space_bound import FreeSpaceBound
from exploration.devices.idle_array import IdleArray
from exploration.devices.protocols import StageEvent
from exploration.devices.simulated_stage import SimulatedStage
from exploration.sensing.frame import TaxelArray, TaxelFrame
from exploration.sensing.physics.capacitor import transducer
from exploration.sensing.physics.electronics import Memory, Unit, draw_unit, read_out
from exploration.sensing.physics.gap import gap
from exploration.sensing.physics.housing import HousingWatch
from exploration.sensing.physics.skin import skin_of
from exploration.sensing.physics.touched_material import TouchedMaterial
from exploration.sensing.physics.warmth import Warmth
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Floats, frozen
from primitives.surface import MaterialSurface, Surface


class SimulatedArray:
    """An array on a simulated stage."""

    def __init__(
        self,
        surface: Surface,
        spec: SensorSpec,
        stage: SimulatedStage,
        flange_from_sensor: Floats,
        rng: np.random.Generator,
        unit: Unit | None = None,
    ) -> None:
        self._surface, self._spec, self._stage, self._rng = surface, spec, stage, rng
        self._mount = frozen(flange_from_sensor)
        self.idle: tuple[
            IdleArray, ...
        ] = ()  # the others on the stage, which touch nothing unless they collide
        self._gap, self._taxels, self._housing = (
            gap(surface, spec),
            transducer(spec),
            HousingWatch(surface, spec),
        )
        self._material: TouchedMaterial | None = None
        if isinstance(surface, MaterialSurface):
            self._material = TouchedMaterial(surface, skin_of(spec), spec.elastomer.stiffness)
        self._far = FreeSpaceBound(surface, spec, stage.limits)
        self._nothing = np.zeros(spec.array.shape)
        self._share = _scan_share(spec)
        self._unit = draw_unit(spec, rng) if unit is None else unit
        self._memory = Memory.fresh(spec)
        self._index = 0
        self._due = 0
        self._last = 0.0
        self._touching = False
        self._warmth: Warmth | None = None
        if spec.thermal is not None:
            self._warmth = Warmth(spec.thermal, surface, rng)

    def over(self, surface: Surface, pose: Floats, rng: np.random.Generator) -> "SimulatedArray":
        """The same unit at rest over another surface, at a (4, 4) pose, and just switched on."""
        stage = SimulatedStage(pose, rng.spawn(1)[0])
        return SimulatedArray(surface, self._spec, stage, np.eye(4), rng, self._unit)

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
        self._due = max(self._due + 1, ceil(stage._time / spec.period - 1e-6))
        end = self._due * spec.period
        stage._advance(end)
        begin = end - spec.electronics.scan
        here = stage._true @ self._mount
        for other in self.idle:
            if (met := other.met(stage._true, end)) is not None:
                stage._events.append(met)
        if self._far.holds(here):
            pressed, self._touching = self._nothing, False
        else:
            poses = here[None]
            if self._share is not None:
                poses = stage._trail.at(begin + (end - begin) * self._share, self._mount)
            deepest = self._gap.feel(poses)
            if self._material is not None:
                deepest = self._material.give_way(poses, self._gap.modes, self._gap.partial, deepest)
            self._watch(end, deepest, here)
            pressed = self._taxels.press(self._gap.modes, self._gap.partial)
        counts, self._memory = read_out(pressed, spec, self._unit, self._memory, end - self._last, self._rng)
        felt = None
        if self._warmth is not None:
            felt = self._warmth.felt(end - self._last, self._touching)
        self._last = end
        frame = TaxelFrame(frozen(counts), begin, self._index, felt)
        self._index += 1
        return frame

    def _watch(self, time: float, deepest: float, here: Floats) -> None:
        if deepest > 0.0 and not self._touching:
            self._stage._touch()
        self._touching = deepest > 0.0
        if deepest >= self._spec.elastomer.thickness - 1e-6:
            over = deepest - self._spec.elastomer.thickness
            self._stage._events.append(StageEvent("overpress", time, over, self.array.name))
        overlap = self._housing.overlap(here)
        if overlap > 0.0:
            self._stage._events.append(StageEvent("collision", time, overlap, self.array.name))


def _scan_share(spec: SensorSpec) -> Floats | None:
    """(2 R + 1,) share of the scan after which each row of corners and cells is read; None: all at once."""
    rows = spec.array.rows
    if spec.electronics.scan == 0.0 or rows == 1:
        return None
    cells = len(skin_of(spec).y_edges) - 1
    row = np.clip((np.arange(2 * cells + 1) - cells) / 2 + (rows - 1) / 2, 0, rows - 1)
    return frozen(row / (rows - 1))
