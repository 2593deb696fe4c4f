"""The door to the simulator: a stage and its arrays over a surface, sharing one clock."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exploration.devices.idle_array import IdleArray
from exploration.devices.protocols import StageLimits
from exploration.devices.simulated_array import SimulatedArray
from exploration.devices.simulated_stage import PoseNoise, SimulatedStage
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Floats
from primitives.errors import PalpateError
from primitives.pose import pose, rotation_exp
from primitives.surface import Surface

__all__ = ["PoseNoise", "SimulatedArray", "SimulatedStage", "simulate", "turret"]


def simulate(
    surface: Surface,
    specs: Sequence[SensorSpec],
    rng: np.random.Generator,
    noise: float | None = None,
    pose_noise: PoseNoise | float = 0.0,
    start_pose: Floats | None = None,
    flange_from_sensor: Sequence[Floats] | None = None,
    limits: StageLimits | None = None,
    latency: float = 0.0,
) -> tuple[SimulatedStage, tuple[SimulatedArray, ...]]:
    """A stage that carries an array of each spec.

    `noise` replaces the specs' own (1 sigma, of the full-contact signal).  A `pose_noise` given as a number
    [mm] is drawn once per contact, and half of it afresh on every reading.  Without mounts several arrays stand
    on a `turret`.  One array is read at a time; the bodies of the others may touch nothing.
    """
    if not specs:
        raise PalpateError("a simulation needs at least one sensor")
    mounts = turret(specs) if flange_from_sensor is None else list(flange_from_sensor)
    if len(mounts) != len(specs):
        raise PalpateError(f"{len(specs)} sensors need as many mounts, not {len(mounts)}")
    encoder = pose_noise if isinstance(pose_noise, PoseNoise) else PoseNoise(pose_noise / 2, pose_noise)
    stage = SimulatedStage(
        np.eye(4) if start_pose is None else start_pose, rng.spawn(1)[0], limits, encoder, latency
    )
    told = [
        s if noise is None else replace(s, electronics=replace(s.electronics, noise=noise)) for s in specs
    ]
    arrays = tuple(
        SimulatedArray(surface, s, stage, mount, rng.spawn(1)[0])
        for s, mount in zip(told, mounts, strict=True)
    )
    for array in arrays if len(arrays) > 1 else ():
        array.idle = tuple(
            IdleArray(surface, s, mount, stage.limits)
            for s, mount, other in zip(told, mounts, arrays, strict=True)
            if other is not array
        )
    return stage, arrays


def turret(specs: Sequence[SensorSpec]) -> list[Floats]:
    """flange_from_sensor of each: one faces +z; several face outward round the flange's y axis."""
    if len(specs) == 1:
        return [np.eye(4)]
    half = max(s.housing.size[0] for s in specs) / 2
    back = half / np.tan(np.pi / len(specs)) if len(specs) > 2 else 1.0
    mounts = []
    for i, spec in enumerate(specs):
        turn = pose(rotation_exp([0.0, 2 * np.pi * i / len(specs), 0.0]))
        mounts.append(turn @ pose(None, [0.0, 0.0, back + spec.housing.size[2] + spec.housing.proud]))
    return mounts
