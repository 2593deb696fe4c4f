"""A specimen of an array, pressed on ray-cast solids: counts as its wire would deliver them."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.sensing.calibrating.calibrate import CalibrationFrames
from exploration.sensing.frame import TaxelFrame
from exploration.sensing.physics.capacitor import transducer
from exploration.sensing.physics.electronics import Memory, draw_unit, read_out
from exploration.sensing.physics.gap import indentation
from exploration.sensing.spec import load_sensor
from models.csg import Cube, Cylinder
from models.solid import Solid
from primitives.pose import pose, rotation_exp

DOWN = np.diag([1.0, -1.0, -1.0])
HEIGHT = 0.3  # [mm] of the step
STIFFER, WIDER = 1.25, 1.2  # the specimen's rubber over the data sheet's


class Specimen:
    """What a maker has on the bench: its data sheet, and a truth that differs from it."""

    def __init__(self, name: str, seed: int, gain_spread: float = 0.1, dead: float = 0.03) -> None:
        self.sheet = load_sensor(name)
        self.rng = np.random.default_rng(seed)
        rubber = self.sheet.elastomer
        truth = replace(
            rubber, stiffness=rubber.stiffness * STIFFER, spread=rubber.spread * WIDER, hysteresis=0.0
        )
        electronics = replace(self.sheet.electronics, gain_spread=gain_spread, dead=dead, drift=0.0)
        self.spec = replace(self.sheet, elastomer=truth, electronics=electronics)
        self.unit = draw_unit(self.spec, self.rng)
        # The electronics see pressure: their counts per N/mm^2 are the sheet's, whatever the rubber.
        plateau = self.sheet.electronics.plateau * STIFFER
        self.spec = replace(self.spec, electronics=replace(electronics, plateau=plateau))
        self.taxels = transducer(self.spec)

    def press(self, solid: Solid | None, sensor=None, frames: int = 4) -> list[TaxelFrame]:
        pressed = np.zeros(self.spec.array.shape)
        if solid is not None:
            felt = indentation(solid, sensor, self.spec)
            pressed = self.taxels.press(felt.modes, felt.partial)
        return [
            TaxelFrame(
                read_out(pressed, self.spec, self.unit, Memory.fresh(self.spec), 0.01, self.rng)[0], 0.0, k
            )
            for k in range(frames)
        ]

    def tilted(self, angle: float, most: float, x: float, z: float):
        tilt = rotation_exp([*self.rng.uniform(-most, most, 2), 0.0])
        return pose(tilt @ rotation_exp([0.0, 0.0, angle]) @ DOWN, [x, 0.0, z])

    def frames(self) -> CalibrationFrames:
        nominal, size = self.sheet.press_depth, self.spec.array.size
        block = Solid.from_csg(Cube((100.0, 400.0, 100.0)))
        step = Solid.from_csg(
            Cube((200.0, 400.0, 100.0)) | Cube((100.0, 400.0, 100.0 + HEIGHT)).at(50.0, 0.0, HEIGHT / 2)
        )
        pin = Solid.from_csg(Cylinder(0.25 * min(size), 60.0))
        area = np.pi * (0.25 * min(size)) ** 2
        turn = self.rng.uniform(-np.pi, np.pi, 32)
        most = 0.35 * nominal / (0.5 * max(size))
        return CalibrationFrames(
            air=self.press(None, frames=40),
            flats=[
                self.press(block, self.tilted(a, most, 0.0, 50.0 - nominal * d))
                for a, d in zip(turn[:10], self.rng.uniform(0.7, 1.1, 10), strict=True)
            ],
            edges=[
                self.press(block, self.tilted(a, 0.1 * most, 50.0 + x * min(size), 50.0 - nominal))
                for a, x in zip(turn[10:20], self.rng.uniform(-0.2, 0.2, 10), strict=True)
            ],
            steps=[
                self.press(step, self.tilted(a, 0.1 * most, x, 49.85))
                for a, x in zip(turn[20:26], self.rng.uniform(-2.0, 2.0, 6), strict=True)
            ],
            step_height=HEIGHT,
            weights=[
                (
                    self.press(pin, pose(rotation_exp([0, 0, a]) @ DOWN, [0.0, 0.0, 30.0 - d])),
                    self.spec.elastomer.stiffness * d * area,
                )
                for a, d in zip(turn[26:30], (0.4, 0.5, 0.5, 0.6), strict=True)
            ],
        )


@pytest.fixture(scope="session")
def specimen():
    return Specimen
