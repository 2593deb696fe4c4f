"""The object's material in the simulator, against two springs in series and against its own statistics."""

import numpy as np
import pytest

from exploration.devices.simulated import simulate
from exploration.sensing.calibration import Calibration, correct
from exploration.sensing.spec import load_sensor
from models.csg import Cube
from models.material import MadeOf, Material, Materials
from models.solid import Solid
from primitives import pose as se3
from primitives.errors import PalpateError
from primitives.grain import Grain

BLOCK = Solid.from_csg(Cube((80.0, 60.0, 40.0)))
DOWN = np.diag([1.0, -1.0, -1.0])


def pressed(surface, depth, at=(0.0, 0.0)):
    _, (array,) = simulate(
        surface,
        [load_sensor("lts210")],
        np.random.default_rng(0),
        noise=0.0,
        start_pose=se3.pose(DOWN, [*at, 20.0 - depth]),
    )
    return correct(array.read(), Calibration.nominal(array.spec), array.array).depth


@pytest.mark.parametrize("stiffness", [0.02, 0.1, 1.0])
def test_skin_and_object_share_a_press_as_springs_in_series(stiffness):
    made = MadeOf(BLOCK, Materials(Material(stiffness)))
    skin = load_sensor("lts210").elastomer.stiffness
    wanted = 0.6 * stiffness / (skin + stiffness)
    assert np.abs(pressed(made, 0.6) - wanted).max() < 0.005  # a count is 0.004 mm


def test_a_material_that_is_rigid_and_smooth_changes_no_frame():
    made = MadeOf(BLOCK, Materials(Material()))
    np.testing.assert_array_equal(pressed(made, 0.5, (35.0, 3.0)), pressed(BLOCK, 0.5, (35.0, 3.0)))


def test_only_the_face_that_was_told_so_yields():
    top = int(MadeOf(BLOCK, Materials()).faces_at(np.array([[0.0, 0.0, 20.0]]))[0])
    soft = MadeOf(BLOCK, Materials(faces={top: Material(0.1)}))
    other = MadeOf(BLOCK, Materials(faces={(top + 1) % 6: Material(0.1)}))
    assert pressed(soft, 0.5).mean() == pytest.approx(0.25, abs=0.01)
    assert pressed(other, 0.5).mean() == pytest.approx(0.5, abs=0.01)


def test_grain_has_the_asked_height_and_size_and_stays_where_it_is():
    grain = Grain(size=1.5, seed=4)
    places = np.random.default_rng(0).uniform(-300.0, 300.0, (40_000, 3))
    heights = grain.at(places)
    assert heights.std() == pytest.approx(1.0, abs=0.03)
    beside = grain.at(places + np.array([1.5, 0.0, 0.0]))
    assert np.mean(heights * beside) == pytest.approx(np.exp(-0.5), abs=0.06)
    np.testing.assert_array_equal(heights, Grain(size=1.5, seed=4).at(places))


def test_a_rough_face_is_felt_as_its_grain_blurred_by_the_rubber():
    smooth, rough = pressed(BLOCK, 0.5), pressed(MadeOf(BLOCK, Materials(Material(roughness=0.1))), 0.5)
    felt = (rough - smooth).std()
    assert 0.3 * 0.1 < felt < 0.7 * 0.1


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("stiffness_n_mm3 = -1.0", "positive"),
        ("hardness = 3", "valid keys"),
        ("[faces.top]\nroughness_mm = 0.1", "number"),
        ("roughness_mm = 'much'", "must be a number"),
        ("stiffness_n_mm3 =", "readable"),
    ],
)
def test_a_broken_material_file_is_refused_in_one_line(tmp_path, text, told):
    path = tmp_path / "material.toml"
    path.write_text(text)
    with pytest.raises(PalpateError, match=told) as error:
        Materials.from_toml(path)
    assert "\n" not in str(error.value)


def test_a_material_of_a_face_that_is_not_there_is_refused():
    with pytest.raises(PalpateError, match="no face 9"):
        MadeOf(BLOCK, Materials(faces={9: Material(0.1)}))
