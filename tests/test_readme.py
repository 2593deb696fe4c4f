"""What the README says holds: its files are there, its table names every dependency."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


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
