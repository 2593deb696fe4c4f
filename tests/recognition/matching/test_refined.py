"""Poses refined on curved surfaces: felt normals go along with the surface that bends."""

import numpy as np
import pytest

from models.csg import Cone, Cylinder
from models.library import Library
from models.solid import Solid
from models.symmetry import pose_error
from primitives.evidence import Contacts
from primitives.pose import exp, inverse, pose, random_rotation, rotation_exp
from recognition.matching import Evidence, match
from recognition.matching.align import refine
from recognition.matching.facets import bent, facets_of, on_edge
from recognition.matching.steps import add_bent_normal

ROD = Library.of({"rod": Solid.from_csg(Cylinder(15.0, 60.0))})["rod"]


def _felt(count):
    rng = np.random.default_rng(0)
    turn, z = rng.uniform(0.0, 2.0, count), rng.uniform(-25.0, 25.0, count)
    normals = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])
    return 15.0 * normals + z[:, None] * [0.0, 0.0, 1.0], normals


def _refined(start, rounds, tilt=0.0):
    points, normals = _felt(12)
    normals = normals + tilt * np.random.default_rng(1).normal(size=normals.shape)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    each = np.ones(12)
    return refine(
        start[:3][None].copy(), points, normals, each > 0, 0.1 * each, 0.02 * each, each,
        facets_of(ROD.solid.body), 1.0, rounds,
    )  # fmt: skip


def test_a_turn_about_its_own_axis_is_free_on_a_cylinder():
    found = _refined(np.eye(4), 0)
    middle = _felt(12)[0].mean(axis=0)
    about = np.concatenate([np.cross([0.0, 0.0, 1.0], middle), [0.0, 0.0, 1.0]])
    across = np.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0])
    free, held = about @ found.information[0] @ about, across @ found.information[0] @ across
    assert free < 0.02 * held


def test_normals_that_noise_tilts_tell_nothing_of_a_free_turn():
    middle = _felt(12)[0].mean(axis=0)
    about = np.concatenate([np.cross([0.0, 0.0, 1.0], middle), [0.0, 0.0, 1.0]])
    exact, noisy = (about @ _refined(np.eye(4), 0, t).information[0] @ about for t in (0.0, 0.02))
    assert noisy < 2.0 * exact + 0.1  # one for each contact, where noise was taken for a slope


def test_a_pose_that_is_off_comes_back_within_few_rounds():
    off = exp(np.array([0.6, -0.4, 0.0, 0.03, -0.05, 0.0])) @ pose(rotation_exp([0.0, 0.0, 0.3]))
    found = _refined(off, 6)
    assert found.distances.max() < 0.02  # of facets' sagitta
    assert found.angles.max() < 0.01
    axis = inverse(pose(found.poses[0][:, :3]))[:3, 2]
    assert abs(axis[2]) > np.cos(0.005)


def test_the_slope_of_a_bent_normal_is_that_of_differences():
    rng = np.random.default_rng(1)
    m, n, r, k = rng.normal(size=3), rng.normal(size=3), rng.normal(size=3), rng.normal(size=(3, 3))
    m, n = m / np.linalg.norm(m), n / np.linalg.norm(n)
    h, b = np.zeros((6, 6)), np.zeros(6)
    add_bent_normal(h, b, m, n, k, r, 1.0, np.empty(6))
    along = k - np.outer(n, n @ k)

    def square(x):
        change = np.cross(x[3:], m) - along @ (x[:3] + np.cross(x[3:], r))
        return 0.5 * float(((m - n + change) ** 2).sum())

    slope = [(square(1e-5 * e) - square(-1e-5 * e)) / 2e-5 for e in np.eye(6)]
    assert np.allclose(-b, slope, atol=1e-6)


def test_facets_of_a_cylinder_bend_by_one_over_its_radius():
    mesh, k = facets_of(ROD.solid.body), np.empty((3, 3))
    side = int(np.argmax(np.abs(mesh.flat[:, 2]) < 0.1))
    bent(mesh.corners[side], mesh.normals[side], k)
    values = np.sort(np.abs(np.linalg.eigvals(k)))
    assert np.allclose(values, [0.0, 0.0, 1 / 15.0], atol=2e-3)


def test_how_sure_a_rod_lies_says_nothing_of_turns_about_itself():
    points, normals = _felt(40)
    ends = np.array([[x, y, 30.0] for x in (-8.0, 8.0) for y in (-8.0, 8.0)])
    points = np.vstack([points, ends])
    normals = np.vstack([normals, np.tile([0.0, 0.0, 1.0], (4, 1))])
    belief = match(Evidence(Contacts.of(points, normals, 0.05, 0.01)), {"rod": ROD})
    assert belief.decision == "rod"
    assert belief.hypotheses[0].rotation_sigma < 0.02
    assert belief.hypotheses[0].translation_sigma < 0.2


def test_a_facet_without_area_is_passed_over():
    mesh, each = facets_of(ROD.solid.body), np.ones(1)
    corners, flat, normals = mesh.corners.copy(), mesh.flat.copy(), mesh.normals.copy()
    touched = corners[0, :1] * [1.01, 1.01, 1.0]
    corners[0], flat[0], normals[0] = touched, 0.0, 0.0
    mesh = mesh._replace(corners=corners, flat=flat, normals=normals)
    args = touched, np.zeros((1, 3)), each < 0, 0.1 * each, 0.02 * each, each
    found = refine(np.eye(4)[None, :3].copy(), *args, mesh, 1.0, 0)
    assert 0.1 < found.distances[0, 0] < 0.2  # on its neighbors


def test_how_sure_a_cone_lies_is_how_far_it_is_off():
    cone = Library.of({"cone": Solid.from_csg(Cone(20.0, 0.0, 50.0))})
    entry, off, said = cone["cone"], [], []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        rows = rng.choice(len(entry.samples.points), 20, replace=False)
        points = entry.samples.points[rows] + 0.1 * rng.standard_normal((20, 3))
        normals = entry.samples.normals[rows] + 0.01 * rng.standard_normal((20, 3))
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        evidence = Evidence(Contacts.of(points, normals, 0.1, 0.01))
        h = match(evidence, cone, starts=[("cone", np.eye(4))]).hypotheses[0]
        off.append(pose_error(entry.symmetry, h.pose, np.eye(4)).angle)
        said.append(h.rotation_sigma)
    assert 0.5 < np.sqrt(np.mean(np.square(off)) / np.mean(np.square(said))) < 1.5


@pytest.mark.parametrize("width", [1.0, 0.01, 0.001])
def test_a_place_on_a_sharp_side_of_a_sliver_is_on_an_edge(width):
    rng, sharp = np.random.default_rng(0), np.array([True, True, True, True, True, True])
    for _ in range(200):
        corners = random_rotation(rng) @ np.array([[0.0, 0.0, 0.0], [50.0, 0.0, 0.0], [20.0, width, 0.0]]).T
        corners = np.ascontiguousarray(corners.T + rng.uniform(-50.0, 50.0, 3))
        t, k = rng.random(), int(rng.integers(3))
        assert on_edge((1.0 - t) * corners[k] + t * corners[(k + 1) % 3], corners, sharp)
