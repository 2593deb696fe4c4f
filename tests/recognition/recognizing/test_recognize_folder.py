"""Recognizing from files, in a folder where not every file can be read."""

import numpy as np
import pytest
from typer.testing import CliRunner

from models import parts
from models.csg import Cube
from models.formats.openscad.writer import write
from models.library import Library
from models.solid import Solid
from primitives.errors import PalpateError
from primitives.evidence import Contacts
from primitives.pose import pose
from recognition import cli
from recognition.matching import Belief, Evidence, Hypothesis
from recognition.recognizing.answer import objects, other_unit, warnings_of, why
from recognition.recognizing.run import Asked, locate, recognize
from recognition.recognizing.text import summary_text


def test_a_file_that_is_left_out_is_told(tmp_path):
    write(parts.build("wedge"), tmp_path / "wedge.csg")
    (tmp_path / "broken.stl").write_text("garbage")
    rows = ["x,y,z,nx,ny,nz", *(f"{x},{y},0,0,0,1" for x in (0, 5, 10) for y in (0, 4))]
    source = tmp_path / "contacts.txt"
    source.write_text("\n".join(rows))
    answer = recognize(Asked(str(source), sigma=0.1), tmp_path, "auto", 1.0)
    assert any("broken.stl is left out" in warning for warning in answer["warnings"])
    told = {c["name"]: c["probability"] for c in answer["candidates"]}
    assert np.isclose(sum(told.values()), 1.0, atol=1e-3)
    assert told["unknown"] == answer["unknown"]


def test_none_of_these_is_the_first_candidate_where_it_is_decided_for(tmp_path):
    belief = Belief((), {"wedge": 0.3, "unknown": 0.7})
    told = objects(belief, {})
    assert told[0]["name"] == "unknown"
    assert told[0]["probability"] == 0.7
    said = {"decision": "unknown", "confidence": 0.7, "contacts": 9, "wall_seconds": 0.1, "warnings": []}
    told = told[:1]
    assert "unknown" in summary_text({**said, "candidates": told, "why": why(belief)}).splitlines()[-1]


def test_twins_that_share_more_than_an_unknown_object_has_are_named(tmp_path):
    evidence = Evidence(Contacts.of([[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0]], 0.1))
    shared = {"unknown": 0.44, "bracket": 0.26, "bored": 0.3}
    assert "56 % together, bored and bracket" in warnings_of(Belief((), shared), evidence)[0]
    alone = {"unknown": 0.54, "bracket": 0.26, "bored": 0.2}
    assert "together" not in warnings_of(Belief((), alone), evidence)[0]


@pytest.mark.parametrize(
    ("told", "said"),
    [
        *(({"sigma": sigma}, "positive length in mm") for sigma in (-1.0, 0.0, float("nan"))),
        *(({"radius": radius}, "--prior-radius") for radius in (0.0, -5.0, float("inf"))),
        ({"seed": -1}, "--seed"),
    ],
)
def test_lengths_that_are_none_are_refused(told, said):
    with pytest.raises(PalpateError, match=said):
        Asked("contacts.csv", **told)


@pytest.mark.parametrize("text", ["-1", "0", "nan", "inf", "wide"])
@pytest.mark.parametrize(
    "command",
    [["locate", "c.csv", "block"], ["recognize", "c.csv", "--library", "."], ["reconstruct", "c.csv"]],
)
def test_a_sigma_that_is_no_length_is_a_wrong_flag(command, text):
    told = CliRunner().invoke(cli.app, [*command, "--contact-sigma", text])
    assert told.exit_code == 2
    assert "auto or a positive length in mm" in told.stderr


def test_a_prior_without_extent_is_a_wrong_flag():
    assert CliRunner().invoke(cli.app, ["locate", "c.csv", "block", "--prior-radius", "0"]).exit_code == 2


def test_an_object_where_no_contact_can_be_of_it_is_an_error_and_not_unknown(tmp_path):
    write(parts.build("wedge"), tmp_path / "wedge.csg")
    source = tmp_path / "contacts.txt"
    source.write_text("\n".join(f"{x},{y},0,0,0,1" for x in (0, 5, 10) for y in (0, 4)))
    with pytest.raises(PalpateError, match="--prior-center"):
        recognize(Asked(str(source), center=(2000.0, 0.0, 0.0), radius=50.0), tmp_path, "auto", 1.0)


@pytest.mark.parametrize("source", ["", "blokc"])
def test_without_a_source_the_runs_that_are_there_are_listed(source, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    run = tmp_path / "runs" / "bolt"
    run.mkdir(parents=True)
    (run / "episode.mcap").write_bytes(b"")
    (run / "summary.json").write_text('{"part": "bolt", "touches": 7, "ended": "closed"}')
    told = CliRunner().invoke(cli.app, ["recognize", *([source] if source else [])])
    assert told.exit_code == 1
    assert told.stdout == ""
    assert "bolt" in told.stderr.splitlines()[-1]


def test_what_the_evidence_took_is_told_as_the_contract_says(tmp_path):
    (tmp_path / "contacts.csv").write_text("\n".join(f"{x},{y},0,0,0,1" for x in (0, 5, 10) for y in (0, 4)))
    (tmp_path / "summary.json").write_text('{"part": "block", "touches": 7, "travel_mm": 12.5}')
    told = locate(Asked(str(tmp_path)), "block", "auto", 1.0)
    assert (told["touches"], told["travel_mm"], told["history"]) == (7, 12.5, [])


def test_where_it_is_not_sure_it_says_which_touch_would_tell(tmp_path):
    write(parts.build("block"), tmp_path / "block.csg")
    write(parts.build("wedge"), tmp_path / "wedge.csg")
    source = tmp_path / "contacts.csv"
    source.write_text("x,y,z,nx,ny,nz\n0,0,0,0,0,1\n8,0,0,0,0,1\n0,9,0,0,0,1\n")
    answer = recognize(Asked(str(source), sigma=0.1), tmp_path, "auto", 1.0)
    assert answer["confidence"] < 0.95
    assert answer["why"]["separating_touch"]["bits"] > 0.1
    assert "a touch that would tell more" in summary_text(answer)


def test_a_pose_among_others_as_probable_is_told_as_unsure(tmp_path):
    write(parts.build("bracket"), tmp_path / "bracket.csg")
    library = Library.open(tmp_path)
    here, there = np.eye(4), pose(np.diag([1.0, -1.0, -1.0]), [30.0, 0.0, 0.0])
    sharp = [
        Hypothesis("bracket", at, np.log(0.5), 1e-4 * np.eye(6), 0.0, np.zeros(1)) for at in (here, there)
    ]
    belief = Belief(tuple(sharp), {"bracket": 1.0})
    told = objects(belief, library)[0]["pose_sigma"]
    assert told["translation_mm"] > 10.0
    assert told["rotation_deg"] > 90.0
    alone = objects(Belief((sharp[0],), {"bracket": 1.0}), library)[0]["pose_sigma"]
    assert alone["rotation_deg"] < 2.0


@pytest.mark.parametrize(("scale", "warned"), [(1.0, False), (1.0 / 25.4, True), (1e-3, True)])
def test_contacts_in_another_unit_are_told_from_contacts_in_mm(scale, warned):
    cube = Library.of({"cube": Solid.from_csg(Cube((60.0, 40.0, 30.0)))})
    corners = np.array([[x, y, z] for x in (-30.0, 30.0) for y in (-20.0, 20.0) for z in (-15.0, 15.0)])
    said = other_unit(Evidence(Contacts.of(scale * corners)), cube, ["cube"])
    assert bool(said) == warned
    assert not other_unit(Evidence(Contacts.of(scale * corners[:4])), cube, ["cube"])


def test_contacts_of_one_face_alone_are_told_where_they_leave_it_open():
    rng = np.random.default_rng(0)
    flat = np.column_stack([rng.uniform(-20, 20, (12, 2)), np.zeros(12)])
    doubtful, sure = (Belief((), {"bored": p, "bracket": 1.0 - p}) for p in (0.6, 0.99))
    for normals in (None, np.tile([0.0, 0.0, 1.0], (12, 1))):
        evidence = Evidence(Contacts.of(flat, normals, 0.3))
        assert sum("one flat face" in line for line in warnings_of(doubtful, evidence)) == 1
        assert not any("one flat face" in line for line in warnings_of(sure, evidence))
    solid = Evidence(Contacts.of(flat + rng.normal(size=(12, 3)) * [0, 0, 15.0], None, 0.3))
    assert not any("one flat face" in line for line in warnings_of(doubtful, solid))
    turn = rng.uniform(0.0, 3.0, 12)
    normals = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(12)])
    rod = Evidence(Contacts.of(15.0 * normals + flat[:, :1] * [0.0, 0.0, 1.0], normals, 0.3, 0.04))
    assert sum("one round face" in line for line in warnings_of(doubtful, rod)) == 1
