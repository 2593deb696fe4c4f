from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

from models import parts
from models.formats import mesh
from models.formats.units import Units
from models.part import load_part
from models.solid import Solid, iou
from primitives.errors import PalpateError
from primitives.pose import pose

LEGO_STYLE = """OFF
8 6 0

# x y z
0 0 0
20 0 0
20 30 0
0 30 0   # a corner

0 0 40
20 0 40
20 30 40
0 30 40

4  3 2 1 0
4  4 5 6 7 255 0 0
4  0 1 5 4
3  1 2 6

3  1 6 5
4  2 3 7 6
4  3 0 4 7
# leave the last line empty

""".replace("8 6 0", "8 7 0")


@pytest.mark.parametrize("suffix", [".stl", ".ply", ".glb", ".STL", ".Glb"])
def test_what_is_written_is_read_again(tmp_path: Path, suffix: str) -> None:
    solid = Solid.from_csg(parts.build("bracket"))
    mesh.save(solid, tmp_path / f"part{suffix}")
    part = load_part(tmp_path / f"part{suffix}")
    assert part.name == "part"
    assert part.warnings == ()
    assert iou(part.solid, solid) == pytest.approx(1, abs=1e-5)
    assert [file.name for file in tmp_path.iterdir()] == [f"part{suffix}"]


def test_a_mesh_is_written_where_it_is_placed(tmp_path: Path) -> None:
    placed = Solid.from_csg(parts.build("block")).placed(pose(None, (100, 0, 0)))
    mesh.save(placed, tmp_path / "part.stl")
    np.testing.assert_allclose(load_part(tmp_path / "part.stl").solid.bounds, placed.bounds, atol=1e-5)


@pytest.mark.parametrize("suffix", ["stl", "obj", "ply", "off", "glb", "stl_ascii"])
def test_meshes_of_other_writers_are_read(tmp_path: Path, suffix: str) -> None:
    box = trimesh.creation.box((20, 30, 40))
    if suffix == "glb":
        box.apply_scale(0.001)
    file = tmp_path / f"box.{suffix[:3].upper()}"
    file.write_bytes(data if isinstance(data := box.export(file_type=suffix), bytes) else data.encode())
    part = load_part(file)
    np.testing.assert_allclose(part.solid.extent, [20, 30, 40], rtol=1e-5)
    assert part.solid.volume == pytest.approx(24000, rel=1e-5)


def test_off_with_comments_blank_lines_and_polygons_is_read(tmp_path: Path) -> None:
    (tmp_path / "box.off").write_text(LEGO_STYLE)
    assert load_part(tmp_path / "box.off").solid.volume == pytest.approx(24000)


def test_obj_with_places_counted_back_tabs_comments_and_lines_that_go_on_is_read(tmp_path: Path) -> None:
    box = trimesh.creation.box((20, 30, 40))
    lines = ["# box", "mtllib none.mtl", "vn 0 0 1"]
    for a, b, c in box.triangles:
        lines += ["v\t{}  {} {} 1.0 # w".format(*corner) for corner in (a, b, c)]
        lines += ["f -3//-1 \\", "  -2//-1\t-1//-1"]
    (tmp_path / "box.obj").write_text("\n".join(lines))
    assert load_part(tmp_path / "box.obj").solid.volume == pytest.approx(24000)


@pytest.mark.parametrize("first", range(6))
@pytest.mark.parametrize("suffix", ["obj", "off", "ply"])
def test_a_face_that_is_not_convex_is_whole_wherever_its_corners_begin(
    tmp_path: Path, suffix: str, first: int
) -> None:
    ring = [(0, 0), (20, 0), (20, 10), (10, 10), (10, 20), (0, 20)]
    points = [(x, y, z) for z in (0, 10) for x, y in ring]
    low, top = [[(first - i) % 6 for i in range(6)], [6 + (first + i) % 6 for i in range(6)]]
    sides = [[i, (i + 1) % 6, (i + 1) % 6 + 6, i + 6] for i in range(6)]
    (tmp_path / f"part.{suffix}").write_text(_polygons(suffix, points, [low, top, *sides]))
    solid = load_part(tmp_path / f"part.{suffix}").solid
    assert (solid.volume, solid.area) == pytest.approx((3000, 1400))


def _polygons(suffix: str, points: list, faces: list) -> str:
    rows = [" ".join(map(str, point)) for point in points]
    if suffix == "obj":
        return "\n".join(
            [f"v {row}" for row in rows] + ["f " + " ".join(str(i + 1) for i in f) for f in faces]
        )
    body = "\n".join(rows + [f"{len(face)} " + " ".join(map(str, face)) for face in faces]) + "\n"
    if suffix == "off":
        return f"OFF\n{len(points)} {len(faces)} 0\n{body}"
    axes = "".join(f"property double {axis}\n" for axis in "xyz")
    lists = f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    return f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n{axes}{lists}{body}"


@pytest.mark.parametrize("changed", [str.upper, lambda text: text.replace("\n", "\r"), str])
def test_text_of_old_writers_is_read_with_names_in_any_code(tmp_path: Path, changed: Callable) -> None:
    box = trimesh.creation.box((20, 30, 40))
    text = trimesh.exchange.stl.export_stl_ascii(box).replace("solid", "solid Stück")
    (tmp_path / "part.stl").write_bytes(changed(text).encode("latin-1"))
    points = "\n".join(f"v {x} {y} {z}" for x, y, z in box.vertices)
    faces = "\n".join(f"f {a} {b} {c}" for a, b, c in box.faces + 1)
    (tmp_path / "part.obj").write_bytes(f"o Stück\n{points}\n{faces}\n".encode("latin-1"))
    for name in ("part.stl", "part.obj"):
        assert load_part(tmp_path / name).solid.volume == pytest.approx(24000)


def test_triangles_that_meet_side_to_part_of_a_side_are_stitched(tmp_path: Path) -> None:
    text = LEGO_STYLE.replace("8 7 0", "9 9 0").replace("0 30 40\n\n", "0 30 40\n10 0 0\n")
    (tmp_path / "box.off").write_text(text.replace("4  3 2 1 0", "3 3 2 8\n3 2 1 8\n3 0 3 8"))
    part = load_part(tmp_path / "box.off")
    assert part.solid.volume == pytest.approx(24000)


def test_inward_triangles_are_turned_and_said(tmp_path: Path) -> None:
    box = trimesh.creation.box((20, 30, 40))
    box.faces[3:7] = box.faces[3:7, ::-1]
    box.export(tmp_path / "box.stl")
    part = load_part(tmp_path / "box.stl")
    assert part.solid.volume == pytest.approx(24000)
    assert "inward" in part.warnings[0]


@pytest.mark.parametrize(("units", "factor"), [("mm", 1), ("cm", 10), ("m", 1000), ("in", 25.4)])
def test_units_and_scale_multiply(tmp_path: Path, units: Units, factor: float) -> None:
    trimesh.creation.box(np.full(3, 40 / factor)).export(tmp_path / "box.stl")
    assert load_part(tmp_path / "box.stl", units, 2).solid.extent == pytest.approx([80, 80, 80], rel=1e-5)


def test_an_implausible_size_is_warned_about_once(tmp_path: Path) -> None:
    trimesh.creation.box((3, 2, 2)).export(tmp_path / "box.stl")
    (warning,) = load_part(tmp_path / "box.stl").warnings
    assert "--units in" in warning
    assert load_part(tmp_path / "box.stl", "mm").warnings == ()


@pytest.mark.parametrize("wrong", [{"units": "furlong"}, {"scale": 0.0}, {"scale": float("nan")}])
def test_unknown_units_and_scales_are_refused(tmp_path: Path, wrong: dict) -> None:
    trimesh.creation.box((30, 20, 20)).export(tmp_path / "box.stl")
    with pytest.raises(PalpateError):
        load_part(tmp_path / "box.stl", **wrong)


def test_an_unwritable_place_leaves_nothing(tmp_path: Path) -> None:
    solid = Solid.from_csg(parts.build("block"))
    with pytest.raises(PalpateError, match="cannot write"):
        mesh.save(solid, tmp_path / "gone" / "part.stl")
    with pytest.raises(PalpateError, match="cannot write"):
        mesh.save(solid, tmp_path / "part.xyz")
    assert not list(tmp_path.iterdir())
