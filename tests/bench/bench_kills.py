"""Explorations killed at random moments: what the recording still replays, and what `reconstruct` makes of it.

The oracle of the replay is the mcap package's own stream reader: every frame of every chunk that is whole on
the disk must come back.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import suppress
from pathlib import Path

import numpy as np
from mcap.exceptions import McapError
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader

from exploration.recordings.mcap import RecordedFrame, read

COUNT = int(os.environ.get("PALPATE_BENCH_KILLS", "50"))
PARTS = ("block", "cylinder", "wedge", "disc", "frustum")
BY_THE_KILL = -signal.SIGKILL
_PALPATE = (sys.executable, "-c", "import sys; from recognition.cli import main; sys.exit(main())")


def run() -> list[dict]:
    rng = np.random.default_rng(0)
    last: dict[str, float] = {}  # [s] that a whole exploration takes here, with its start
    replays = answered = models = 0
    faces: list[int] = []
    for k in range(COUNT):
        part = PARTS[k % len(PARTS)]
        with tempfile.TemporaryDirectory() as folder:
            if part not in last:
                last[part] = _explore(part, Path(folder) / "whole")
            _explore(part, Path(folder) / "run", float(rng.uniform()) * last[part])
            replays += _replays(Path(folder) / "run" / "episode.mcap")
            found = _reconstruct(Path(folder) / "run")
        answered += found is not None
        models += bool(found)
        faces += [found or 0]
        print(f"kills: {k + 1} of {COUNT}", file=sys.stderr, end="\r", flush=True)

    def row(metric: str, value: float, asked: str = "") -> dict:
        told = {"bench": "kills", "method": "SIGKILL", "metric": metric, "value": float(value), "unit": ""}
        return {**told, "asked": asked} if asked else told

    return [
        row("recordings that replay to their last whole chunk", replays, str(COUNT)),
        row("reconstructed, or told in one line that nothing was felt yet", answered, str(COUNT)),
        row("reconstructed with a face or more", models),
        row("faces, median", float(np.median(faces))),
    ]


def _explore(part: str, out: Path, kill_after: float | None = None) -> float:
    """[s] that it took from the first byte of its recording; ended then, where asked."""
    command = [*_PALPATE, "explore", part, "--out", str(out), "--json"]
    running = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    recording = out / "episode.mcap"
    while running.poll() is None and not (recording.exists() and recording.stat().st_size):
        time.sleep(0.01)
    began = time.perf_counter()
    try:
        running.wait(kill_after)
    except subprocess.TimeoutExpired:
        running.kill()
        running.wait()
    if running.returncode not in (0, BY_THE_KILL):
        raise RuntimeError(f"{' '.join(command[3:])} ended with {running.returncode}")
    return time.perf_counter() - began


def _replays(recording: Path) -> bool:
    """Whether all that is whole in a recording is read."""
    pixels: set[int] = set()  # channels
    whole = 0
    with recording.open("rb") as file, suppress(McapError, EOFError, ValueError):
        for record in StreamReader(file).records:
            if isinstance(record, Channel) and record.topic.endswith("/taxels"):
                pixels.add(record.id)
            whole += isinstance(record, Message) and record.channel_id in pixels
    ours = sum(isinstance(item, RecordedFrame) for item in read(recording))
    return ours in (whole, whole - 1)  # the last one's pose may be lost


def _reconstruct(run_folder: Path) -> int | None:
    """Faces of the model; 0 where one line says that nothing was felt; None where neither came."""
    command = [*_PALPATE, "reconstruct", str(run_folder), "--json"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    if done.returncode == 0:
        return len(json.loads(done.stdout)["faces"])
    told = [line for line in done.stderr.splitlines() if line.startswith("palpate: ")]
    return 0 if len(told) == 1 and "Traceback" not in done.stderr else None
