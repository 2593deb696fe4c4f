"""`palpate hardware check`: whether array and stage are as their config says; nothing moves."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from exploration.sensing.calibrating.rest import rest
from recognition.hardware.config import DeviceConfig, load_device
from recognition.hardware.rig import calibration_of, open_array, open_rig, sensor_of

_FRAMES = 40
_RATE = 0.3  # share by which the array's rate may differ from its data sheet's
_CREPT = 8.0  # standard deviations of a zero, beyond which it has moved since the calibration


def check(path: Path) -> dict[str, Any]:
    """What was measured, and what is not as it should be; the array must touch nothing."""
    config = load_device(path)
    spec = sensor_of(config)
    calibration, _ = calibration_of(config, spec)
    rig = open_rig(config) if config.stage is not None else None
    array = rig.array if rig is not None else open_array(config)
    try:
        array.read()
        began, first = config.clock.now(), array.counts.read
        frames = [array.read() for _ in range(_FRAMES)]
        rate = (array.counts.read - first) / (config.clock.now() - began)
        where = None if rig is None else rig.stage.pose()
    finally:
        if rig is not None:
            rig.close()
        else:
            array.close()
    air = rest(frames)
    wrong = _wrong(config, rate, 1.0 / spec.period)
    crept = np.abs(air.zero - calibration.zero) > _CREPT * np.hypot(calibration.noise, air.noise)
    if crept.mean() > 0.1:
        wrong.append(
            f"the zero of {int(crept.sum())} taxels has moved; lift the array off, or calibrate again"
        )
    if air.noise > 3.0 * calibration.noise:
        wrong.append(
            f"the noise is {air.noise:.1f} counts, not {calibration.noise:.1f}; check shield and power"
        )
    return {
        "config": str(path),
        "rate_hz": rate,
        "noise_counts": air.noise,
        "zero_counts": float(air.zero.mean()),
        "restless_taxels": int(air.restless.sum()),
        "late_frames": array.counts.late,
        "lost_frames": array.counts.lost,
        "skipped_bytes": array.counts.skipped_bytes,
        "flange_mm": None if where is None else np.round(where[:3, 3], 3).tolist(),
        "wrong": wrong,
        "healthy": not wrong,
    }


def _wrong(config: DeviceConfig, rate: float, told: float) -> list[str]:
    if abs(rate / told - 1.0) > _RATE:
        return [
            f"{rate:.0f} frames a second came, not {told:.0f}: check period in {config.array.sensor}, and cable"
        ]
    return []


def check_text(told: dict[str, Any]) -> str:
    """What a person reads."""
    lines = [
        f"array   {told['rate_hz']:.0f} frames/s, zero {told['zero_counts']:.1f}, "
        f"noise {told['noise_counts']:.2f} counts",
        f"        {told['late_frames']} late, {told['lost_frames']} lost frames, "
        f"{told['skipped_bytes']} bytes of no frame, {told['restless_taxels']} restless taxels",
        f"stage   flange at {told['flange_mm']} mm" if told["flange_mm"] else "stage   none in the config",
    ]
    return "\n".join(
        [*lines, *(f"WRONG   {line}" for line in told["wrong"])] + (["all well"] * told["healthy"])
    )
