import pytest

from exploration.sensing.spec import TECHNOLOGIES, load_sensor, sensor_from_toml, sensor_names
from primitives.errors import PalpateError

GOOD = """
[array]
rows = 4
columns = 5
pitch = [2.0, 2.5]
[elastomer]
stiffness = 0.1
thickness = 2.0
[housing]
size = [12, 12, 30]
proud = 2.0
"""


@pytest.mark.parametrize("name", sensor_names())
def test_every_preset_loads_and_its_housing_is_no_smaller_than_its_pad(name):
    spec = load_sensor(name)
    assert spec.name == name
    assert spec.housing.size[0] >= spec.array.size[0] + 2 * spec.elastomer.margin - 1e-9
    assert spec.housing.size[1] >= spec.array.size[1] + 2 * spec.elastomer.margin - 1e-9


def test_presets_name_the_arrays_and_each_technology():
    shapes = {n: load_sensor(n).array.shape for n in ("lts210", "dsa", "fingertip", "probe", "square32")}
    assert shapes == {
        "lts210": (10, 16),
        "dsa": (14, 6),
        "fingertip": (4, 4),
        "probe": (1, 1),
        "square32": (32, 32),
    }
    assert load_sensor("lts210").array.size == pytest.approx((28.8, 18.0))
    assert {load_sensor(n).technology for n in sensor_names()} >= set(TECHNOLOGIES) - {"unspecified"}


def test_what_a_file_leaves_out_is_absent():
    spec = sensor_from_toml(GOOD, "mine")
    assert spec.name == "mine"
    assert (spec.elastomer.spread, spec.elastomer.hysteresis, spec.electronics.noise) == (0.0, 0.0, 0.0)
    assert (spec.electronics.dead, spec.electronics.drift, spec.electronics.scan) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("wrong", "right", "says"),
    [
        ("pitch", "pich", "valid keys: columns, name, pitch, rows"),
        ("[housing]", "[house]", "unknown key 'house'"),
        ("proud = 2.0", "", "missing proud"),
        ("rows = 4", "rows = 4.5", "rows must be int"),
        ("rows = 4", "rows = 0", "from 1 to 1024"),
        ("stiffness = 0.1", "stiffness = nan", "must be finite"),
        ("stiffness = 0.1", 'stiffness = "soft"', "must be float"),
        ("[2.0, 2.5]", "[2.0]", "list of 2 numbers"),
        ("[array]", "period = 0\n[array]", "period must be positive"),
        ("[array]", "[array", "not valid TOML"),
        ("[array]", 'technology = "magic"\n[array]', "technology must be one of"),
    ],
)
def test_broken_file_is_answered_in_one_line_that_names_the_fix(wrong, right, says):
    with pytest.raises(PalpateError) as caught:
        sensor_from_toml(GOOD.replace(wrong, right), "mine")
    assert says in str(caught.value)
    assert "\n" not in str(caught.value)


def test_unknown_name_and_missing_file_are_known_errors(tmp_path):
    with pytest.raises(PalpateError, match="did you mean lts210"):
        load_sensor("lts21")
    with pytest.raises(PalpateError, match="cannot read"):
        load_sensor(tmp_path / "gone.toml")
    with pytest.raises(PalpateError, match="cannot read"):
        load_sensor(_file(tmp_path / "noise.toml", b"\xff\xfe\x00"))


def _file(path, content):
    path.write_bytes(content)
    return path
