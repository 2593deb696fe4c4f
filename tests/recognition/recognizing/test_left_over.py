"""The noise that contacts turn out to have is theirs, however few they are and however many numbers a pose has."""

import numpy as np
import pytest
import trimesh

from models import parts
from models.csg import Csg, Cylinder, Sphere
from models.library import Entry, Library
from models.solid import Solid
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.pose import exp, pose, random_rotation, rotate, transform_points
from recognition.matching.likelihood import NoiseConfig
from recognition.recognizing.left_over import left_over

SIGMA, TAU, LEAST = 0.3, 0.026, 0.06
TRIALS = 24
SHAPES: dict[str, Csg] = {
    "ball": Sphere(20.0),  # of which a pose has 3 numbers,
    "rod": Cylinder(15.0, 60.0),  # 5,
    "block": parts.build("block"),
    "bracket": parts.build("bracket"),  # and 6
}


@pytest.fixture(scope="module")
def entries() -> dict[str, Entry]:
    return {name: Library.of({name: Solid.from_csg(shape)})[name] for name, shape in SHAPES.items()}


def _touched(entry: Entry, count: int, seed: int, with_normals: bool) -> tuple[Contacts, Floats]:
    """Contacts on an object, and the pose that it lies at."""
    rng, samples = np.random.default_rng([seed, count]), entry.samples
    world = pose(random_rotation(rng), rng.uniform(-40.0, 40.0, 3))
    rows = rng.choice(len(samples), count, replace=False)
    points = transform_points(world, samples.points[rows]) + SIGMA * rng.standard_normal((count, 3))
    normals = rotate(world, samples.normals[rows]) + TAU * rng.standard_normal((count, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return Contacts.of(points, normals if with_normals else np.full_like(normals, np.nan), 1.0, 0.037), world


def _told(entry: Entry, count: int, with_normals: bool, off: float = 0.0) -> Floats:
    """Sigmas over the true one, about poses that are off by some of them."""
    told = []
    for seed in range(TRIALS):
        contacts, world = _touched(entry, count, seed, with_normals)
        move = off * np.random.default_rng(seed).standard_normal(6) * np.repeat([SIGMA, SIGMA / 20.0], 3)
        found = left_over(contacts, entry, world @ exp(move), LEAST, NoiseConfig())
        if found is not None:
            told.append(found.sigma / SIGMA)
    assert len(told) > 0.7 * TRIALS
    return np.array(told)


@pytest.mark.parametrize(("count", "with_normals"), [(8, True), (12, True), (14, False)])
def test_it_is_neither_too_wide_nor_too_narrow(
    entries: dict[str, Entry], count: int, with_normals: bool
) -> None:
    told = {name: _told(entry, count, with_normals) for name, entry in entries.items()}
    for name, ratios in told.items():
        assert 0.8 < np.median(ratios) < 1.25, name
    assert np.mean(np.concatenate(list(told.values())) < 0.5) < 0.1  # about 1 in 20 is due of 8


def test_the_pose_may_be_off(entries: dict[str, Entry]) -> None:
    near, off = (_told(entries["bracket"], 20, True, by) for by in (0.0, 1.0))
    assert np.abs(np.median(off / near) - 1.0) < 0.05


def test_a_few_contacts_astray_do_not_widen_it(entries: dict[str, Entry]) -> None:
    told = []
    for seed in range(TRIALS):
        contacts, world = _touched(entries["block"], 20, seed, True)
        points = contacts.points.copy()
        points[:2] += 8.0 * contacts.normals[:2]
        astray = Contacts.of(points, contacts.normals, 1.0, 0.037)
        found = left_over(astray, entries["block"], world, LEAST, NoiseConfig())
        assert found is not None
        told.append(found.sigma / SIGMA)
    assert 0.8 < np.median(told) < 1.25


def test_as_many_contacts_as_a_pose_has_numbers_tell_nothing(entries: dict[str, Entry]) -> None:
    for seed in range(5):
        contacts, world = _touched(entries["bracket"], 6, seed, with_normals=False)
        assert left_over(contacts, entries["bracket"], world, LEAST, NoiseConfig()) is None


def test_normals_tell_their_own_scatter(entries: dict[str, Entry]) -> None:
    for name in ("ball", "rod", "bracket"):
        contacts, world = _touched(entries[name], 50, 0, with_normals=True)
        found = left_over(contacts, entries[name], world, LEAST, NoiseConfig())
        assert found is not None
        assert found.tau == pytest.approx(TAU, rel=0.35)


def test_normals_of_a_freeform_surface_are_those_that_its_facets_stand_for() -> None:
    """Facets of 6 degrees lie as far off them as poor normals do."""
    ball, rng = trimesh.creation.icosphere(3), np.random.default_rng(2)
    sizes = np.array([30.0, 22.0, 15.0])
    entry = Library.of({"egg": Solid.from_mesh(ball.vertices * sizes, ball.faces)})["egg"]
    way = rng.standard_normal((60, 3))
    points = way / np.linalg.norm(way, axis=1, keepdims=True) * sizes
    normals = points / sizes**2
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True) + 0.01 * rng.standard_normal((60, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    noisy = points + 0.05 * rng.standard_normal((60, 3))
    found = left_over(Contacts.of(noisy, normals, 1.0, 0.037), entry, np.eye(4), LEAST, NoiseConfig())
    assert found is not None
    assert 0.007 < found.tau < 0.016


@pytest.mark.parametrize("sigma", [3.0, 9.0])
def test_a_wide_scatter_is_told_as_wide_as_it_is(entries: dict[str, Entry], sigma: float) -> None:
    """Here up to a seventh of the object's size."""
    told = []
    for seed in range(TRIALS):
        contacts, world = _touched(entries["bracket"], 40, seed, True)
        wide = contacts.points + sigma * np.random.default_rng(seed).standard_normal((40, 3))
        felt = Contacts.of(wide, contacts.normals, sigma, 0.037)
        found = left_over(felt, entries["bracket"], world, LEAST, NoiseConfig())
        assert found is not None
        told.append(found.sigma / sigma)
    assert 0.75 < np.median(told) < 1.35
