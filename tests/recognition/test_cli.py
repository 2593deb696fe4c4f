import json
import subprocess
import sys
from types import SimpleNamespace

import pytest
from typer.testing import CliRunner

from recognition.cli import app
from recognition.config import ExploreOptions
from recognition.progress import Progress

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
def test_what_is_wrong_is_said_without_a_traceback_and_leaves_nothing(arguments, code, says, tmp_path):
    done = palpate(*arguments, cwd=tmp_path)
    assert done.returncode == code
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
    assert commands == ["explore", "parts", "sensors", "frames", "doctor", "library"]


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
