"""Runs killed at a random moment: whether what they left behind replays, and can be reconstructed."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from primitives.errors import PalpateError
from recognition.reconstructing.options import ReconstructSourceOptions
from recognition.reconstructing.run import run as reconstruct_run
from recognition.sources import read_source

_LONGEST = 120.0  # [s] of a run that is let go


def killed_rows(count: int) -> list[dict[str, Any]]:
    """Of `count` explorations, each killed once it has recorded a random share of a whole run's bytes."""
    rng, replayed, rebuilt = np.random.default_rng(0), 0, 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        whole = _explored(folder / "whole", np.inf)
        for k in range(count):
            _explored(folder / f"run{k}", float(rng.uniform(0.02, 0.98)) * whole)
            try:
                source = read_source(folder / f"run{k}")
                replayed += source.felt.frames > 0
                options = ReconstructSourceOptions(folder / f"run{k}", out=folder / f"model{k}")
                reconstruct_run(options, lambda progress: None)
                rebuilt += (folder / f"model{k}" / "summary.json").is_file()
            except PalpateError as error:
                print(f"  killed run {k}: {error}", file=sys.stderr)
    shared = {"bench": "clouds", "method": "palpate", "unit": f"of {count}", "asked": count}
    return [
        shared | {"metric": "killed runs that replay to the last chunk", "value": float(replayed)},
        shared | {"metric": "killed runs that reconstruct answers", "value": float(rebuilt)},
    ]


def _explored(out: Path, until: float) -> float:
    """Bytes recorded when the run ended, or was killed."""
    command = [sys.executable, "-m", "recognition.cli", "explore", "block", "--out", str(out)]
    environment = os.environ | {"OMP_NUM_THREADS": "1"}
    quiet = subprocess.DEVNULL
    process = subprocess.Popen(command, stdout=quiet, stderr=quiet, env=environment)
    recording, began, size = out / "episode.mcap", time.perf_counter(), 0.0
    while process.poll() is None and time.perf_counter() - began < _LONGEST:
        size = float(recording.stat().st_size) if recording.is_file() else 0.0
        if size >= until:
            process.send_signal(signal.SIGKILL)
        time.sleep(0.005)
    process.kill()
    process.wait()
    return float(recording.stat().st_size) if recording.is_file() else size
