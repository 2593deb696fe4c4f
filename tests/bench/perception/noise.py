"""From a clean frame to what a converter delivers, and back through the calibration that a user would have.

Noise is a fraction of the flat plateau at the nominal press, `counts` of which there are to that plateau; the
converter's range holds plateau and noise.  True gains spread by `gain_spread` and are known only to that; a
share `dead` of the taxels read the untouched value without telling.
"""

from dataclasses import dataclass

import numpy as np
from perception.arrays import PRESS
from perception.scene import Scene, clean

from exploration.sensing.calibration import Calibration, correct
from exploration.sensing.frame import TactileImage, TaxelFrame
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Bools, Floats, frozen


@dataclass(frozen=True)
class Noise:
    """What stands between the skin and the numbers."""

    level: float = 0.05  # 1 sigma, of the plateau
    counts: float = 200.0  # of the plateau
    gain_spread: float = 0.0
    dead: float = 0.0  # share of taxels, not known

    @property
    def sigma(self) -> float:
        """[mm] of one reading, rounding included."""
        return float(PRESS * np.hypot(self.level, 1 / (self.counts * np.sqrt(12))))

    def sigma_at(self, depth: Floats) -> Floats:
        """[mm] of each taxel, for who knows the gains to their spread only."""
        return np.hypot(self.sigma, self.gain_spread * np.maximum(depth, 0.0))

    def calibration(self, spec: SensorSpec) -> Calibration:
        """What the user knows."""
        shape = spec.array.shape
        return Calibration(
            frozen(np.zeros(shape)),
            frozen(np.full(shape, self.counts / (PRESS * spec.elastomer.stiffness))),
            frozen(np.zeros(shape), np.bool_),
            spec.elastomer.spread,
            spec.elastomer.stiffness,
            self.sigma * self.counts / PRESS,
            spec.elastomer.margin,
            self.gain_spread,
        )

    def dies(self, shape: tuple[int, int], rng: np.random.Generator) -> Bools:
        """Which taxels are dead."""
        return rng.random(shape) < self.dead


def observe(
    scene: Scene, noise: Noise, rng: np.random.Generator, depth: Floats | None = None
) -> TactileImage:
    """One frame of a scene, whose clean `depth` may be handed in."""
    depth = clean(scene) if depth is None else depth
    gain = 1.0 + noise.gain_spread * rng.standard_normal(depth.shape) if noise.gain_spread else 1.0
    counts = noise.counts * (depth * gain / PRESS + noise.level * rng.standard_normal(depth.shape))
    if scene.dead is not None:
        counts = np.where(scene.dead, 0.0, counts)
    return correct(TaxelFrame(np.round(counts), 0.0, 0), noise.calibration(scene.spec), scene.spec.array)
