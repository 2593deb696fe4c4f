"""One suite of 200 trials by every way to run it: the tables compared, the engine's share of the time, kills.

Asked: the same table whatever the way, but for columns of time; two workers at least 1.8 times as fast as none,
which two free cores are needed for; the engine at most 5 % of the work; after twenty SIGKILLs each row once; a
suite of explorations at least 90 % of the touches a second of as many bare loops, run right after one another.

On a machine that does other things, too, processor time says more than the clock does: what workers need beyond
what one process needs is the engine's.
"""

import json
import os
import random
import resource
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq

TRIALS = int(os.environ.get("PALPATE_BENCH_TRIALS", "200"))
FRAMES = int(os.environ.get("PALPATE_BENCH_FRAMES", "100"))  # of a trial: a quarter of a second
KILLS = int(os.environ.get("PALPATE_BENCH_KILLS", "20"))
SUITE = """
name = "engine"
[[trials]]
kind = "frames"
scene = ["edge", "flat"]
noise = [0.02, 0.05]
count = {frames}
seeds = {seeds}
"""
TOUCHES = """
name = "touches"
[[trials]]
kind = "explore"
part = ["sphere", "cube"]
seeds = {seeds}
"""
BARE = """
import sys, tempfile, time
from pathlib import Path
from recognition.config import ExploreOptions
from recognition.explore import run
seeds, first, step = map(int, sys.argv[1:])
trials = [(part, seed) for part in ("sphere", "cube") for seed in range(seeds)][first::step]
touches, began = 0, time.perf_counter()
with tempfile.TemporaryDirectory() as folder:
    for part, seed in trials:
        out = Path(folder) / f"{part}{seed}"
        touches += run(ExploreOptions(part=part, seed=seed, out=out), lambda progress: None)["touches"]
print(touches, time.perf_counter() - began)
"""
_TOLD = Path(sys.executable).with_name("palpate")


def run() -> list[dict[str, Any]]:
    """Rows for the table."""
    with tempfile.TemporaryDirectory(prefix="palpate-bench-") as folder:
        room = Path(folder)
        suite = room / "engine.toml"
        suite.write_text(SUITE.format(seeds=TRIALS // 4, frames=FRAMES))
        return [*_ways(suite, room), *_killed(suite, room), *_touches(room)]


def _ways(suite: Path, room: Path) -> list[dict[str, Any]]:
    alone, seconds, alone_cpu = _run(suite, room / "alone", "--workers", "0")
    crew, crew_seconds, crew_cpu = _run(suite, room / "crew", "--workers", "2")
    shards = 0.0
    for shard in range(1, 5):
        _, took, _ = _run(suite, room / "shards", "--workers", "0", "--shard", f"{shard}/4")
        shards += took
    rows = [
        _row("in process", "time", seconds, "s"),
        _row("in process", "engine, of the work", _engine(alone, 1), "share", 0.05),
        _row("2 workers", "time", crew_seconds, "s"),
        _row("2 workers", "times as fast", seconds / crew_seconds, "x", 1.8),
        _row("2 workers", "engine, of the work", _engine(crew, 2), "share", 0.05),
        _row("2 workers", "processor time beyond one process", crew_cpu / alone_cpu - 1.0, "share", 0.05),
        _row("2 workers", "same table", _same(room / "alone", room / "crew"), "", 1),
        _row("4 shards", "time, one after another", shards, "s"),
        _row("4 shards", "same table", _same(room / "alone", room / "shards"), "", 1),
    ]
    try:
        from distributed import LocalCluster
    except ImportError:
        print("experiments: left out: distributed is not installed (palpate[cluster])", file=sys.stderr)
        return rows
    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, host="127.0.0.1"
    ) as cluster:
        _, took, _ = _run(suite, room / "dask", "--scheduler", cluster.scheduler_address)
    return [
        *rows,
        _row("dask, 2 workers", "time", took, "s"),
        _row("dask, 2 workers", "same table", _same(room / "alone", room / "dask"), "", 1),
    ]


def _killed(suite: Path, room: Path) -> list[dict[str, Any]]:
    """Killed at random moments, workers left to end by themselves, and gone on with."""
    out, rng, kills = room / "killed", random.Random(0), 0
    for _ in range(KILLS):
        started = subprocess.Popen(
            [_TOLD, "experiment", suite, "--out", out, "--resume", "--workers", "2", "--json"],
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        enough = len(_told(out)) + rng.randrange(TRIALS // KILLS)
        while started.poll() is None and len(_told(out)) < enough:
            time.sleep(0.02)
        time.sleep(rng.uniform(0.0, 0.3))
        if started.poll() is None:
            started.send_signal(signal.SIGKILL)
            kills += 1
        started.wait()
    summary, _, _ = _run(suite, out, "--resume", "--workers", "2")
    times = Counter(json.loads(line)["trial"] for line in _told(out))
    return [
        _row("killed and resumed", "kills", kills, "", KILLS),
        _row("killed and resumed", "rows", summary["rows"], "", TRIALS),
        _row("killed and resumed", "rows told twice", sum(n > 1 for n in times.values()), "", 0),
        _row("killed and resumed", "same table", _same(room / "alone", out), "", 1),
    ]


def _told(out: Path) -> list[str]:
    """The whole lines of the trials that are done."""
    lines = [
        line for path in out.glob("trials*.jsonl") for line in path.read_text().splitlines(keepends=True)
    ]
    return [line for line in lines if line.endswith("\n")]


def _touches(room: Path) -> list[dict[str, Any]]:
    """A suite of explorations on two workers, and two bare loops over the same ones."""
    suite, seeds = room / "touches.toml", max(1, TRIALS // 12)
    suite.write_text(TOUCHES.format(seeds=seeds))
    _, seconds, spent = _run(suite, room / "touches", "--workers", "2")
    made = sum(pq.read_table(room / "touches" / "results.parquet")["touches"].to_pylist())
    command, before = [sys.executable, "-c", BARE, str(seeds)], _processor()
    loops = [
        subprocess.Popen(
            [*command, str(k), "2"],
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "OMP_NUM_THREADS": "1"},
            start_new_session=True,  # as workers are: some systems share processors out by session
        )
        for k in range(2)
    ]
    told = [[float(x) for x in loop.communicate()[0].split()] for loop in loops]
    bare = sum(touches / took for touches, took in told)
    of_processor = sum(touches for touches, _ in told) / (_processor() - before)
    return [
        _row("suite on 2 workers", "touches", made / seconds, "1/s"),
        _row("2 bare loops", "touches", bare, "1/s"),
        _row("suite on 2 workers", "of the bare loops", made / seconds / bare, "share", 0.9),
        _row("suite on 2 workers", "of them, by processor time", made / spent / of_processor, "share", 0.9),
    ]


def _run(suite: Path, out: Path, *flags: str) -> tuple[dict[str, Any], float, float]:
    """The summary, the time on the clock and that of processors [s]."""
    began, before = time.perf_counter(), _processor()
    told = subprocess.run(
        [_TOLD, "experiment", suite, "--out", out, "--json", *flags], capture_output=True, text=True
    )
    if told.returncode:
        raise RuntimeError(told.stderr)
    return json.loads(told.stdout), time.perf_counter() - began, _processor() - before


def _processor() -> float:
    """[s] that processes which were waited for have used."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _engine(summary: dict[str, Any], workers: int) -> float:
    """The workers' time that was not spent on trials, as a share of that which was."""
    return float(workers * summary["wall_seconds"] / summary["work_seconds"] - 1.0)


def _same(one: Path, other: Path) -> int:
    tables = [pq.read_table(folder / "results.parquet") for folder in (one, other)]
    names = [name for name in tables[0].column_names if not name.endswith("_seconds")]
    return int(tables[0].select(names).equals(tables[1].select(names)))


def _row(method: str, metric: str, value: float, unit: str, asked: float | None = None) -> dict[str, Any]:
    row = {"bench": "experiments", "method": method, "metric": metric, "value": value, "unit": unit}
    return row if asked is None else row | {"asked": asked}
