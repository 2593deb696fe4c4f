"""The wheel holds all that the packages need, and works where there is no checkout."""

import json
import os
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = ("primitives", "models", "exploration", "recognition")
WITH = {".py", ".toml", ".html", ".css", ".js", ".typed"}


@pytest.fixture(scope="module")
def unpacked(tmp_path_factory):
    pytest.importorskip("build", reason="left out: build is not installed (palpate[dev])")
    room = tmp_path_factory.mktemp("wheel")
    copy = room / "source"
    tracked = subprocess.run(
        ["git", "ls-files", "README.md", "LICENSE", "pyproject.toml", *PACKAGES],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    if tracked.returncode:
        pytest.skip("left out: this is no git checkout")
    for name in filter(None, tracked.stdout.splitlines()):
        (copy / name).parent.mkdir(parents=True, exist_ok=True)
        (copy / name).write_bytes((ROOT / name).read_bytes())
    command = [sys.executable, "-m", "build", "--wheel", "--outdir", room / "dist", copy]
    built = subprocess.run(command, capture_output=True, text=True)
    if "Could not find a version" in built.stdout + built.stderr:
        pytest.skip("left out: setuptools cannot be had here")
    assert built.returncode == 0, built.stdout + built.stderr
    (wheel,) = (room / "dist").glob("*.whl")
    zipfile.ZipFile(wheel).extractall(room / "unpacked")
    return room / "unpacked"


@pytest.mark.slow
def test_the_wheel_holds_every_module_and_every_file_that_modules_read(unpacked):
    source = unpacked.parent / "source"
    wanted = {
        path.relative_to(source)
        for package in PACKAGES
        for path in (source / package).rglob("*")
        if path.suffix in WITH or path.name == "py.typed"
    }
    there = {path.relative_to(unpacked) for path in unpacked.rglob("*") if path.is_file()}
    assert wanted - there == set()
    assert len([path for path in wanted if path.suffix == ".toml"]) >= 10


@pytest.mark.slow
@pytest.mark.parametrize(("command", "name"), [("parts", "bracket"), ("sensors", "lts210")])
def test_parts_and_arrays_are_inside(unpacked, tmp_path, command, name):
    done = subprocess.run(
        [sys.executable, "-m", "recognition.cli", command, "--json"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": str(unpacked)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert name in json.dumps(json.loads(done.stdout))
    where = [sys.executable, "-c", "import recognition; print(recognition.__file__)"]
    env = {**os.environ, "PYTHONPATH": str(unpacked)}
    found = subprocess.run(where, cwd=tmp_path, env=env, capture_output=True, text=True).stdout
    assert str(unpacked) in found
