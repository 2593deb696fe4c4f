"""What the README says holds: its commands run, its files are there, its table names every dependency."""

import json
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
LINES = [
    line.partition("#")[0].strip()
    for block in re.findall(r"```sh\n(.*?)```", README, re.DOTALL)
    for line in block.splitlines()
]


COMMANDS = [line for line in LINES if line.startswith("palpate ")]
ON_A_RUN = [line for line in COMMANDS if "explore block" in line or "runs/block" in line]


@pytest.mark.slow
@pytest.mark.parametrize("lines", [ON_A_RUN, [line for line in COMMANDS if line not in ON_A_RUN]])
def test_the_commands_of_the_readme_run_one_after_another(lines, tmp_path):
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for line in lines:
        done = subprocess.run(
            line.split(),
            cwd=tmp_path,
            env={**os.environ, "PATH": path},
            capture_output=True,
            text=True,
            timeout=300,
        )
        assert done.returncode == 0, f"{line}: {done.stderr}"
        assert done.stdout, line
    explored = [line.split()[2] for line in lines if "explore" in line]
    assert explored
    for part in explored:
        assert (tmp_path / "runs" / part / "report.html").exists()
        assert json.loads((tmp_path / "runs" / part / "summary.json").read_text())["closed"]


@pytest.mark.parametrize("line", [line for line in LINES if line.startswith("make ")])
def test_every_target_of_the_readme_exists(line):
    assert re.search(rf"^{line.split()[1]}:", (ROOT / "Makefile").read_text(), re.MULTILINE)


@pytest.mark.parametrize("block", re.findall(r"```python\n(.*?)```", README, re.DOTALL))
def test_the_python_of_the_readme_runs(block):
    subprocess.run([sys.executable, "-c", block], check=True, cwd=ROOT.parent)


def test_every_file_of_the_readme_is_there():
    named = re.findall(r"`((?:primitives|models|exploration|recognition|tests|\.ci)/[\w./]*)`", README)
    assert len(named) > 8
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_the_dependency_table_is_complete():
    declared = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["dependencies"]
    table = README[README.index("## Dependencies") :]
    rows = {
        name.strip() for row in re.findall(r"^\| (.*?) \|", table, re.MULTILINE) for name in row.split(",")
    }
    assert {re.match(r"[\w-]+", line).group() for line in declared} <= rows
