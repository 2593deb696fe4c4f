import math
import tomllib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from primitives.errors import PalpateError
from primitives.toml_text import toml_lines
from recognition.config import ExploreOptions, from_toml, parse_numbers, parse_pose, to_toml


def test_saved_settings_read_back_the_same(tmp_path):
    options = ExploreOptions(
        part='odd "name"\\ü.stl',
        pose=(1.0, -2.5, 3e-7, 0.5, 0.5, -0.5, 0.5),
        sensors=("lts210", "probe"),
        noise=0.05,
        seed=7,
        workspace=(-10, -20, -30, 10.5, 20, 30),
    )
    (tmp_path / "config.toml").write_text(to_toml(options, "0.1.0", {"pose": [1, 2]}), encoding="utf-8")
    assert from_toml(tmp_path / "config.toml") == options


def test_where_a_result_goes_is_not_saved():
    text = to_toml(ExploreOptions("block", out=Path("somewhere"), overwrite=True), "0.1.0")
    assert set(tomllib.loads(text)["settings"]).isdisjoint({"out", "overwrite"})


def test_lengths_carry_their_unit_in_the_file():
    assert {"feature_mm", "workspace_mm", "pose_noise_mm"} <= set(
        tomllib.loads(to_toml(ExploreOptions("block"), "0"))["settings"]
    )


values = st.recursive(
    st.booleans()
    | st.integers(-(2**62), 2**62)
    | st.floats(allow_nan=False)
    | st.text(st.characters(codec="utf-8")),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(st.text(st.characters(codec="utf-8")), inner, max_size=3)
    ),
    max_leaves=6,
)


@given(st.dictionaries(st.text(st.characters(codec="utf-8")), values, max_size=4))
def test_any_table_survives_toml(table):
    assert tomllib.loads("\n".join(toml_lines(table))) == table


def test_arrays_and_numpy_scalars_become_plain_toml():
    text = "\n".join(
        toml_lines({"a": np.eye(2), "b": np.float64(0.5), "c": np.int64(3), "d": None, "e": math.inf})
    )
    assert tomllib.loads(text) == {"a": [[1.0, 0.0], [0.0, 1.0]], "b": 0.5, "c": 3, "e": math.inf}


def test_a_pose_is_a_word_or_seven_numbers():
    assert parse_pose("random") == "random"
    pose = ExploreOptions("block", pose=parse_pose("1,2,3,0,0,0,2")).fixed_pose
    np.testing.assert_allclose(pose[:3, 3], [1, 2, 3])
    np.testing.assert_allclose(pose[:3, :3], np.diag([-1, -1, 1]), atol=1e-12)
    assert ExploreOptions("block").fixed_pose is None
    np.testing.assert_array_equal(ExploreOptions("block", pose="as-is").fixed_pose, np.eye(4))


@pytest.mark.parametrize("text", ["", "1,2", "a,b,c,d,e,f,g", "1,2,3,0,0,0,0", "1,2,3,nan,0,0,1", "as is"])
def test_a_bad_pose_is_refused_in_one_line(text):
    with pytest.raises(PalpateError) as error:
        parse_pose(text)
    assert "--pose" in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "setting",
    [
        {"units": "miles"},
        {"scale": 0.0},
        {"scale": math.nan},
        {"workspace": (0, 0, 0, 1, 1, 0)},
        {"feature": -1.0},
        {"noise": -0.1},
        {"noise": math.inf},
        {"noise": 5.0},
        {"pose_noise": -1.0},
        {"seed": -1},
        {"max_touches": 0},
        {"max_minutes": 0.0},
        {"sensors": ()},
    ],
)
def test_settings_out_of_range_are_refused_in_one_line(setting):
    with pytest.raises(PalpateError) as error:
        ExploreOptions("block", **setting)
    assert str(error.value).startswith("--")
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "text",
    ["", "nonsense", "[settings]\nbogus = 1", "[settings]\nseed = 1", "[settings]\npart='a'\nunits='x'"],
)
def test_a_file_that_is_no_config_is_refused(tmp_path, text):
    (tmp_path / "c.toml").write_text(text)
    with pytest.raises(PalpateError):
        from_toml(tmp_path / "c.toml")


def test_numbers_are_counted():
    assert parse_numbers("1, 2,-3", 3, "--x", "three numbers") == (1.0, 2.0, -3.0)
    with pytest.raises(PalpateError, match="--x '1,2' is not three numbers"):
        parse_numbers("1,2", 3, "--x", "three numbers")
