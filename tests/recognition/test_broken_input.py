"""Whatever is wrong with a CAD file, the command says so in one line and leaves nothing behind."""

import os
import struct
import subprocess
import sys
from typing import NamedTuple

import numpy as np
import pytest
from typer.testing import CliRunner

from recognition.cli import app


class Result(NamedTuple):
    exit_code: int
    stdout: str
    stderr: str


TETRAHEDRON = np.array([[0, 0, 0], [20, 0, 0], [0, 20, 0], [0, 0, 20]], dtype=float)
TRIANGLES = [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]

TWO = [*TRIANGLES, *(tuple(i + 4 for i in corners) for corners in TRIANGLES)]


def binary_stl(points, triangles, announced=None):
    body = b"".join(
        struct.pack("<12fH", 0, 0, 0, *np.asarray(points)[list(corners)].ravel(), 0) for corners in triangles
    )
    return bytes(80) + struct.pack("<I", len(triangles) if announced is None else announced) + body


def obj(points, triangles):
    lines = [f"v {x} {y} {z}" for x, y, z in points] + [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in triangles]
    return "\n".join(lines).encode()


def off(points, triangles):
    lines = ["OFF", f"{len(points)} {len(triangles)} 0"]
    lines += [f"{x} {y} {z}" for x, y, z in points] + [f"3 {a} {b} {c}" for a, b, c in triangles]
    return "\n".join(lines).encode()


def with_a_nan():
    points = TETRAHEDRON.copy()
    points[3, 2] = np.nan
    return points


NOISE = np.random.default_rng(0).bytes(4000)
WHOLE = binary_stl(TETRAHEDRON, TRIANGLES)
BROKEN = {
    "empty.stl": b"",
    "blank.obj": b"  \n\n \n",
    "truncated.stl": WHOLE[:-30],
    "header_only.stl": WHOLE[:84],
    "announces_too_much.stl": binary_stl(TETRAHEDRON, TRIANGLES, announced=2_000_000_000),
    "cut_in_the_middle.stl": b"solid a\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n",
    "nan.stl": binary_stl(with_a_nan(), TRIANGLES),
    "nan.off": off(with_a_nan(), TRIANGLES),
    "infinite.obj": obj(TETRAHEDRON + np.inf, TRIANGLES),
    "one_triangle.stl": binary_stl(TETRAHEDRON, TRIANGLES[:1]),
    "two_faces_missing.off": off(TETRAHEDRON, TRIANGLES[:2]),
    "two_bodies.off": off(np.concatenate([TETRAHEDRON, TETRAHEDRON + 50]), TWO),
    "garbage.step": b"ISO-10303-21;\n" + b"garbage " * 100,
    "noise.3mf": b"PK\3\4" + NOISE,
    "without_area.obj": obj(TETRAHEDRON * [1, 0, 0], TRIANGLES),
    "corner_that_is_not_there.obj": obj(TETRAHEDRON[:3], TRIANGLES),
    "corner_that_is_not_there.off": off(TETRAHEDRON[:3], TRIANGLES),
    "noise.stl": NOISE,
    "noise.obj": NOISE,
    "noise.ply": NOISE,
    "noise.off": NOISE,
    "noise.glb": NOISE,
    "header_only.ply": b"ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\n",
    "truncated.glb": b"glTF" + struct.pack("<II", 2, 5000) + b"{}",
    "an_stl_inside.ply": b"solid a\nfacet normal 0 0 1\nouter loop\nendloop\nendfacet\nendsolid a\n",
    "picture.png": b"\x89PNG\r\n\x1a\n" + NOISE,
    "no_extension": WHOLE,
    "small_as_a_molecule.stl": binary_stl(TETRAHEDRON * 1e-6, TRIANGLES),
    "large_as_a_city.stl": binary_stl(TETRAHEDRON * 1e5, TRIANGLES),
    "larger_than_the_workspace.stl": binary_stl(TETRAHEDRON * 100, TRIANGLES),
}


@pytest.fixture
def explore(tmp_path, monkeypatch):
    """The command in this process, which spares starting Python for each file."""
    monkeypatch.chdir(tmp_path)
    return lambda *given: CliRunner().invoke(app, ["explore", *given])


def started(part, cwd):
    done = subprocess.run(
        [sys.executable, "-m", "recognition.cli", "explore", str(part)],
        capture_output=True,
        text=True,
        cwd=cwd,
        timeout=60,
    )
    return Result(done.returncode, done.stdout, done.stderr)


def is_one_line_and_nothing_else(done, cwd, before):
    assert done.exit_code == 1
    assert done.stdout == ""
    assert done.stderr.startswith("palpate: ")
    assert done.stderr.count("\n") == 1, done.stderr
    assert sorted(entry.name for entry in cwd.rglob("*")) == before
    return True


@pytest.mark.parametrize("name", BROKEN)
def test_a_broken_file_is_one_line(name, tmp_path, explore):
    (tmp_path / name).write_bytes(BROKEN[name])
    done = explore(name if "." in name else f"./{name}")
    assert is_one_line_and_nothing_else(done, tmp_path, [name])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["empty.stl", "garbage.step", "two_bodies.off"])
def test_the_command_in_a_process_of_its_own_says_the_same(name, tmp_path):
    (tmp_path / name).write_bytes(BROKEN[name])
    assert is_one_line_and_nothing_else(started(name, tmp_path), tmp_path, [name])


def test_a_folder_is_one_line(tmp_path, explore):
    (tmp_path / "part.stl").mkdir()
    assert is_one_line_and_nothing_else(explore("part.stl"), tmp_path, ["part.stl"])


def test_a_link_to_nothing_is_one_line(tmp_path, explore):
    (tmp_path / "part.stl").symlink_to(tmp_path / "gone.stl")
    assert is_one_line_and_nothing_else(explore("part.stl"), tmp_path, ["part.stl"])


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="left out: no named pipes here")
def test_a_pipe_that_never_answers_is_one_line(tmp_path):
    os.mkfifo(tmp_path / "part.stl")
    assert is_one_line_and_nothing_else(started("part.stl", tmp_path), tmp_path, ["part.stl"])


@pytest.mark.skipif(
    not hasattr(os, "geteuid") or os.geteuid() == 0, reason="left out: this user may read every file"
)
def test_a_file_that_may_not_be_read_is_one_line(tmp_path, explore):
    (tmp_path / "part.stl").write_bytes(WHOLE)
    (tmp_path / "part.stl").chmod(0)
    assert is_one_line_and_nothing_else(explore("part.stl"), tmp_path, ["part.stl"])


def test_one_sensor_twice_is_one_line(tmp_path, explore):
    assert is_one_line_and_nothing_else(explore("block", "--sensor", "lts210,lts210"), tmp_path, [])
