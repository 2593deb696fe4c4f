"""`palpate probe`: what it refuses, and one whole run against the material that the object has."""

import csv
import json
import tomllib

import pytest
from typer.testing import CliRunner

from exploration.control.procedures.catalog import CANNOT, PROCEDURES
from exploration.recordings.mcap import RecordedEvent, RecordedFrame, read
from primitives.errors import PalpateError
from recognition.cli import app
from recognition.probing.felt import AT_REST, TRACKERS
from recognition.probing.options import ProbeOptions
from recognition.probing.run import run
from recognition.tracking.view import View

SMALL = (-80.0, -80.0, -80.0, 80.0, 80.0, 80.0)
FIELDS = {"command", "trace", "normals", "dihedral_deg", "closed", "lost", "force_n", "found", "truth"}


def probed(tmp_path, procedure, **more):
    options = ProbeOptions(
        "block", procedure=procedure, pose="as-is", workspace=SMALL, noise=0.05, out=tmp_path / "run", **more
    )
    return run(options, View())


def test_every_procedure_of_the_catalog_can_be_probed():
    assert {p.name for p in PROCEDURES} == set(AT_REST) | set(TRACKERS)
    assert all(p.serves for p in PROCEDURES)


@pytest.mark.parametrize("name", sorted(CANNOT))
def test_what_one_array_cannot_do_is_one_line_with_the_reason(name):
    told = CliRunner().invoke(app, ["probe", "block", name])
    assert told.exit_code == 1
    assert CANNOT[name] in told.output
    assert len(told.output.strip().splitlines()) == 1


def test_an_unknown_procedure_lists_those_that_there_are():
    told = CliRunner().invoke(app, ["probe", "block", "hardnes"])
    assert told.exit_code == 1
    assert "did you mean hardness?" in told.output.splitlines()[0]
    assert all(p.name in told.output for p in PROCEDURES)


def test_an_array_without_a_thermal_layer_is_refused_before_anything_is_written(tmp_path):
    with pytest.raises(PalpateError, match="no thermal layer"):
        probed(tmp_path, "thermal")
    assert not (tmp_path / "run").exists()


@pytest.mark.parametrize(
    ("flag", "value"), [("--stiffness", "-1"), ("--roughness-mm", "nan"), ("--force-n", "0")]
)
def test_a_material_that_cannot_be_is_refused(flag, value):
    told = CliRunner().invoke(app, ["probe", "block", "hardness", flag, value])
    assert told.exit_code in (1, 2)
    assert len(told.output.strip().splitlines()) == 1


@pytest.mark.slow
def test_hardness_of_one_face_is_felt_and_the_run_is_whole(tmp_path):
    material = tmp_path / "material.toml"
    material.write_text("stiffness_n_mm3 = 5.0\n[faces.5]\nstiffness_n_mm3 = 0.15\n")
    summary = probed(tmp_path, "hardness", material=str(material))
    assert set(summary) >= FIELDS
    assert summary["command"] == "probe"
    face = summary["truth"]["face"]
    assert summary["truth"]["stiffness_n_mm3"] == (0.15 if face == 5 else 5.0)
    if face == 5:
        assert summary["found"]["stiffness_n_mm3"] == pytest.approx(0.15, rel=0.1)
    assert 0.0 < summary["force_n"]["mean"] <= summary["force_n"]["rms"] <= summary["force_n"]["max"] < 60.0
    assert 19.0 < summary["latency_ms"] < 22.0
    folder = tmp_path / "run"
    assert json.loads((folder / "summary.json").read_text())["procedure"] == "hardness"
    assert tomllib.loads((folder / "config.toml").read_text())["command"] == "probe"
    assert len(list(csv.DictReader((folder / "contacts.csv").open()))) == len(summary["trace"])
    items = list(read(folder / "episode.mcap"))
    assert sum(isinstance(item, RecordedFrame) for item in items) == summary["frames"]
    assert any(isinstance(item, RecordedEvent) and item.kind == "found" for item in items)


@pytest.mark.slow
def test_the_same_seed_probes_the_same(tmp_path):
    first = probed(tmp_path, "compliance", stiffness_n_mm3=0.3)
    again = probed(tmp_path, "compliance", stiffness_n_mm3=0.3, overwrite=True)
    assert first["found"] == again["found"]
    assert first["found"]["object_mm"] == pytest.approx(20.0 / (0.3 * 518.4), rel=0.1)


@pytest.mark.slow
def test_a_face_too_short_along_the_pad_is_stroked_across(tmp_path):
    told = run(ProbeOptions("cube", procedure="texture", seed=2, out=tmp_path / "run"), View())
    assert told["found"]["stroke_mm"] > 8.0
