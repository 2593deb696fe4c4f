"""The pages under docs are those that `make docs` writes, and small."""

import importlib.util
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from models.parts import names

DOCS = Path(__file__).parents[1] / "docs"


@pytest.fixture(scope="module")
def script():
    spec = importlib.util.spec_from_file_location("draw_parts", DOCS / "draw_parts.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_of_parts_is_up_to_date(script):
    assert (DOCS / "parts.md").read_text(encoding="utf-8") == script.page()


def test_every_part_has_its_picture_and_there_is_no_other():
    assert {path.stem for path in (DOCS / "parts").iterdir()} == set(names())
    linked = re.findall(r'src="parts/(\w+)\.svg"', (DOCS / "parts.md").read_text(encoding="utf-8"))
    assert linked == list(names())


def test_pictures_are_sound_and_small():
    pictures = list((DOCS / "parts").glob("*.svg"))
    assert sum(path.stat().st_size for path in pictures) < 1_500_000
    for path in pictures:
        drawn = ElementTree.parse(path).getroot()
        assert len(drawn.findall(".//{*}path")) >= 2
