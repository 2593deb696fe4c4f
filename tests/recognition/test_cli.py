import json
import os
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from exploration.recordings.mcap import read
from recognition.cli import app
from recognition.config import ExploreOptions
from recognition.running.progress import Progress

BROKEN = {
    "nothing": (["explore"], 1, "needs a part"),
    "unknown part": (["explore", "blokc"], 1, "did you mean block?"),
    "half a pose": (["explore", "block", "--pose", "1,2,3"], 2, "--pose"),
    "inside-out workspace": (["explore", "block", "--workspace", "1,1,1,-1,-1,-1"], 2, "--workspace"),
    "word for a number": (["explore", "block", "--seed", "many"], 2, "--seed"),
    "unknown flag": (["explore", "block", "--bogus"], 2, "--bogus"),
    "unknown unit": (["explore", "block", "--units", "miles"], 2, "miles"),
    "unknown command": (["explode"], 2, "explode"),
    "absent file": (["explore", "absent.stl"], 1, "absent.stl"),
    "unknown sensor": (["explore", "block", "--sensor", "lts211"], 1, "did you mean lts210?"),
    "unknown sensors": (["explore", "block", "--sensor", "a,b"], 1, "no sensor 'a'"),
    "no sensor": (["explore", "block", "--sensor", ","], 2, "--sensor"),
    "half a workspace": (["explore", "block", "--workspace", "1,2,3"], 2, "X0,Y0,Z0,X1,Y1,Z1"),
    "no turn": (["explore", "block", "--pose", "1,2,3,0,0,0,0"], 2, "quaternion"),
    "nowhere to write": (["explore", "block", "--out", "/dev/null/run"], 1, "--out"),
}


def palpate(*arguments, cwd):
    return subprocess.run(
        [sys.executable, "-m", "recognition.cli", *arguments],
        capture_output=True,
        text=True,
        cwd=cwd,
        timeout=120,
    )


@pytest.mark.parametrize(("arguments", "code", "says"), BROKEN.values(), ids=BROKEN)
def test_what_is_wrong_is_said_without_a_traceback_and_leaves_nothing(
    arguments, code, says, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == code
    assert says in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stdout == ""
    assert list(tmp_path.iterdir()) == []


def test_after_an_unknown_part_comes_the_list_of_parts(tmp_path):
    first, blank, *table = palpate("explore", "blokc", cwd=tmp_path).stderr.splitlines()
    assert first == "palpate: no part 'blokc'; did you mean block? (palpate parts lists all)"
    assert blank == ""
    assert table[0].split()[0] == "name"
    assert any(line.startswith("block ") for line in table)


@pytest.mark.parametrize("command", ["parts", "sensors", "doctor"])
def test_json_is_one_object_and_nothing_else(command, tmp_path):
    done = palpate(command, "--json", cwd=tmp_path)
    assert isinstance(json.loads(done.stdout), dict)
    assert done.stderr == ""


def test_help_lists_the_commands_that_are_built_and_no_other(tmp_path):
    text = palpate("--help", cwd=tmp_path).stdout
    commands = [line.split()[0] for line in text[text.index("Commands:") :].splitlines()[1:] if line.strip()]
    felt = ["explore", "reconstruct", "track", "probe", "identify", "locate", "recognize"]
    shown = ["experiment", "replay", "report", "parts", "sensors", "frames", "doctor", "library", "hardware"]
    assert sorted(commands) == sorted(felt + shown)


def test_help_loads_no_mathematics(tmp_path):
    heavy = {"numpy", "scipy", "rich", "trimesh", "numba"}
    script = f"import sys, recognition.cli; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=tmp_path
    )
    assert done.stdout.strip() == "[]"


@pytest.fixture
def exploring(monkeypatch):
    """`exploring(run, *arguments)`: the command line with another conductor in the real one's place."""

    def explore(run, *arguments):
        monkeypatch.setitem(sys.modules, "recognition.explore", SimpleNamespace(run=run))
        return CliRunner().invoke(app, ["explore", *arguments])

    return explore


def test_every_flag_reaches_the_conductor(exploring, tmp_path):
    seen = []

    def run(options, progress):
        seen.append(options)
        progress(Progress("exploring", touches=1))
        return {"a": 1}

    flags = "--units in --scale 2 --workspace -1,-2,-3,1,2,3 --feature-mm 5 --pose 1,2,3,1,0,0,0 --sensor dsa"
    flags += f" --noise 0.1 --pose-noise-mm 0.2 --seed 9 --max-touches 7 --out {tmp_path} --overwrite --json"
    done = exploring(run, "block", *flags.split())
    assert json.loads(done.stdout) == {"a": 1}
    assert seen == [
        ExploreOptions(
            part="block",
            units="in",
            scale=2.0,
            workspace=(-1, -2, -3, 1, 2, 3),
            feature=5.0,
            pose=(1, 2, 3, 1, 0, 0, 0),
            sensors=("dsa",),
            noise=0.1,
            pose_noise=0.2,
            seed=9,
            max_touches=7,
            out=tmp_path,
            overwrite=True,
        )
    ]


def test_flags_not_given_leave_the_defaults(exploring):
    seen = []
    exploring(lambda options, progress: seen.append(options) or {}, "block", "--json")
    assert seen == [ExploreOptions(part="block")]


def test_an_interrupt_is_one_line_and_exit_130(exploring):
    def run(options, progress):
        raise KeyboardInterrupt

    done = exploring(run, "block")
    assert done.exit_code == 130
    assert done.stderr.count("\n") == 1
    assert done.stdout == ""


def test_an_account_of_the_run_is_printed(exploring, report):
    summary = {**report.summary, "files": {"report": "runs/block/report.html"}}
    done = exploring(lambda options, progress: summary, "block")
    assert done.exit_code == 0
    for word in ("13 touches", "cylinder", "45.01 x 125.70", "surface rms 0.031", "runs/block/report.html"):
        assert word in done.stdout


def test_a_run_that_a_fault_ended_is_told_and_is_no_success(exploring, report):
    summary = {**report.summary, "closed": False, "ended": "fault: the stage does not answer; plug it in"}
    done = exploring(lambda options, progress: summary, "block", "--json")
    assert done.exit_code == 1
    assert json.loads(done.stdout)["ended"] == summary["ended"]
    assert "the stage does not answer; plug it in" in done.stderr
    assert done.stderr.count("\n") == 1


def test_a_bug_is_one_line_that_says_where_its_details_are(tmp_path):
    script = """
import sys, recognition.builtin, recognition.cli
def broken(): raise ValueError("no such thing")
recognition.builtin.part_rows = broken
sys.argv = ["palpate", "parts"]
recognition.cli.main()
"""
    done = subprocess.run(
        [sys.executable, "-c", script],
        capture_output=True,
        text=True,
        env={**os.environ, "TMPDIR": str(tmp_path)},
        timeout=60,
    )
    assert done.returncode == 1
    assert done.stderr.count("\n") == 1
    assert "bug in palpate" in done.stderr
    assert "ValueError: no such thing" in (tmp_path / "palpate-bug.txt").read_text()


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="left out: no /dev/full here")
@pytest.mark.parametrize("arguments", [["--help"], ["parts"], ["sensors", "--json"]])
def test_a_result_that_cannot_be_printed_is_one_line(arguments):
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-m", "recognition.cli", *arguments],
            stdout=full, stderr=subprocess.PIPE, text=True, timeout=60,
        )  # fmt: skip
    assert done.returncode == 1
    assert (
        done.stderr
        == "palpate: cannot print the result (No space left on device); send standard output elsewhere\n"
    )


@pytest.mark.skipif(os.name == "nt", reason="left out: needs a shell that closes files")
def test_a_closed_output_is_one_line():
    script = f"{sys.executable} -m recognition.cli parts >&-"
    done = subprocess.run(["sh", "-c", script], stderr=subprocess.PIPE, text=True, timeout=60)
    assert done.returncode == 1
    assert done.stderr == "palpate: standard output is closed; send it to a file or to /dev/null\n"


def test_a_file_that_is_not_there_is_said_before_anything_heavy_is_loaded(tmp_path):
    script = """
import sys, recognition.cli
sys.argv = ["palpate", "explore", "absent.stl"]
try:
    recognition.cli.main()
finally:
    print(sorted({"trimesh", "manifold3d", "networkx"} & set(sys.modules)))
"""
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, cwd=tmp_path)
    assert done.stderr == "palpate: no file absent.stl; check the path\n"
    assert done.stdout.strip() == "[]"


@pytest.mark.slow
@pytest.mark.skipif(os.name == "nt", reason="left out: Windows has no such signals")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_a_kill_ends_a_run_in_one_line_and_leaves_a_recording_that_reads_to_its_end(number, code, tmp_path):
    run = subprocess.Popen(
        [sys.executable, "-m", "recognition.cli", "explore", "block", "--out", "run", "--max-touches", "500"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=tmp_path,
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # a shell's background jobs ignore it
    )  # fmt: skip
    recording = tmp_path / "run" / "episode.mcap"
    while run.poll() is None and not (recording.exists() and recording.stat().st_size > 100_000):
        time.sleep(0.01)
    run.send_signal(number)
    out, err = run.communicate(timeout=60)
    assert (run.returncode, out) == (code, "")
    assert err.splitlines()[-1] == "palpate: interrupted; what was recorded until then is whole"
    assert {entry.name for entry in recording.parent.iterdir()} == {"config.toml", "episode.mcap"}
    assert recording.read_bytes().endswith(b"\x89MCAP0\r\n")
    assert sum(1 for _ in read(recording)) > 100
