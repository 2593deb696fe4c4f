"""Suites on processes of their own, and what may befall them: the rest is done, and what happened is told."""

import json
import os
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

import pytest
import trimesh

from recognition.experiments.log import rows_of

PALPATE = Path(sys.executable).with_name("palpate")
SUITE = """
[limits]
seconds = {seconds}
memory_mb = {memory}
[[trials]]
kind = "frames"
scene = ["edge", "flat"]
count = {count}
seeds = {seeds}
"""
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="left out: no /proc here"),
]


def begun(suite, out, *flags):
    return subprocess.Popen(
        [PALPATE, "experiment", suite, "--out", out, "--json", *flags],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def ended(process):
    out, err = process.communicate(timeout=600)
    return process.returncode, out, err


def workers(process):
    """Processes that it has started and that do its trials."""
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        try:
            parent = int(stat.read_text().rpartition(")")[2].split()[1])
            if parent == process.pid and b"experiments.worker" in (stat.parent / "cmdline").read_bytes():
                found.append(int(stat.parent.name))
        except (OSError, ValueError):
            continue
    return found


def until(told, process):
    while not (found := told()):
        assert process.poll() is None, ended(process)
        time.sleep(0.05)
    return found


@pytest.mark.parametrize(
    ("harm", "outcome", "said"),
    [
        (signal.SIGKILL, "lost", "ended by signal 9"),
        pytest.param(signal.SIGSTOP, "timeout", "longer than 10 s", marks=pytest.mark.long),
    ],
)
def test_a_worker_that_is_lost_or_hangs_costs_one_row_that_says_so(harm, outcome, said, tmp_path):
    suite = tmp_path / "some.toml"
    suite.write_text(SUITE.format(seconds=10, memory=4000, count=60, seeds=15))
    process = begun(suite, tmp_path / "out", "--workers", "2")
    until(lambda: len(rows_of([tmp_path / "out"])) > 3, process)
    os.kill(workers(process)[0], harm)
    code, out, err = ended(process)
    assert code == 0, err
    summary = json.loads(out)
    assert summary["outcomes"] == {"done": 29, outcome: 1}
    assert all(said in reason for reason in summary["reasons"])


def test_trials_that_need_too_much_are_rows_and_the_others_are_done(tmp_path):
    suite = tmp_path / "some.toml"
    trimesh.creation.icosphere(subdivisions=7, radius=20).export(tmp_path / "fine.stl")
    small = SUITE.format(seconds=300, memory=180, count=5, seeds=2)
    suite.write_text(f'{small}[[trials]]\nkind = "explore"\npart = "fine.stl"\n')
    code, out, err = ended(begun(suite, tmp_path / "out", "--workers", "2"))
    assert code == 0, err
    summary = json.loads(out)
    assert summary["outcomes"]["done"] == 4
    (reason,) = summary["reasons"]  # a kernel's own allocation may end the whole worker
    assert reason == "needed more than 180 MB ([limits] memory_mb)" or reason.startswith("its worker ended")


def test_a_disk_that_is_full_ends_it_in_one_line_and_nothing_is_done_twice(tmp_path):
    suite, out = tmp_path / "some.toml", tmp_path / "out"
    suite.write_text(SUITE.format(seconds=300, memory=4000, count=2, seeds=15))
    line = f"ulimit -f 8; exec {PALPATE} experiment {suite} --out {out} --workers 0"
    full = subprocess.run(["sh", "-c", line], capture_output=True, text=True, timeout=600)
    assert full.returncode == 1
    (said,) = [text for text in full.stderr.splitlines() if text.startswith("palpate:")]
    assert "make room, and go on with --resume" in said
    there = len(rows_of([out]))
    assert 0 < there < 30
    code, told, err = ended(begun(suite, out, "--workers", "0", "--resume"))
    assert code == 0, err
    assert json.loads(told)["outcomes"] == {"done": 30}
    lines = [json.loads(text)["trial"] for text in (out / "trials.jsonl").read_text().splitlines()]
    assert max(Counter(lines).values()) == 1
