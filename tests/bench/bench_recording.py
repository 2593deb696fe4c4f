"""What recording an episode costs a servo tick, beside the plainest record that could be kept of it."""

import json
import tempfile
import time
from pathlib import Path

import numpy as np

from exploration.recordings.mcap import Recorder
from exploration.sensing.frame import TaxelFrame

COUNT = 4000


def run() -> list[dict]:
    rng = np.random.default_rng(0)
    frames = [TaxelFrame(np.round(rng.normal(300, 30, (10, 16))), i / 200, i) for i in range(COUNT)]
    place, wrench = np.eye(4), np.arange(6.0)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "e.mcap"
        ticks = []
        with Recorder(path) as recorder:
            for frame in frames:
                began = time.perf_counter()
                recorder.frame("lts210", frame, place, wrench)
                ticks.append(time.perf_counter() - began)
        size = path.stat().st_size
        began = time.perf_counter()
        with (Path(folder) / "e.jsonl").open("w") as file:
            for frame in frames:
                row = {
                    "time": frame.time,
                    "counts": frame.counts.tolist(),
                    "pose": place.tolist(),
                    "wrench": wrench.tolist(),
                }
                file.write(json.dumps(row) + "\n")
        lines = (time.perf_counter() - began) / COUNT
        lines_size = (Path(folder) / "e.jsonl").stat().st_size
    us = 1e6

    def row(method, metric, value, unit, asked=""):
        out = {"bench": "recording", "method": method, "metric": metric, "value": float(value), "unit": unit}
        return {**out, "asked": asked} if asked else out

    return [
        row("mcap", "mean per frame", np.mean(ticks) * us, "us", "< 50"),
        row("mcap", "worst frame", np.max(ticks) * us, "us"),
        row("mcap", "size per frame", size / COUNT, "bytes"),
        row("JSON lines", "mean per frame", lines * us, "us"),
        row("JSON lines", "size per frame", lines_size / COUNT, "bytes"),
    ]
