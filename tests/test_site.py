"""The documentation: its page of commands is what commands say, its links and pictures are sound."""

import importlib.util
import re
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
