"""Devices on pseudo-terminals: calibration by the stage against the unit's truth, the loop, faults.

PALPATE_BENCH_SEEDS units are calibrated (default 3), beside the data sheet alone; twelve faults are injected, one
of each kind (`make faults` injects 200).
"""

import os
import tempfile
import threading
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np
from devices.calibrated_unit import calibrated_unit
from devices.fault_trial import KINDS, trial
from devices.judged_rig import JudgedRig

from exploration.sensing.calibration import Calibration
from recognition.hardware.config import load_device
from recognition.hardware.rig import open_rig

SEEDS = int(os.environ.get("PALPATE_BENCH_SEEDS", "3"))
ASKED = {"gains": 0.03, "spread": 0.05, "stiffness": 0.05, "place_mm": 0.1, "turn_deg": 0.2}
UNITS = {"place_mm": "mm", "turn_deg": "deg"}
SECONDS = 5.0  # of the rig's clock, for the loop


def run() -> list[dict[str, Any]]:
    """All rows."""
    return [*_calibration(), *_loop(), *_faults()]


def _calibration() -> list[dict[str, Any]]:
    found: dict[str, list[dict[str, float]]] = {"stage": [], "data sheet": []}
    for seed in range(SEEDS):
        done = calibrated_unit(seed)
        known, mount = done.made.calibration, done.made.mount
        found["stage"].append(done.errors(known, mount.flange_from_sensor))
        found["data sheet"].append(done.errors(Calibration.nominal(done.sheet), np.eye(4)))
    return [
        _row(
            method, f"{name} off, worst of {SEEDS}", max(e[name] for e in errors), UNITS.get(name, "1"), asked
        )
        for method, errors in found.items()
        for name, asked in ASKED.items()
    ]


def _loop() -> list[dict[str, Any]]:
    """Ticks a second of the rig's clock, and the processor's time that the devices' threads take of it."""
    with tempfile.TemporaryDirectory() as name, JudgedRig(Path(name), 80.0, 30.0, 0, 1.0, "flexitac") as rig:
        config = load_device(rig.config)
        with closing(open_rig(config)) as devices:
            names = {
                t.name: t.native_id for t in threading.enumerate() if t.name in ("stage", "array lts210")
            }
            devices.array.read()
            began, spent, ticks = config.clock.now(), _spent(names), 0
            missed = devices.array.counts.missed
            while config.clock.now() - began < SECONDS:
                swing = 10.0 * np.sin(4.0 * (config.clock.now() - began))
                devices.stage.move(np.array([swing, 0.0, 0.0, 0.0, 0.0, 0.0]))
                devices.array.read()
                devices.stage.pose()
                ticks += 1
            seconds = config.clock.now() - began
            missed = devices.array.counts.missed - missed
            share = (_spent(names) - spent) / seconds
    return [
        _row("pty", "loop", ticks / seconds, "Hz", 200.0),
        _row("pty", "frames missed", missed / max(1, ticks + missed), "1"),
        _row("pty", "core spent on array and stage", share, "1", 0.2),
    ]


def _spent(threads: dict[str, int | None]) -> float:
    """[s] of processor time."""
    tick = os.sysconf("SC_CLK_TCK")
    stats = [
        Path(f"/proc/self/task/{i}/stat").read_text().rsplit(")", 1)[1].split() for i in threads.values()
    ]
    return sum(int(s[11]) + int(s[12]) for s in stats) / tick


def _faults() -> list[dict[str, Any]]:
    told = [trial(kind, seed) for seed, kind in enumerate(KINDS)]
    late = [t.stopped for t in told if np.isfinite(t.stopped)]
    measures: dict[str, Callable[[], float]] = {
        "as they must be": lambda: float(np.mean([not t.wrong for t in told])),
        "greatest force over the limit": lambda: max(t.most_force for t in told) / 30.0,
    }
    rows = [_row("faults", name, measure(), "1", 1.0) for name, measure in measures.items()]
    return [*rows, _row("faults", "stood after, braking and all, worst", max(late), "s")]


def _row(method: str, metric: str, value: float, unit: str, asked: float | None = None) -> dict[str, Any]:
    row = {"bench": "devices", "method": method, "metric": metric, "value": float(value), "unit": unit}
    return row if asked is None else {**row, "asked": asked}
