"""Calibrate a simulated unit before it explores, as `palpate hardware calibrate` does a real one: press a flat.

Cells of many arrays differ by a tenth and more.  Taken for alike, they bend every flat face: nobody would explore
with such an array before its gains are known.
"""

import numpy as np
import trimesh

from exploration.devices.simulated import SimulatedArray
from exploration.sensing.calibrating.calibrate import CalibrationFrames, calibrate
from exploration.sensing.calibration import Calibration
from models.solid import Solid
from primitives import pose as se3

_AIR, _FRAMES = 64, 16  # of the free pad, and at each press
_TILTS = ((0.0, 0.0), (0.012, 0.0), (-0.012, 0.0), (0.0, 0.012), (0.0, -0.012), (0.0, 0.0))  # [rad]
_DEPTHS = (0.7, 0.85, 1.0)  # of the press that the data sheet names
_WIDE, _THICK = 3.0, 10.0  # times the pad, and [mm], of the flat


def calibrated(array: SimulatedArray, rng: np.random.Generator) -> Calibration:
    """What presses of this very unit on a flat tell; the data sheet where all cells are alike."""
    spec, nominal = array.spec, Calibration.nominal(array.spec)
    if spec.electronics.gain_spread == 0.0 and spec.electronics.dead == 0.0:
        return nominal
    side = _WIDE * max(*spec.array.size, *spec.housing.size[:2])
    flat = _flat(side)
    air = array.over(flat, _over(-10.0), rng)
    presses = [
        array.over(flat, _over(share * spec.press_depth, tilt), rng) for share in _DEPTHS for tilt in _TILTS
    ]
    frames = CalibrationFrames(
        [air.read() for _ in range(_AIR)], [[press.read() for _ in range(_FRAMES)] for press in presses]
    )
    return calibrate(frames, nominal, spec.array)


def _flat(side: float) -> Solid:
    """A plate whose upper side is z = 0."""
    plate = trimesh.creation.box((side, side, _THICK)).apply_translation([0.0, 0.0, -0.5 * _THICK])
    return Solid.from_mesh(plate.vertices, plate.faces)


def _over(depth: float, tilt: tuple[float, float] = (0.0, 0.0)) -> np.ndarray:
    """(4, 4) of a pad that faces down, its middle `depth` [mm] below the plate's upper side."""
    down = np.diag([1.0, -1.0, -1.0]) @ se3.rotation_exp([*tilt, 0.0])
    return se3.pose(down, [0.0, 0.0, -depth])
