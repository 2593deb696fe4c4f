"""A simulated unit that differs from its data sheet and sits askew, calibrated by its own stage."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from exploration.devices.guard import Guard, GuardLimits
from exploration.devices.simulated import simulate
from exploration.sensing.calibration import Calibration
from exploration.sensing.physics.electronics import Unit
from exploration.sensing.spec import SensorSpec, load_sensor
from models.solid import Solid
from primitives import pose as se3
from recognition.hardware.artifact import Artifact, emulated_artifact
from recognition.hardware.calibrate import Made, made_by
from recognition.hardware.presses import StagePresses

STIFFER, NARROWER = 1.12, 0.88  # the unit's rubber over the data sheet's
TURNED, MOVED = 0.03, 1.5  # [rad], [mm] 1 sigma of where it sits


class _ToldCentered:
    """An array whose driver takes it to sit on the flange's middle."""

    flange_from_sensor = np.eye(4)

    def __init__(self, array):
        self._array = array

    def __getattr__(self, name):
        return getattr(self._array, name)


@dataclass(frozen=True)
class Calibrated:
    """The truth, and what was found."""

    sheet: SensorSpec
    true: SensorSpec
    unit: Unit
    mount: np.ndarray
    made: Made

    def errors(self, known: Calibration, mount: np.ndarray) -> dict[str, float]:
        """Of a calibration: gains, spread and stiffness relative; place [mm] and turn [deg] of the mount."""
        live = ~self.unit.dead & ~known.dead
        gain = known.gain / (self.unit.gain * self.sheet.counts_per_pressure)
        off = se3.log(se3.inverse(self.mount) @ mount)
        return {
            "gains": float(np.sqrt(np.mean((gain[live] - 1.0) ** 2))),
            "spread": abs(known.spread / self.true.elastomer.spread - 1.0),
            "stiffness": abs(known.stiffness / self.true.elastomer.stiffness - 1.0),
            "place_mm": float(np.linalg.norm(mount[:3, 3] - self.mount[:3, 3])),
            "turn_deg": float(np.degrees(np.linalg.norm(off[3:]))),
        }


def calibrated_unit(seed: int, name: str = "lts210") -> Calibrated:
    """Draw one, and calibrate it."""
    sheet, rng = load_sensor(name), np.random.default_rng(seed)
    told = sheet.elastomer
    rubber = replace(told, stiffness=told.stiffness * STIFFER, spread=told.spread * NARROWER)
    plateau = sheet.electronics.plateau * STIFFER  # so that counts per N/mm^2 are the sheet's
    electronics = replace(sheet.electronics, plateau=plateau, gain_spread=0.1, dead=0.02)
    true = replace(sheet, elastomer=rubber, electronics=electronics)
    mount = se3.pose(se3.rotation_exp(rng.normal(0.0, TURNED, 3)), rng.normal(0.0, MOVED, 3))
    above = se3.pose(np.diag([1.0, -1.0, -1.0]), [0.0, 0.0, 100.0])
    solid = Solid.from_csg(emulated_artifact())
    stage, (array,) = simulate(solid, [true], rng, start_pose=above, flange_from_sensor=[mount])
    unit = array._unit
    guard = Guard(stage, [_ToldCentered(array)], [Calibration.nominal(sheet)], GuardLimits())
    presses = StagePresses(guard, sheet, Artifact(), np.random.default_rng(seed))
    made = made_by(presses, lambda line: None, sheet, Artifact(), np.eye(4))
    return Calibrated(sheet, true, unit, mount, made)
