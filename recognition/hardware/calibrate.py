"""`palpate hardware calibrate`: zeros, gains, dead taxels, spread, stiffness and mount, each with its sigma."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from exploration.devices.guard import Guard, GuardLimits
from exploration.sensing.calibrating.ball import BallPress, ball_of
from exploration.sensing.calibrating.calibrate import CalibrationFrames
from exploration.sensing.calibrating.calibrate import calibrate as calibrated
from exploration.sensing.calibrating.flat import gains_from_flat
from exploration.sensing.calibrating.mount import LEAST_BALLS, BallTouch, Mount, PlaneTouch, mount_of
from exploration.sensing.calibrating.rest import mean_frame
from exploration.sensing.calibration import Calibration
from exploration.sensing.spec import SensorSpec
from primitives.arrays import Floats
from primitives.errors import PalpateError
from recognition.hardware.artifact import Artifact
from recognition.hardware.config import DeviceConfig, load_device
from recognition.hardware.presses import HandPresses, Pressed, Presses, StagePresses
from recognition.hardware.rig import open_array, open_rig, sensor_of
from recognition.hardware.saved_calibration import save, told_in

Ask = Callable[[str], object]


@dataclass(frozen=True)
class Made:
    """What was found."""

    calibration: Calibration
    mount: Mount | None
    zero_sigma: float  # [counts]
    presses: dict[str, int]
    notes: list[str]


def calibrate(path: Path, out: Path, ask: Ask, seed: int = 0) -> dict[str, Any]:
    """Press what the artifact has, and write what it tells to `out`; `ask` shows a line and waits for consent."""
    config = load_device(path)
    if out.exists():
        raise PalpateError(f"{out} is there already; name a new file with --out")
    spec, artifact = sensor_of(config), config.artifact or Artifact()
    if config.stage is None:
        with closing(open_array(config)) as array:
            made = made_by(HandPresses(array, ask), lambda _: None, spec, artifact, None)
    else:
        made = _by_stage(config, spec, artifact, ask, seed)
    save(made.calibration, made.mount, out)
    told_in(path, out)
    return _told(made, path, out)


def _by_stage(config: DeviceConfig, spec: SensorSpec, artifact: Artifact, ask: Ask, seed: int) -> Made:
    if config.artifact is None:
        raise PalpateError(
            f"{config.path} has no table [artifact]; say there where flat, edge, step and ball are"
        )
    plain = replace(config, array=replace(config.array, calibration=""))
    with closing(open_rig(plain)) as rig:
        told = config.limits
        limits = GuardLimits(told.force_n, told.depth_mm, told.reach_mm)
        guard = Guard(rig.stage, [rig.array], [rig.calibration], limits)
        presses = StagePresses(guard, spec, artifact, np.random.default_rng(seed))
        return made_by(presses, ask, spec, artifact, rig.array.flange_from_sensor)


def made_by(
    presses: Presses, ask: Ask, spec: SensorSpec, artifact: Artifact, mount_guess: Floats | None
) -> Made:
    """Press everything, and solve; without a `mount_guess` (4, 4) the mount is left out."""
    nominal, done = Calibration.nominal(spec), {}
    ask("the pad goes high over the flat, and touches nothing")
    air = presses.air()
    for what in ("flat", "edge", "step", "ball"):
        ask(f"the pad presses the {what}")
        done[what] = list(presses.on(what))
    frames = CalibrationFrames(
        air=air,
        flats=[press.frames for press in done["flat"]],
        edges=[press.frames for press in done["edge"]],
        steps=[press.frames for press in done["step"]],
        step_height=artifact.step_height_mm,
        step_height_sigma=artifact.step_sigma_mm,
    )
    calibration = calibrated(frames, nominal, spec.array)
    mount, notes = None, []
    if mount_guess is not None:
        touches = _balls(done["ball"], calibration, spec, artifact.ball_radius_mm)
        if len(touches) < LEAST_BALLS:
            notes.append(f"the ball was felt {len(touches)} times: where the array sits stays as it was told")
        else:
            planes = _planes(done["flat"], calibration, spec)
            known = calibration.stiffness_sigma / calibration.stiffness
            mount = mount_of(touches, planes, mount_guess, spec.array.size, known)
            stiffness = calibration.stiffness * mount.depth_ratio
            sigma = stiffness * mount.depth_ratio_sigma
            calibration = replace(calibration, stiffness=stiffness, stiffness_sigma=sigma)
    zero_sigma = calibration.noise / float(np.sqrt(len(air)))
    return Made(calibration, mount, zero_sigma, {what: len(made) for what, made in done.items()}, notes)


def _balls(
    presses: list[Pressed], calibration: Calibration, spec: SensorSpec, radius: float
) -> list[BallTouch]:
    found = []
    for press in presses:
        ball = ball_of(mean_frame(press.frames), radius, calibration, spec.array)
        if isinstance(ball, BallPress) and press.world_from_flange is not None:
            found.append(BallTouch(press.world_from_flange, ball))
    return found


def _planes(presses: list[Pressed], calibration: Calibration, spec: SensorSpec) -> list[PlaneTouch]:
    """The flat as each press saw it, in mm of the calibration just made."""
    flats = [mean_frame(press.frames) for press in presses]
    told = gains_from_flat(flats, calibration, spec.array, min(len(press.frames) for press in presses))
    return [
        PlaneTouch(press.world_from_flange, plane, 0.0)
        for press, plane in zip(presses, told.planes, strict=True)
        if press.world_from_flange is not None
    ]


def _told(made: Made, path: Path, out: Path) -> dict[str, Any]:
    c, mount = made.calibration, made.mount
    live = ~c.dead
    return {
        "config": str(path),
        "file": str(out),
        "presses": made.presses,
        "zero_counts": {"mean": float(c.zero[live].mean()), "sigma": made.zero_sigma},
        "noise_counts": c.noise,
        "gains": {
            "scatter": float(np.std(c.gain[live] / c.gain[live].mean())),
            "sigma": float(np.sqrt(np.mean(np.square(np.broadcast_to(c.gain_sigma, c.gain.shape)[live])))),
        },
        "dead_taxels": int(c.dead.sum()),
        "spread_mm": {"value": c.spread, "sigma": c.spread_sigma},
        "stiffness_n_mm3": {"value": c.stiffness, "sigma": c.stiffness_sigma},
        "mount": None
        if mount is None
        else {
            "translation_mm": mount.flange_from_sensor[:3, 3].tolist(),
            "translation_sigma_mm": mount.translation_sigma,
            "rotation_sigma_deg": float(np.degrees(mount.rotation_sigma)),
            "rms_mm": mount.rms,
        },
        "notes": made.notes,
    }


def calibrate_text(told: dict[str, Any]) -> str:
    """What a person reads."""
    zero, gains, spread = told["zero_counts"], told["gains"], told["spread_mm"]
    stiff, mount, presses = told["stiffness_n_mm3"], told["mount"], told["presses"]
    lines = [
        f"zero       {zero['mean']:.2f} ± {zero['sigma']:.2f} counts, noise {told['noise_counts']:.2f}",
        f"gains      scatter by {gains['scatter']:.1%}, known to {gains['sigma']:.1%}"
        f"   ({presses['flat']} presses of the flat)",
        f"dead       {told['dead_taxels']} taxels",
        f"spread     {spread['value']:.3f} ± {spread['sigma']:.3f} mm   ({presses['edge']} of the edge)",
        f"stiffness  {stiff['value']:.4f} ± {stiff['sigma']:.4f} N/mm^3   ({presses['step']} of the step)",
    ]
    if mount is None:
        lines.append("mount      as the config says")
    else:
        x, y, z = mount["translation_mm"]
        lines.append(
            f"mount      at {x:.2f}, {y:.2f}, {z:.2f} ± {mount['translation_sigma_mm']:.2f} mm, turned to "
            f"± {mount['rotation_sigma_deg']:.2f} deg   ({presses['ball']} of the ball)"
        )
    return "\n".join(
        [*lines, *(f"note       {note}" for note in told["notes"]), f"written to {told['file']}"]
    )
