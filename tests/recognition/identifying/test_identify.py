"""Identifying on the simulated stage: what it decides, what it writes, and what it says."""

import json
from pathlib import Path

import numpy as np
import pytest

from exploration.planning.ways.round_ball import Ball
from models import parts
from models.library import Library
from models.solid import Solid
from primitives.errors import PalpateError
from recognition.identifying.options import IdentifyOptions
from recognition.identifying.policies import POLICY
from recognition.identifying.run import run
from recognition.identifying.text import summary_text

NAMES = ("block", "cylinder", "wedge", "stepped_block")


@pytest.fixture(scope="module")
def library() -> Library:
    return Library.of({name: Solid.from_csg(parts.build(name)) for name in NAMES})


@pytest.mark.slow
def test_an_object_of_the_library_is_named_and_placed(library: Library, tmp_path: Path) -> None:
    summary = run(IdentifyOptions("wedge", seed=1, out=tmp_path / "run", max_touches=20), library)
    assert summary["decision"] == "wedge"
    assert summary["truth"]["correct"]
    assert summary["truth"]["translation_error_mm"] < 5.0
    assert summary["history"][-1]["touch"] == summary["touches"]
    assert summary["history"][-1]["top"][0][0] == "wedge"
    assert summary["why"]["runner_up"] in (*NAMES, "unknown")
    present = {path.name for path in (tmp_path / "run").iterdir()}
    assert {"episode.mcap", "contacts.csv", "report.html", "summary.json", "config.toml"} <= present
    told = json.loads((tmp_path / "run" / "summary.json").read_text())
    assert told["command"] == "identify"
    assert "it is wedge" in summary_text(summary)


@pytest.mark.slow
def test_an_object_of_no_library_is_unknown(library: Library, tmp_path: Path) -> None:
    options = IdentifyOptions("hex_bar", seed=1, out=tmp_path / "run", max_touches=20)
    summary = run(options, library)
    assert summary["decision"] == "unknown"
    assert summary["truth"]["correct"]


@pytest.mark.slow
def test_where_nothing_was_met_the_prior_is_the_answer(library: Library, tmp_path: Path) -> None:
    options = IdentifyOptions(
        "block", pose=(250.0, 250.0, 250.0, 1.0, 0.0, 0.0, 0.0), max_touches=2, out=tmp_path / "run"
    )
    summary = run(options, library)
    assert summary["met"] == 0
    assert not summary["truth"]["correct"]  # the first of equal names is no answer
    told = {c["name"]: c["probability"] for c in summary["candidates"]}
    assert told == pytest.approx({**dict.fromkeys(NAMES, 0.225), "unknown": 0.1})
    assert summary["confidence"] == pytest.approx(told[summary["decision"]]) == max(told.values())
    bits = -sum(p * np.log2(p) for p in told.values())
    assert [step["entropy_bits"] for step in summary["history"]] == pytest.approx([bits] * 2)
    told = summary_text(summary)
    assert "nothing was met" in told
    assert "right" not in told  # a guess


def test_a_file_of_the_library_that_cannot_be_read_is_told(tmp_path: Path) -> None:
    folder = tmp_path / "library"
    folder.mkdir()
    (folder / "brick.csg").write_text("cube([60, 40, 20], center = true);\n")
    (folder / "bad.stl").write_text("no mesh\n")
    far = (250.0, 250.0, 250.0, 1.0, 0.0, 0.0, 0.0)
    options = IdentifyOptions("block", pose=far, max_touches=1, out=tmp_path / "run", library=folder)
    assert any(told.startswith("bad.stl is left out") for told in run(options)["warnings"])


@pytest.mark.parametrize("policy", sorted(POLICY))
def test_every_approach_of_a_policy_begins_outside_and_crosses_the_ball(policy: str) -> None:
    ball, rng = Ball(np.array([10.0, -20.0, 30.0]), 60.0), np.random.default_rng(0)
    for tried in range(20):
        approach = POLICY[policy](ball, rng.normal(size=(3, 3)) * 40.0, tried, rng)
        off = approach.start[:3, 3] - ball.center
        along = float(off @ approach.direction)
        assert -along > 0.0
        assert np.linalg.norm(off - along * approach.direction) < 2.5 * ball.radius
        assert approach.length > 0.5 * ball.radius


def test_a_wrong_policy_or_confidence_names_what_there_is() -> None:
    with pytest.raises(PalpateError, match="largest-gap"):
        IdentifyOptions("block", policy="clever")
    with pytest.raises(PalpateError, match="between 0 and 1"):
        IdentifyOptions("block", confidence=1.5)
