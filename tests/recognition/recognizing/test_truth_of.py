"""How right an answer is, of a run folder that knows what stood there."""

import json

import numpy as np
import pytest

from models import parts
from models.library import Library
from models.part import load_part
from models.solid import Solid
from primitives.arrays import frozen
from primitives.pose import pose, quaternion_wxyz, rotation_exp
from recognition.identifying.answer import truth_json
from recognition.matching import Belief, Hypothesis
from recognition.recognizing.truth import truth_of

WORLD = pose(rotation_exp([0.3, -0.2, 0.5]), [10.0, -20.0, 30.0])


@pytest.fixture(scope="module")
def library():
    return Library.of({name: Solid.from_csg(parts.build(name)) for name in ("block", "wedge")})


def _run(folder, part):
    told = {"translation_mm": WORLD[:3, 3].tolist(), "quaternion_wxyz": quaternion_wxyz(WORLD).tolist()}
    (folder / "summary.json").write_text(json.dumps({"part": part, "truth": {"world_from_part": told}}))
    return str(folder)


def _believed(name, at):
    h = Hypothesis(name, frozen(at), float(np.log(0.9)), frozen(np.eye(6)), 0.0, frozen(np.zeros(1)))
    return Belief((h,), {name: 0.9, "unknown": 0.1})


def test_a_right_name_is_measured_against_the_pose_that_was(library, tmp_path):
    off = WORLD @ pose(rotation_exp([0.0, 0.0, np.deg2rad(2.0)]), np.zeros(3))
    told = truth_of(_run(tmp_path, "wedge"), _believed("wedge", off), library)
    assert told["correct"]
    assert told["rotation_error_deg"] == pytest.approx(2.0, abs=1e-6)


def test_a_pose_that_symmetry_makes_the_same_is_no_error(library, tmp_path):
    turned = library["block"].symmetry.rotations[1]
    told = truth_of(_run(tmp_path, "block"), _believed("block", WORLD @ turned), library)
    assert told["rotation_error_deg"] == pytest.approx(0.0, abs=1e-4)
    assert told["translation_error_mm"] == pytest.approx(0.0, abs=1e-6)


def test_a_wrong_name_has_no_pose_error_and_a_stranger_is_unknown(library, tmp_path):
    told = truth_of(_run(tmp_path, "wedge"), _believed("block", WORLD), library)
    assert (told["correct"], told["translation_error_mm"]) == (False, None)
    strange = Belief((), {"block": 0.2, "wedge": 0.1, "unknown": 0.7})
    assert truth_of(_run(tmp_path, "teapot"), strange, library)["correct"]


@pytest.mark.parametrize(
    "config",
    [
        "[settings]\nscale = 1.2\n[resolved]\npart_extent_mm = [84.0, 48.0, 35.88]",
        "[settings]\nscale = 1.2",  # of a run that told no extent
    ],
)
def test_a_part_of_another_size_is_another_object(library, tmp_path, config):
    source = _run(tmp_path, "wedge")
    (tmp_path / "config.toml").write_text(config)
    strange = Belief((), {"block": 0.2, "wedge": 0.1, "unknown": 0.7})
    told = truth_of(source, strange, library)
    assert (told["name"], told["correct"]) == ("unknown", True)
    assert not truth_of(source, _believed("wedge", WORLD), library)["correct"]
    larger = Library.of({"wedge": load_part("wedge", scale=1.2).solid})
    assert truth_of(source, _believed("wedge", WORLD), larger, scale=1.2)["correct"]


def test_identify_and_recognize_judge_sizes_alike(library):
    larger = load_part("wedge", scale=1.2).solid.placed(WORLD)
    told = truth_json(Belief((), {"wedge": 0.1, "unknown": 0.9}), library, "wedge", larger)
    assert (told["name"], told["correct"]) == ("unknown", True)
    same = truth_json(_believed("wedge", WORLD), library, "wedge", library["wedge"].solid.placed(WORLD))
    assert (same["name"], same["correct"]) == ("wedge", True)


def test_a_source_that_knows_no_truth_has_none(library, tmp_path):
    (tmp_path / "summary.json").write_text('{"part": "wedge", "truth": null}')
    assert truth_of(str(tmp_path), _believed("wedge", WORLD), library) is None
    assert truth_of("contacts.csv", _believed("wedge", WORLD), library) is None
