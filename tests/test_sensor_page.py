"""The page on sensors does what it shows: its Python runs, from top to bottom."""

import re
from pathlib import Path

from exploration.sensing.calibration import Calibration
from exploration.sensing.response import Response

PAGE = (Path(__file__).parents[1] / "docs" / "sensors.md").read_text(encoding="utf-8")


def test_every_snippet_of_the_sensor_page_runs_and_free_air_shows_no_line():
    blocks = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    assert len(blocks) >= 5
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, "sensors.md", "exec"), names)
    assert isinstance(names["calibration"], Calibration)
    assert isinstance(names["response"], Response)
    assert names["lines"] == ()


def test_every_file_that_the_page_names_is_there():
    named = re.findall(r"`(exploration/[\w/]+\.py)`", PAGE)
    assert named
    assert all((Path(__file__).parents[1] / name).exists() for name in named)
