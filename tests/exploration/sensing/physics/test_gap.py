"""The indentation of the skin against closed forms and dense sampling."""

import numpy as np
import pytest
import trimesh
from scipy.ndimage import gaussian_filter

from exploration.sensing.physics.elastomer import pressure, wrench
from exploration.sensing.physics.gap import SampledGap, gap, indentation
from exploration.sensing.physics.mesh_gap import MeshGap
from exploration.sensing.physics.skin import skin_of
from exploration.sensing.spec import load_sensor
from models.solid import Solid
from primitives.pose import pose, rotation_exp

LTS = load_sensor("lts210")
DOWN = np.diag([1.0, -1.0, -1.0])


def solid(mesh):
    return Solid.from_mesh(mesh.vertices, mesh.faces)


@pytest.fixture(scope="module")
def block():
    return solid(trimesh.creation.box((40.0, 40.0, 40.0)))


def split(mesh, levels):
    """The same shape in finer triangles, so that it is felt by rays."""
    for _ in range(levels):
        mesh = mesh.subdivide()
    return mesh


def half_plane_share(nx, ny, c, x0, x1, y0, y1):
    """Share of a rectangle with nx x + ny y <= c, by inclusion and exclusion of wedges."""
    if abs(nx) < 1e-12:
        return np.clip((c / ny - y0 if ny > 0 else y1 - c / ny) / (y1 - y0), 0, 1) + 0 * x0
    if abs(ny) < 1e-12:
        return np.clip((c / nx - x0 if nx > 0 else x1 - c / nx) / (x1 - x0), 0, 1) + 0 * y0
    if nx < 0:
        return half_plane_share(-nx, ny, c, -x1, -x0, y0, y1)
    if ny < 0:
        return half_plane_share(nx, -ny, c, x0, x1, -y1, -y0)

    def wedge(x, y):
        return np.maximum(0.0, c - nx * x - ny * y) ** 2 / (2 * nx * ny)

    area = wedge(x0, y0) - wedge(x1, y0) - wedge(x0, y1) + wedge(x1, y1)
    return area / ((x1 - x0) * (y1 - y0))


def edge_poses(count, rng):
    """Presses across the block's edge x = 20, every fourth one aligned with the taxels; angle and offset."""
    for i in range(count):
        angle = rng.uniform(-0.7, 0.7) if i % 4 else 0.0
        offset = rng.uniform(-3.0, 3.0) if i % 8 else 0.9 * rng.integers(-4, 5)
        yield angle, offset, pose(DOWN @ rotation_exp([0, 0, angle]), [20.0 + offset, 0.3, 19.5])


def edge_share(angle, offset, skin):
    """Exact share of every cell over the block: in the sensor's frame the edge is n . p = -offset."""
    x0, x1 = skin.x_edges[:-1][None, :], skin.x_edges[1:][None, :]
    y0, y1 = skin.y_edges[:-1][:, None], skin.y_edges[1:][:, None]
    return half_plane_share(np.cos(angle), -np.sin(angle), -offset, x0, x1, y0, y1)


@pytest.mark.parametrize(("levels", "few"), [(0, 600), (0, -1), (3, -1)])
def test_edge_is_placed_within_a_hundredth_of_a_taxel_aligned_or_not(levels, few):
    skin = skin_of(LTS)
    felt = MeshGap(solid(split(trimesh.creation.box((40.0, 40.0, 40.0)), levels)), skin, 3.0, few)
    for angle, offset, where in edge_poses(100, np.random.default_rng(1)):
        felt.feel(where[None])
        share = felt.modes[0] / 0.5
        assert np.abs((share - edge_share(angle, offset, skin)).sum(axis=1)).max() < 0.01


def test_edge_is_placed_within_a_hundredth_of_a_taxel_after_the_spread(block):
    sigma, z0 = LTS.elastomer.spread, 0.5
    node, weight = np.polynomial.legendre.leggauss(6)
    x = (LTS.array.x[:, None] + 0.9 * node).ravel()
    y = (LTS.array.y[:, None] + 0.9 * node).ravel()
    from scipy.stats import norm

    def mean(values):
        return np.einsum("rjci,i,j->rc", values.reshape(10, 6, 16, 6), weight, weight) / 4

    inner = (slice(2, -2), slice(2, -2))
    for angle, offset, where in edge_poses(60, np.random.default_rng(2)):
        felt = pressure(indentation(block, where, LTS), LTS) / LTS.elastomer.stiffness
        distance = -offset - np.cos(angle) * x[None, :] + np.sin(angle) * y[:, None]
        exact = z0 * mean(norm.cdf(distance / sigma))[inner]
        slope = z0 * mean(norm.pdf(distance / sigma) / sigma)[inner]
        shift = ((felt[inner] - exact) * slope).sum() / (slope**2).sum()
        assert abs(shift) < 0.01 * 1.8
        assert np.abs(felt[inner] - exact).max() < 0.003 * z0


def test_drawing_and_casting_agree_on_tilted_corners(block):
    rng = np.random.default_rng(3)
    skin = skin_of(LTS)
    for _ in range(30):
        turn = rotation_exp([0, 0, rng.uniform(-3, 3)]) @ rotation_exp([*rng.uniform(-0.05, 0.05, 2), 0])
        where = pose(DOWN @ turn, [*rng.uniform(14, 22, 2), 19.4])[None]
        drawn, cast = MeshGap(block, skin, 3.0), MeshGap(block, skin, 3.0, few=-1)
        drawn.feel(where)
        cast.feel(where)
        assert np.abs(drawn.modes - cast.modes).max() < 1e-4


@pytest.mark.parametrize("sections", [24, 200])
def test_rim_and_side_of_a_cylinder_agree_with_dense_sampling(sections):
    cylinder = solid(trimesh.creation.cylinder(15.0, 40.0, sections=sections))
    skin = skin_of(LTS)
    side = np.array([[0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]])
    for where in (
        pose(DOWN @ rotation_exp([0.02, 0.01, 0.6]), [12.0, 3.0, 19.5]),
        pose(side @ rotation_exp([0.0, 0.0, 0.5]), [14.6, 0.4, 3.0]),
    ):
        exact, sampled = gap(cylinder, LTS), SampledGap(cylinder, skin, 3.0)
        exact.feel(where[None])
        sampled.feel(where[None])
        assert np.abs(exact.modes[0] - sampled.modes[0]).max() < 0.02
        assert (exact.modes[0] - sampled.modes[0]).sum() == pytest.approx(0.0, abs=0.05)


def test_flat_press_makes_k_a_d(block):
    felt = indentation(block, pose(DOWN, [1.0, 2.0, 19.6]), LTS)
    width, height = LTS.array.size
    assert -wrench(felt, LTS)[2] == pytest.approx(0.1 * width * height * 0.4, rel=1e-3)
    assert np.abs(wrench(felt, LTS)[3:]).max() < 1e-6
    assert pressure(felt, LTS) == pytest.approx(np.full((10, 16), 0.04), rel=1e-6)


def test_tilted_press_has_the_moment_of_its_wedge(block):
    tilt, (width, height) = 0.01, LTS.array.size
    felt = indentation(block, pose(DOWN @ rotation_exp([0, tilt, 0]), [0.0, 0.0, 19.5]), LTS)
    expected = 0.1 * np.tan(tilt) * height * width**3 / 12
    assert abs(wrench(felt, LTS)[4]) == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize(("subdivisions", "radius"), [(5, 20.0), (6, 40.0), (6, 30.0)])
def test_sphere_force_is_the_winkler_integral(subdivisions, radius):
    ball = solid(trimesh.creation.icosphere(subdivisions, radius))
    depth = 0.6
    height = float(ball.vertices[:, 2].max())
    felt = indentation(ball, pose(DOWN, [0.2, 0.1, height - depth]), LTS)
    exact = 0.1 * np.pi * (radius * depth**2 - depth**3 / 3)
    assert -wrench(felt, LTS, whole_skin=True)[2] == pytest.approx(exact, rel=0.02)


def test_spread_moves_pressure_but_makes_and_loses_none(block):
    felt = indentation(block, pose(DOWN @ rotation_exp([0, 0, 0.4]), [19.0, 1.0, 19.5]), LTS)
    skin = skin_of(LTS)
    widths = np.diff(skin.x_edges)
    reached = (skin.spread_x[0] * 1.8).sum(axis=0) / widths
    assert reached[4:-4] == pytest.approx(np.ones(len(reached) - 8), abs=1e-6)
    assert pressure(felt, LTS).max() <= 0.05 * 1.001


def test_many_poses_at_once_are_the_poses_one_by_one(block):
    poses = np.stack([w for _, _, w in edge_poses(6, np.random.default_rng(4))]).reshape(2, 3, 4, 4)
    many = indentation(block, poses, LTS)
    assert many.depth.shape == (2, 3, *skin_of(LTS).shape)
    assert many.modes[1, 2] == pytest.approx(indentation(block, poses[1, 2], LTS).modes)


def test_overhang_in_view_is_not_counted_twice():
    upper = trimesh.creation.box((10.0, 40.0, 1.0), pose(None, [0.0, 0.0, 0.5]))
    lower = trimesh.creation.box((40.0, 40.0, 1.0), pose(None, [0.0, 0.0, -0.7]))
    both = trimesh.util.concatenate([upper, lower])
    felt = indentation(solid(both), pose(DOWN, [0.0, 0.0, -0.5]), LTS)
    assert felt.depth.max() == pytest.approx(1.5, abs=0.01)
    assert felt.depth[5].min() == pytest.approx(0.0, abs=0.35)


def test_pin_between_the_rays_is_felt():
    pin = trimesh.creation.box((0.8, 0.8, 10.0), pose(None, [0.9, 0.0, 0.0]))
    felt = indentation(solid(pin), pose(DOWN, [0.0, 0.0, 4.5]), LTS)
    assert -wrench(felt, LTS)[2] == pytest.approx(0.1 * 0.64 * 0.5, rel=1e-6)


def test_nothing_is_felt_from_behind_the_sensor(block):
    felt = indentation(block, pose(np.eye(3), [0.0, 0.0, 70.0]), LTS)
    assert felt.depth.max() == 0.0
    assert felt.deepest == 0.0


@pytest.mark.parametrize("few", [600, -1])
def test_each_row_of_a_scan_feels_the_pose_of_its_own_time(few):
    surface, skin = solid(trimesh.creation.cylinder(20.0, 40.0, sections=150)), skin_of(LTS)
    start = pose(DOWN @ rotation_exp([0.01, 0.01, 0.3]), [19.0, 1.0, 19.5])
    steps = np.linspace(0.0, 1.0, 2 * skin.shape[0] + 1)
    poses = np.stack(
        [start @ pose(rotation_exp([0, 0, 0.02 * s]), [0.4 * s, 0.3 * s, 0.05 * s]) for s in steps]
    )
    scanned, still = MeshGap(surface, skin, 3.0, few), MeshGap(surface, skin, 3.0, few)
    scanned.feel(poses)
    for r in range(skin.shape[0]):
        still.feel(poses[2 * r + 1][None])
        assert np.abs(scanned.modes[0, r] - still.modes[0, r]).max() < (2e-3 if few < 0 else 1e-9)


def test_rays_that_graze_the_outline_of_a_ball_press_nothing():
    ball = solid(trimesh.creation.icosphere(subdivisions=5, radius=15.0))
    skin, at = skin_of(LTS), pose(DOWN @ rotation_exp([0.1, 0.2, 0.3]), [0.0, 0.0, 14.5])
    felt = MeshGap(ball, skin, LTS.elastomer.thickness, few=0)
    away = ball.body.triangle_normals @ at[:3, 2]
    folds = np.argwhere((away[:, None] >= 0.0) & (away[ball.neighbors] < 0.0))[:200]
    for t, i in folds:
        ends = ball.vertices[[ball.triangles[t, i], ball.triangles[t, (i + 1) % 3]]]
        corner = np.array([skin.x_edges[3], skin.y_edges[4], 0.0])
        shift = at[:3, :3].T @ (ends.mean(axis=0) - at[:3, 3]) - corner
        over = at @ pose(translation=[shift[0], shift[1], 0.0])
        assert felt.feel(over[None]) < 2.0, (t, i)


@pytest.mark.parametrize("sections", [60, 280])
def test_a_small_boss_of_many_sides_presses_like_the_polygon_it_is(sections):
    boss = solid(trimesh.creation.cylinder(1.0, 20.0, sections=sections))
    felt = indentation(boss, pose(DOWN, [0.3, 0.2, 9.5]), LTS)
    area = sections / 2 * np.sin(2 * np.pi / sections)
    assert (felt.depth * skin_of(LTS).areas).sum() == pytest.approx(0.5 * area, rel=1e-6)


@pytest.mark.parametrize(("subdivisions", "radius"), [(6, 15.0), (7, 40.0)])
def test_a_ball_is_felt_as_its_dome_blurred(subdivisions, radius):
    """Cells inside the contact are not flat: as steps they would blur the dome by a taxel's width more."""
    ball, step, at = solid(trimesh.creation.icosphere(subdivisions, radius)), 0.1, np.array([0.4, -0.3])
    where = pose(DOWN, [-at[0], at[1], radius - 0.5])
    felt = pressure(indentation(ball, where, LTS), LTS) / LTS.elastomer.stiffness
    fine = (np.arange(480) + 0.5) * step - 24.0
    away = np.hypot(fine[:, None] - at[1], fine - at[0])
    dome = np.maximum(0.0, 0.5 - radius + np.sqrt(np.maximum(0.0, radius**2 - away**2)))
    blurred = gaussian_filter(dome, LTS.elastomer.spread / step, truncate=5)
    first = [np.rint((line - 0.9 + 24.0) / step).astype(int) for line in (LTS.array.y, LTS.array.x)]
    exact = np.array([[blurred[i : i + 18, j : j + 18].mean() for j in first[1]] for i in first[0]])
    np.testing.assert_allclose(felt, exact, atol=0.002)
