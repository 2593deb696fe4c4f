"""The documentation: its page of commands is what commands say, its Python runs, it builds without a warning."""

import importlib.util
import re
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

DOCS = Path(__file__).parents[1] / "docs"
PAGES = sorted(DOCS.glob("*.md"))


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("make_pages", DOCS / "site" / "make_pages.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_of_commands_has_every_command_and_flag(script):
    page, made = (DOCS / "commands.md").read_text(encoding="utf-8"), script.commands_page()
    for pattern in (r"^## .*", r"^\| `[^ `]*"):
        assert re.findall(pattern, page, re.MULTILINE) == re.findall(pattern, made, re.MULTILINE), (
            "run make docs"
        )


def test_every_page_is_in_the_contents():
    listed = re.findall(r": (\w+\.md)$", (DOCS / "site" / "mkdocs.yml").read_text(), re.MULTILINE)
    assert sorted(listed) == [page.name for page in PAGES]


def test_every_link_leads_somewhere():
    for page in PAGES:
        for link in re.findall(r"\]\(([^)#\s]+)", page.read_text(encoding="utf-8")):
            assert link.startswith("http") or (page.parent / link).exists(), f"{page.name}: {link}"


def test_pictures_are_sound():
    for path in (DOCS / "pictures").glob("*.svg"):
        assert len(list(ElementTree.parse(path).getroot())) > 10


def test_the_suites_that_are_listed_are_there():
    told = (DOCS / "experiments.md").read_text(encoding="utf-8")
    table = told[told.index("## Ready suites") : told.index("## What comes")]
    listed = {
        name for row in table.splitlines() if row.startswith("| `") for name in re.findall(r"`(\w+)`", row)
    }
    assert listed == {path.stem for path in (DOCS / "suites").glob("*.toml")}


ELSEWHERE = ("hardware", "sensors")  # pages whose Python test_hardware_page and test_sensor_page run
WITH_PYTHON = [p for p in PAGES if "```python" in p.read_text(encoding="utf-8") and p.stem not in ELSEWHERE]


@pytest.mark.slow
@pytest.mark.parametrize("page", WITH_PYTHON, ids=lambda page: page.stem)
def test_the_python_of_a_page_runs(page, tmp_path):
    if page.stem == "environments":
        pytest.importorskip("gymnasium", reason="left out: gymnasium is not installed (palpate[gym])")
    (tmp_path / "flange.scad").write_bytes((DOCS / "library" / "flange.csg").read_bytes())
    blocks = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)
    command = [sys.executable, "-c", "\n".join(blocks)]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr


@pytest.mark.slow
def test_the_site_builds_without_a_warning(tmp_path):
    pytest.importorskip("material", reason="left out: mkdocs-material is not installed (palpate[docs])")
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--strict", "--config-file"]
    done = subprocess.run(
        [*command, str(DOCS / "site" / "mkdocs.yml"), "--site-dir", str(tmp_path / "site")],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "site" / "commands.html").exists()
