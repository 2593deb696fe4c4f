"""A table of few contacts that does not say their noise: it tells which object, and that it is none of these."""

from pathlib import Path

import numpy as np
import pytest

from models import parts
from models.formats.openscad.writer import write
from models.library import Library
from models.solid import Solid
from models.symmetry import pose_error
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.pose import pose, random_rotation, rotate, transform_points
from recognition.matching import Evidence
from recognition.matching.match import MatchConfig
from recognition.recognizing.run import Asked, locate, recognize
from recognition.recognizing.settled import settled

NAMES = ("bracket", "wedge", "block", "flange", "v_block")


@pytest.fixture(scope="module")
def library() -> Library:
    return Library.of({name: Solid.from_csg(parts.build(name)) for name in NAMES})


def _world(seed: int) -> Floats:
    """Where the object lies."""
    rng = np.random.default_rng([seed, 1])
    return pose(random_rotation(rng), rng.uniform(-40.0, 40.0, 3))


def _table(path: Path, library: Library, name: str, seed: int) -> str:
    """Of 30 contacts 0.3 mm and 2 degrees off, edges between most neighbors."""
    rng, samples = np.random.default_rng(seed), library[name].samples
    rows = rng.integers(len(samples), size=30)
    world = _world(seed)
    points = transform_points(world, samples.points[rows]) + 0.3 * rng.standard_normal((30, 3))
    normals = rotate(world, samples.normals[rows]) + 0.035 * rng.standard_normal((30, 3))
    table = np.hstack([points, normals])
    np.savetxt(path, table, delimiter=",", header="x,y,z,nx,ny,nz", comments="")
    return str(path)


def _folder(path: Path, names: list[str]) -> Path:
    path.mkdir()
    for name in names:
        write(parts.build(name), path / f"{name}.csg")
    return path


@pytest.mark.parametrize("name", ["bracket", "flange", "v_block"])
def test_an_object_that_is_not_there_is_unknown(library: Library, tmp_path: Path, name: str) -> None:
    others = _folder(tmp_path / "others", [other for other in NAMES if other != name])
    felt = _table(tmp_path / "felt.csv", library, name, 7)
    answer = recognize(Asked(felt), others, "mm", 1.0)
    assert answer["decision"] == "unknown"
    assert any("--contact-sigma" in warning for warning in answer["warnings"])
    told = recognize(Asked(felt, sigma=0.3), others, "mm", 1.0)
    assert not any("--contact-sigma" in warning for warning in told["warnings"])


def test_one_that_is_there_is_named(library: Library, tmp_path: Path) -> None:
    folder = _folder(tmp_path / "parts", list(NAMES))
    for seed, name in enumerate(("bracket", "flange", "v_block")):
        answer = recognize(Asked(_table(tmp_path / "felt.csv", library, name, seed)), folder, "mm", 1.0)
        assert (answer["decision"], answer["confidence"] > 0.95) == (name, True)


def test_a_pose_is_as_sure_as_it_is_said_to_be(library: Library, tmp_path: Path) -> None:
    model, felt, off = tmp_path / "bracket.csg", tmp_path / "felt.csv", []
    write(parts.build("bracket"), model)
    for seed in range(6):
        world = _world(seed)
        answer = locate(Asked(_table(felt, library, "bracket", seed)), str(model), "mm", 1.0)
        found = answer["candidates"][0]
        error = np.linalg.norm(np.array(found["pose"]["translation_mm"]) - world[:3, 3])
        off.append(error / found["pose_sigma"]["translation_mm"])
        assert error < 1.0
        assert any("--contact-sigma" in warning for warning in answer["warnings"])
    assert 0.3 < np.sqrt(np.mean(np.square(off))) < 2.0


@pytest.mark.parametrize("count", [8, 10, 12])
def test_few_contacts_are_as_sure_as_they_are(library: Library, count: int) -> None:
    off, sigmas, entry = [], [], {"bracket": library["bracket"]}
    for seed in range(8):
        rng, samples = np.random.default_rng(seed), library["bracket"].samples
        rows, world = rng.choice(len(samples), count, replace=False), _world(seed)
        points = transform_points(world, samples.points[rows]) + 0.3 * rng.standard_normal((count, 3))
        normals = rotate(world, samples.normals[rows]) + 0.026 * rng.standard_normal((count, 3))
        contacts = Contacts.of(points, normals / np.linalg.norm(normals, axis=1, keepdims=True), 0.6, 0.037)
        untold = Evidence(contacts, scale_known=False, normal_scale_known=False)
        belief, taken = settled(untold, entry, None, 0.0, MatchConfig())
        found = belief.hypotheses[0]
        sigmas.append(float(np.median(taken.contacts.sigma)))
        error = pose_error(library["bracket"].symmetry, found.pose, world)
        off.append(error.distance / found.translation_sigma)
    assert 0.22 < np.median(sigmas) < 0.4
    assert np.min(sigmas) > 0.1
    assert 0.3 < np.median(off) < 1.5


def test_more_left_over_than_was_guessed_widens_nothing(library: Library) -> None:
    """It is another object's, which would fit all the better."""
    samples = library["flange"].samples
    rows = np.random.default_rng(3).choice(len(samples), 12, replace=False)
    contacts = Contacts.of(samples.points[rows], samples.normals[rows], 0.3, 0.03)
    untold = Evidence(contacts, scale_known=False, normal_scale_known=False)
    _, taken = settled(untold, {"block": library["block"]}, None, 0.0, MatchConfig())
    assert (taken.contacts.sigma == 0.3).all()


@pytest.mark.parametrize("sigma", [None, 0.3])
def test_locating_another_object_says_that_it_is_hardly_this_one(
    library: Library, tmp_path: Path, sigma: float | None
) -> None:
    felt = Asked(_table(tmp_path / "felt.csv", library, "bracket", 3), sigma=sigma)
    for model in ("bracket", "wedge"):
        told = any("where it fits best" in line for line in locate(felt, model, "auto", 1.0)["warnings"])
        assert told == (model != "bracket")
