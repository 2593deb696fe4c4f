"""Every block of code in the README and on the pages under docs does what it shows, and none is left out.

What a reader puts in for a placeholder (DIR, FOLDER, HOST, a file of one's own) is put in here; all else runs as
it is written.  The four that take a minute each run with `make test-all`.
"""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest
import trimesh
from pyarrow.parquet import read_table

ROOT = Path(__file__).parents[1]
DOCS = ROOT / "docs"
PAGES = {path.stem: path for path in (ROOT / "README.md", *sorted(DOCS.glob("*.md")))}
DRAWN = "text"  # the language of pictures and equations, which are no code
TESTED = {
    ("README", "sh"): "test_the_commands_of_the_readme_run_one_after_another",
    ("README", "console"): "test_the_commands_of_the_readme_run_one_after_another",
    ("README", "python"): "test_the_python_of_a_page_runs_from_top_to_bottom",
    ("environments", "python"): "test_the_python_of_a_page_runs_from_top_to_bottom",
    ("experiments", "toml"): "test_the_suite_of_the_page_runs_in_every_way_that_it_shows",
    ("experiments", "console"): "test_the_suite_of_the_page_runs_in_every_way_that_it_shows",
    ("experiments", "sh"): "test_the_job_of_the_page_is_a_shard",
    ("extending", "python"): "test_the_python_of_a_page_runs_from_top_to_bottom",
    ("extending", "toml"): "test_the_file_of_a_page_is_taken",
    ("hardware", "console"): "test_the_emulated_rig_of_the_page_is_explored",
    ("hardware", "cpp"): "test_hardware_page.py",
    ("hardware", "python"): "test_hardware_page.py",
    ("index", "console"): "test_ten_minutes_lead_from_a_file_of_ones_own_to_its_name",
    ("openscad", "openscad"): "test_the_drawing_of_the_page_is_read_with_its_names",
    ("openscad", "python"): "test_the_python_of_a_page_runs_from_top_to_bottom",
    ("procedures", "toml"): "test_the_file_of_a_page_is_taken",
    ("python", "python"): "test_the_python_of_a_page_runs_from_top_to_bottom",
    ("sensors", "python"): "test_sensor_page.py",
}
PATIENCE = 600.0  # [s] for one command on a busy machine


def blocks(page: str, language: str) -> list[str]:
    """The texts of a page's blocks in a language."""
    text = PAGES[page].read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


def commands(page: str, language: str, first: str = "palpate") -> list[str]:
    lines = [line for block in blocks(page, language) for line in block.splitlines()]
    told = [line.split(" #")[0].strip() for line in lines]
    return [line for line in told if line.startswith(f"{first} ")]


def tagged() -> list[tuple[str, str]]:
    """Page and language of every block."""
    return [
        (page, language)
        for page, path in PAGES.items()
        for language in re.findall(
            r"^```(\w*)\n.*?^```$", path.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE
        )
    ]


@pytest.fixture
def desk(tmp_path):
    """An empty folder to work in, and how to run a line there."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"

    def run(line: str, **more: str) -> str:
        done = subprocess.run(
            ["sh", "-c", line],
            cwd=tmp_path,
            env={**os.environ, "PATH": path, "HOME": str(tmp_path), **more},
            capture_output=True,
            text=True,
            timeout=PATIENCE,
        )
        assert done.returncode == 0, f"{line}: {done.stderr}"
        assert done.stdout, line
        return done.stdout

    run.folder = tmp_path
    return run


def write_step_box(path: Path, size: tuple[float, float, float]) -> None:
    spec = importlib.util.spec_from_file_location("step_text", ROOT / "tests/models/formats/conftest.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    step = module.StepText("mm")
    step.shell(module.box_faces(step, size))
    path.write_text(step.text())


def write_stl(path: Path, size: tuple[float, float, float]) -> None:
    trimesh.creation.box(size).export(path)


def test_no_block_is_without_a_test():
    assert {block for block in tagged() if block[1] != DRAWN} == set(TESTED)
    for name in TESTED.values():
        assert name in globals() or (ROOT / "tests" / name).exists()
    for path in PAGES.values():
        indented = re.findall(r"^(?: {4}|\t)\$? ?palpate .*", path.read_text(encoding="utf-8"), re.MULTILINE)
        assert indented == [], f"{path.name}: a command outside any block"


WITH_PYTHON = [page for (page, language), name in TESTED.items() if name.startswith("test_the_python")]


@pytest.mark.slow
@pytest.mark.parametrize("page", WITH_PYTHON)
def test_the_python_of_a_page_runs_from_top_to_bottom(page, tmp_path):
    if page == "environments":
        pytest.importorskip("gymnasium", reason="left out: gymnasium is not installed (palpate[gym])")
    (tmp_path / "flange.scad").write_bytes((DOCS / "library" / "flange.csg").read_bytes())
    command = [sys.executable, "-c", "\n".join(blocks(page, "python"))]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_the_commands_of_the_readme_run_one_after_another(desk):
    for line in commands("README", "sh"):
        desk(line)
    for part in ("block", "sphere"):
        assert (desk.folder / "runs" / part / "report.html").exists()
        assert '"closed": true' in (desk.folder / "runs" / part / "summary.json").read_text()
    shutil.copytree(DOCS / "library", desk.folder / "DIR")
    shutil.copy(desk.folder / "runs" / "block" / "contacts.csv", desk.folder)
    write_step_box(desk.folder / "part.step", (60.0, 40.0, 12.0))
    write_stl(desk.folder / "part.stl", (36.0, 30.0, 24.0))
    said = {line: desk(line) for line in commands("README", "console") if " experiment " not in line}
    assert any("block" in text for line, text in said.items() if line.startswith("palpate recognize"))
    assert any("bracket" in text for line, text in said.items() if line.startswith("palpate identify"))


@pytest.mark.long
def test_the_suite_of_the_readme_makes_a_table(desk):
    shutil.copytree(DOCS / "suites", desk.folder / "docs" / "suites")
    (line,) = [line for line in commands("README", "console") if " experiment " in line]
    desk(line)
    assert (desk.folder / "smoke" / "results.parquet").exists()


@pytest.mark.parametrize("line", [*commands("README", "sh", "make"), *commands("index", "console", "make")])
def test_every_make_that_a_page_begins_with_is_run_before_anything_is_released(line):
    assert re.search(rf"^{line.split()[1]}:", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert line in (ROOT / ".ci" / "run").read_text().splitlines()


@pytest.mark.long
def test_ten_minutes_lead_from_a_file_of_ones_own_to_its_name(desk):
    shutil.copytree(DOCS / "library", desk.folder / "FOLDER")
    write_stl(desk.folder / "part.stl", (70.0, 50.0, 30.0))
    shutil.copy(desk.folder / "part.stl", desk.folder / "FOLDER")
    told = [desk(line) for line in commands("index", "console")]
    assert len(told) == 3
    assert all("part" in text for text in told)
    assert (desk.folder / "runs" / "part" / "model.csg").exists()


@pytest.mark.long
def test_the_suite_of_the_page_runs_in_every_way_that_it_shows(desk):
    (suite,) = blocks("experiments", "toml")
    (desk.folder / "noise.toml").write_text(suite.replace('"sphere", ', ""))  # a part of one's own is enough
    (desk.folder / "my_parts").mkdir()
    write_stl(desk.folder / "my_parts" / "mine.stl", (40.0, 40.0, 40.0))
    lines = commands("experiments", "console")
    assert len(lines) == 4
    for line in lines:
        if "--scheduler" not in line:
            desk(line)
    rows = (desk.folder / "noise" / "trials.jsonl").read_text().splitlines(keepends=True)
    assert sum('"outcome": "done"' in row for row in rows) == len(rows) == 2
    distributed = pytest.importorskip("distributed", reason="left out: no distributed (palpate[cluster])")
    shutil.copytree(desk.folder / "noise", desk.folder / "again")
    (desk.folder / "again" / "trials.jsonl").write_text(rows[0])  # the last is done again
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, dashboard_address=None, host="127.0.0.1"
    ) as cluster:
        (line,) = [line for line in lines if "--scheduler" in line]
        told = line.replace("tcp://HOST:8786", cluster.scheduler_address)
        desk(told.replace("--out noise", "--out again --resume"))
    one, other = (read_table(desk.folder / name / "results.parquet") for name in ("noise", "again"))
    same = [name for name in one.column_names if not name.endswith("_seconds")]
    assert one.select(same).equals(other.select(same))


@pytest.mark.slow
def test_the_job_of_the_page_is_a_shard(desk):
    (desk.folder / "suite.toml").write_text(
        'name = "few"\n[[trials]]\nkind = "frames"\ncount = 2\nseeds = 16\n'
    )
    (script,) = blocks("experiments", "sh")
    desk(script, SCRATCH=str(desk.folder), SLURM_ARRAY_TASK_ID="3")
    assert (desk.folder / "suite" / "trials-3-of-16.jsonl").read_text().count("\n") == 1


@pytest.mark.slow
@pytest.mark.parametrize(
    ("page", "command"),
    [
        ("extending", "palpate track surface block --sensor told.toml --overwrite"),
        ("procedures", "palpate probe block hardness --material told.toml"),
    ],
)
def test_the_file_of_a_page_is_taken(page, command, desk):
    (text,) = blocks(page, "toml")
    (desk.folder / "told.toml").write_text(text)
    desk(command)


def test_the_drawing_of_the_page_is_read_with_its_names(tmp_path):
    from models.formats import openscad

    text, _ = blocks("openscad", "openscad")
    (tmp_path / "bracket.csg").write_text(text)
    drawing = openscad.read(tmp_path / "bracket.csg")
    assert drawing.tree.name == "bracket"
    openscad.write(drawing.tree, tmp_path / "again.csg")
    assert "// hole" in (tmp_path / "again.csg").read_text()


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="left out: no pseudo-terminals here")
def test_the_emulated_rig_of_the_page_is_explored(desk):
    serve, *others = commands("hardware", "console")
    env = {**os.environ, "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    quiet = {"cwd": desk.folder, "env": env, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    with subprocess.Popen(serve.split(), **quiet) as emulator:
        try:
            until(lambda: (desk.folder / "emulated.toml").exists())
            for line in others[:-1]:
                desk(line)
            with subprocess.Popen(
                others[-1].split(), **quiet
            ) as explorer:  # minutes: its beginning is enough
                until(lambda: (desk.folder / "run" / "episode.mcap").exists())
                time.sleep(5.0)
                explorer.terminate()
                assert explorer.wait(PATIENCE) == 143
        finally:
            emulator.terminate()
    assert (desk.folder / "run" / "episode.mcap").stat().st_size > 10_000


def until(there) -> None:
    end = time.monotonic() + PATIENCE
    while not there():
        assert time.monotonic() < end
        time.sleep(0.1)
