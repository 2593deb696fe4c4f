"""Meshes as people send them: what can be mended is mended and said, what cannot is refused."""

import numpy as np
import pytest
import trimesh

from models.csg import Cube
from models.formats import mesh
from models.formats.holes import filled
from models.part import load_part
from models.solid import Solid
from primitives.errors import PalpateError
from primitives.pose import pose, rotation_exp

BOX = trimesh.creation.box((20, 30, 40))
PIPE = trimesh.creation.annulus(5, 10, 20)


def load(tmp_path, corners, **how):
    corners = np.asarray(corners, dtype=float)
    mesh = trimesh.Trimesh(corners.reshape(-1, 3), np.arange(corners.size // 3).reshape(-1, 3), process=False)
    mesh.export(tmp_path / "part.stl")
    return load_part(tmp_path / "part.stl", **how)


def skin(cells):
    """The triangles between cells of 20 mm and what is empty beside them."""
    cube = trimesh.creation.box((20, 20, 20))
    around = np.round(cube.face_normals).astype(int)
    return np.concatenate(
        [
            cube.triangles[[tuple(np.add(cell, out)) not in cells for out in around]] + 20 * np.array(cell)
            for cell in cells
        ]
    )


def test_a_missing_flat_face_is_filled_and_said(tmp_path) -> None:
    part = load(tmp_path, BOX.triangles[BOX.face_normals[:, 2] < 0.5])
    assert part.solid.volume == pytest.approx(24000)
    assert "1 hole with 4 open edges" in part.warnings[0]


def test_a_ring_between_two_rims_is_filled_and_its_bore_stays_open(tmp_path) -> None:
    part = load(tmp_path, PIPE.triangles[PIPE.face_normals[:, 2] < 0.5])
    assert part.solid.volume == pytest.approx(PIPE.volume, rel=1e-6)
    assert part.solid.genus == 1


def test_a_large_rim_that_is_not_flat_is_refused(tmp_path) -> None:
    ball = trimesh.creation.icosphere(3, 20)
    kept = ~((ball.triangles_center[:, 0] > 2) & (ball.triangles_center[:, 1] > 2))
    with pytest.raises(PalpateError, match="open edges; repair"):
        load(tmp_path, ball.triangles[kept])


def test_doubled_triangles_are_left_out_and_said(tmp_path) -> None:
    part = load(tmp_path, np.concatenate([BOX.triangles, BOX.triangles[:3]]))
    assert part.solid.volume == pytest.approx(24000)
    assert "3 doubled" in part.warnings[0]


def test_what_is_inside_out_is_turned_and_its_cavity_stays(tmp_path) -> None:
    hollow = np.concatenate([BOX.triangles, BOX.triangles[:, ::-1] * 0.5])
    assert load(tmp_path, hollow).warnings == ()
    part = load(tmp_path, hollow[:, ::-1])
    assert part.solid.volume == pytest.approx(24000 * 7 / 8)
    assert "inward" in part.warnings[0]


def test_a_shell_that_faces_out_inside_the_material_adds_nothing(tmp_path) -> None:
    part = load(tmp_path, np.concatenate([BOX.triangles, BOX.triangles * 0.5]))
    assert part.solid.volume == pytest.approx(24000)
    assert "inside its material" in part.warnings[0]


def test_two_solids_that_share_an_edge_are_two_bodies(tmp_path) -> None:
    pair = np.concatenate([BOX.triangles, BOX.triangles + np.array([20, 30, 0])])
    with pytest.raises(PalpateError, match="holds 2 bodies, choose one with --body"):
        load(tmp_path, pair)
    assert load(tmp_path, pair, body=2).solid.volume == pytest.approx(24000)


def test_one_solid_that_touches_itself_along_an_edge_is_one_body(tmp_path) -> None:
    cells = [(0, 0, 0), (0, 0, 1), (0, 1, 1), (1, 1, 1), (1, 1, 0)]
    assert load(tmp_path, skin(cells)).solid.volume == pytest.approx(5 * 8000)


def test_a_cavity_that_touches_the_skin_along_an_edge_stays_a_cavity(tmp_path) -> None:
    empty = {(1, 1, 1), (0, 0, 0), (0, 0, 1), (0, 0, 2)}
    cells = [cell for cell in np.ndindex(3, 3, 3) if cell not in empty]
    assert load(tmp_path, skin(cells)).solid.volume == pytest.approx(23 * 8000)


def test_a_body_inside_a_cavity_is_another_body(tmp_path) -> None:
    caged = np.concatenate([BOX.triangles, BOX.triangles[:, ::-1] * 0.5, BOX.triangles * 0.25])
    with pytest.raises(PalpateError, match="2 bodies"):
        load(tmp_path, caged)
    assert load(tmp_path, caged, body=2).solid.volume == pytest.approx(24000 / 64)


def test_pieces_that_overlap_are_united_and_said(tmp_path) -> None:
    part = load(tmp_path, np.concatenate([BOX.triangles, BOX.triangles + np.array([10, 0, 0])]))
    assert part.solid.volume == pytest.approx(36000)
    assert "overlap" in part.warnings[0]


def test_pieces_apart_are_bodies(tmp_path) -> None:
    apart = np.concatenate([BOX.triangles, BOX.triangles * 0.5 + np.array([100, 0, 0])])
    with pytest.raises(PalpateError, match=r"2 bodies.*1 \(20 x 30 x 40 mm\), 2 \(10 x 15 x 20 mm\)"):
        load(tmp_path, apart)
    assert load(tmp_path, apart, body=1).solid.volume == pytest.approx(24000)


def test_a_splinter_beside_a_body_is_left_out_and_said(tmp_path) -> None:
    splinter = BOX.triangles * [0.1, 0.2, 0.0003] + np.array([50, 0, 0])
    part = load(tmp_path, np.concatenate([BOX.triangles, splinter]))
    assert part.solid.volume == pytest.approx(24000)
    assert "a splinter" in part.warnings[0]


def test_a_small_body_that_is_no_splinter_is_a_body(tmp_path) -> None:
    crumb = np.concatenate([BOX.triangles, BOX.triangles * 0.03 + np.array([50, 0, 0])])
    with pytest.raises(PalpateError, match="2 bodies"):
        load(tmp_path, crumb)


def test_a_thin_disc_beside_a_large_plate_is_a_body(tmp_path) -> None:
    disc = trimesh.creation.cylinder(5, 0.29).triangles + np.array([0, 0, 30])
    with pytest.raises(PalpateError, match="2 bodies"):
        load(tmp_path, np.concatenate([trimesh.creation.box((300, 200, 10)).triangles, disc]))


def test_sheets_alike_are_bodies_however_thin(tmp_path) -> None:
    sheets = BOX.triangles * [1, 1, 0.0005]
    with pytest.raises(PalpateError, match="2 bodies"):
        load(tmp_path, np.concatenate([sheets, sheets + np.array([0, 0, 10])]))


def test_a_surface_through_itself_is_refused(tmp_path) -> None:
    bar = trimesh.creation.box((10, 10, 60)).subdivide().subdivide().subdivide()
    points = bar.vertices.copy()
    folded = points[:, 2] > 0
    points[folded] = points[folded] * [1, 1, -0.3] + np.outer(points[folded, 2], [0.4, 0, 0]) - [3, 0, 0]
    with pytest.raises(PalpateError, match="passes through itself"):
        load(tmp_path, points[bar.faces])


def test_slivers_in_a_plane_change_nothing(tmp_path) -> None:
    """A fan from a side's middle, its triangles as thin as single precision can hold."""
    corners = [t for t in BOX.triangles if not np.allclose(t[:, 0], 10)]
    rim = np.array([[10, -15, -20], [10, 15, -20], [10, 15, 20], [10, -15, 20]], dtype=float)
    near = np.array([10, -15 + 1e-5, 1e-5])
    fan = [[rim[i], rim[(i + 1) % 4], near] for i in range(4)]
    part = load(tmp_path, [*corners, *fan])
    assert part.solid.volume == pytest.approx(24000)


def test_a_web_thinner_than_single_precision_tells_stays_as_it_is(tmp_path) -> None:
    """A slot that comes out of a side by a tenth of a micrometer less at an end: no rim to fill anew."""
    tilt = 1e-4
    slot = Cube((12, 6, 40)).placed(pose(rotation_exp([tilt, 0, 0]), [5, 23 + 0.45 * 15.6 * tilt, 0]))
    solid = Solid.from_csg((Cube((78, 52, 15.6)) - slot).placed(pose(rotation_exp([0, 0.5, 0.7]))))
    mesh.save(solid, tmp_path / "part.stl")
    assert load_part(tmp_path / "part.stl").solid.volume == pytest.approx(solid.volume, rel=1e-6)


def test_a_sheet_folded_on_itself_is_refused(tmp_path) -> None:
    sheet = BOX.triangles[:2]
    with pytest.raises(PalpateError, match="folded flat"):
        load(tmp_path, np.concatenate([sheet, sheet[:, ::-1]]))


def test_a_sheet_without_thickness_beside_a_solid_is_left_out(tmp_path) -> None:
    a, b, c, d = np.array([[30.0, 0, 0], [50.0, 0, 0], [50.0, 20.0, 0], [30.0, 20.0, 0]])
    sheet = [[a, b, c], [a, c, d], [a, d, b], [b, d, c]]  # both its sides, cut along different diagonals
    part = load(tmp_path, [*BOX.triangles, *sheet])
    assert part.solid.volume == pytest.approx(24000)
    assert part.solid.bounds[1][0] == pytest.approx(10.0)


def test_a_soup_of_triangles_is_refused(tmp_path) -> None:
    soup = np.random.default_rng(0).normal(size=(3000, 3, 3)) * 50
    with pytest.raises(PalpateError, match="9000 open edges"):
        load(tmp_path, soup)


def test_an_open_run_that_comes_to_a_dead_end_is_not_filled() -> None:
    corners = np.array([[0, 0, 0], [4, 0, 0], [2, 3, 0], [2, -1, 3], [2, -1, -3]], dtype=float)
    three_at_one_edge = np.array([[0, 1, 2], [0, 1, 3], [1, 0, 4]])
    patch, holes = filled(corners, three_at_one_edge)
    assert not len(patch)
    assert holes == 2
