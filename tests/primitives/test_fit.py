import numpy as np
import pytest

from primitives import pose
from primitives.errors import PalpateError
from primitives.evidence import Contacts
from primitives.fit import FITTERS, Fit, FitOptions, NoFit, fit, refit, squares
from primitives.residuals import Problem, advance, chart, linearize
from primitives.shapes import KINDS, Cone, Cylinder, Plane, Sphere


@pytest.fixture
def rng():
    return np.random.default_rng(5)


def table(points, normals, sigma=0.05, turn=0.03):
    return Contacts.of(points, normals, sigma, turn)


def test_gradient_of_the_cost_agrees_with_differences(shape, touched, rng):
    problem = Problem.of(touched(shape, 30, rng, sigma=0.5, turn=0.05))
    residuals, jacobian = linearize(shape, problem, 1.0)

    def cost(step):
        return float(np.square(linearize(shape.retract(step), problem, 1.0)[0]).sum())

    h = 1e-6 * np.eye(shape.dof)
    numeric = np.array([(cost(e) - cost(-e)) / 2e-6 for e in h])
    assert np.allclose(2 * residuals @ jacobian, numeric, rtol=1e-5, atol=1e-5 * np.abs(numeric).max())


def test_point_rows_of_the_jacobian_agree_with_differences(shape, touched, rng):
    problem = Problem.of(touched(shape, 30, rng, sigma=0.5, felt=False))
    jacobian = linearize(shape, problem, 1.0)[1]
    for i, e in enumerate(1e-6 * np.eye(shape.dof)):
        rows = (
            linearize(shape.retract(e), problem, 1.0)[0] - linearize(shape.retract(-e), problem, 1.0)[0]
        ) / 2e-6
        assert np.allclose(jacobian[:, i], rows, atol=1e-4)


def test_a_small_chart_step_is_the_retraction_of_its_image(shape, rng):
    center = shape.anchor + 30 * shape.direction
    step = rng.normal(size=shape.dof) * 1e-5
    reached = advance(shape, center, step)
    assert reached is not None
    assert np.allclose(shape.local(reached), chart(shape, center) @ step, atol=1e-8)


@pytest.mark.parametrize("felt", [True, False])
def test_fit_of_exact_samples_is_the_shape(shape, touched, rng, felt):
    found = fit(shape.kind, touched(shape, 80, rng, sigma=0.0, turn=0.0, felt=felt))
    assert isinstance(found, Fit)
    assert found.converged
    probe = rng.normal(size=(50, 3)) * 10 + shape.anchor + 20 * shape.direction
    assert np.allclose(
        np.abs(found.shape.signed_distance(probe)), np.abs(shape.signed_distance(probe)), atol=1e-5
    )


def test_fit_moves_with_the_contacts(shape, touched, rng):
    contacts = touched(shape, 60, rng)
    motion = pose.pose(pose.random_rotation(rng), [40.0, -20.0, 10.0])
    moved = table(pose.transform_points(motion, contacts.points), pose.rotate(motion, contacts.normals))
    here, there = fit(shape.kind, contacts), fit(shape.kind, moved)
    assert isinstance(here, Fit)
    assert isinstance(there, Fit)
    probe = contacts.points + rng.normal(size=(60, 3))
    expected = here.shape.signed_distance(probe)
    assert np.allclose(there.shape.signed_distance(pose.transform_points(motion, probe)), expected, atol=1e-4)
    assert there.chi2 == pytest.approx(here.chi2, rel=1e-6)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("felt", [True, False])
def test_covariance_is_that_of_the_errors(shape, touched, sign, felt):
    if shape.kind == "plane" and (sign < 0 or not felt):
        pytest.skip("a plane is turned by its normals: it has no concave side, and no side without them")
    rng, trials, total, chi2 = np.random.default_rng(8), 60, 0.0, 0.0
    for _ in range(trials):
        found = fit(shape.kind, touched(shape, 60, rng, sigma=0.1, sign=sign, felt=felt))
        assert isinstance(found, Fit)
        assert found.convex == (sign > 0 or not felt)
        error = found.shape.local(shape)
        total += float(error @ np.linalg.solve(found.covariance, error)) / (trials * shape.dof)
        chi2 += found.chi2 / found.dof / trials
    assert total == pytest.approx(1.0, abs=5.5 * np.sqrt(2.0 / (trials * shape.dof)))
    assert chi2 == pytest.approx(1.0, abs=0.1)


def test_cylinder_radius_survives_partial_arc(touched):
    rng = np.random.default_rng(2)
    truth = Cylinder([0, 0, 0], [0, 0, 1], 15.0)
    errors = []
    for _ in range(40):
        found = fit("cylinder", touched(truth, 30, rng, sigma=0.3, turn=np.deg2rad(3), arc=np.deg2rad(120)))
        assert isinstance(found, Fit)
        assert isinstance(found.shape, Cylinder)
        errors.append(abs(found.shape.radius - 15.0) / 15.0)
    assert np.median(errors) < 0.015


def test_normals_that_some_contacts_lack_still_count(shape, touched, rng):
    contacts = touched(shape, 60, rng)
    normals = contacts.normals.copy()
    normals[::2] = np.nan
    mixed, bare = (
        fit(shape.kind, table(contacts.points, normals)),
        fit(shape.kind, table(contacts.points, None)),
    )
    assert isinstance(mixed, Fit)
    assert isinstance(bare, Fit)
    assert np.linalg.det(mixed.covariance) < np.linalg.det(bare.covariance)


def test_robust_fit_leaves_outliers_out(shape, touched, rng):
    contacts = touched(shape, 80, rng)
    points = contacts.points.copy()
    points[:8] += 3.0 * contacts.normals[:8]
    found = fit(shape.kind, table(points, contacts.normals), FitOptions(robust=True))
    assert isinstance(found, Fit)
    assert not found.inliers[:8].any()
    assert found.inliers[8:].mean() > 0.95
    assert (
        np.abs(
            found.shape.local(shape)
            if shape.kind != "plane"
            else found.shape.signed_distance(shape.project(points[8:]))
        ).max()
        < 1.0
    )


def test_near_cylinder_is_a_cone_of_tiny_angle_either_way(touched):
    rng = np.random.default_rng(6)
    for angle in (0.02, 0.05):
        truth = Cone([0, 0, -15 / np.tan(angle)], [0, 0, 1], angle)
        phi, z = rng.uniform(0, 2 * np.pi, 100), rng.uniform(-20, 20, 100)
        rho = 15 + z * np.tan(angle)
        points = np.stack([rho * np.cos(phi), rho * np.sin(phi), z], axis=1)
        found = fit("cone", table(points, truth.normals(points), 0.02, 0.01))
        assert isinstance(found, Fit)
        assert isinstance(found.shape, Cone)
        assert found.shape.semi_angle == pytest.approx(angle, rel=1e-4)


@pytest.mark.parametrize("kind", list(KINDS))
def test_too_few_or_collinear_contacts_give_no_fit(kind):
    along = np.outer(np.linspace(0, 10, 12), [1.0, 1.0, 0.0])
    assert isinstance(fit(kind, table([[0, 0, 0.0]], None)), NoFit)
    found = fit(kind, table(along, None))
    assert not found
    assert isinstance(found, NoFit)
    assert found.reason


def test_broken_input_is_refused_with_the_cure():
    with pytest.raises(PalpateError, match="choose one of"):
        fit("cube", table([[0, 0, 0.0]], None))
    with pytest.raises(PalpateError, match="drop the rows"):
        fit("plane", table([[0, 0, np.nan]] * 5, None))


def test_refit_agrees_with_fit(shape, touched, rng):
    contacts = touched(shape, 60, rng)
    first = fit(shape.kind, contacts)
    assert isinstance(first, Fit)
    again = refit(shape, True, contacts)
    assert isinstance(again, Fit)
    assert again.chi2 == pytest.approx(first.chi2, rel=1e-6)
    assert FITTERS[shape.kind](contacts)
    assert squares(first, contacts).sum() == pytest.approx(first.chi2)


def test_plane_faces_the_way_that_it_was_felt(touched, rng):
    truth = Plane([0, 0, 5], [0, 0, 1])
    found = fit("plane", touched(truth, 20, rng, sign=-1.0))
    assert isinstance(found, Fit)
    assert found.shape.direction[2] < -0.99


def test_sphere_felt_from_inside_is_concave(touched, rng):
    found = fit("sphere", touched(Sphere([0, 0, 0], 10.0), 30, rng, sign=-1.0))
    assert isinstance(found, Fit)
    assert not found.convex
