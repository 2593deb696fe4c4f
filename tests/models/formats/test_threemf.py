import io
import zipfile

import numpy as np
import pytest
import trimesh

from models.formats import threemf
from models.part import load_part
from primitives.errors import PalpateError

BOX = trimesh.creation.box((20, 30, 40))
CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"
RELATION = (
    '<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship '
    'Target="{}" Id="r" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>'
)
ITEM = '<item objectid="1"/>'


def mesh_object(number, mesh=BOX, name=""):
    vertices = "".join(f'<vertex x="{x}" y="{y}" z="{z}"/>' for x, y, z in mesh.vertices)
    triangles = "".join(f'<triangle v1="{a}" v2="{b}" v3="{c}"/>' for a, b, c in mesh.faces)
    inner = f"<mesh><vertices>{vertices}</vertices><triangles>{triangles}</triangles></mesh>"
    return f'<object id="{number}" name="{name}" type="model">{inner}</object>'


def model(objects, items=ITEM, unit="millimeter"):
    inner = f"<resources>{objects}</resources><build>{items}</build>"
    return f'<?xml version="1.0"?><model unit="{unit}" xmlns="{CORE}">{inner}</model>'


def archive(text, target="/3D/3dmodel.model", **others):
    held = io.BytesIO()
    with zipfile.ZipFile(held, "w", zipfile.ZIP_DEFLATED) as files:
        files.writestr("_rels/.rels", RELATION.format(target))
        if text is not None:
            files.writestr("3D/3dmodel.model", text)
        for name, content in others.items():
            files.writestr(name, content)
    return held.getvalue()


def load(tmp_path, data, **how):
    (tmp_path / "part.3mf").write_bytes(data)
    return load_part(tmp_path / "part.3mf", **how)


@pytest.mark.parametrize(("unit", "factor"), [("millimeter", 1), ("centimeter", 10), ("inch", 25.4)])
def test_the_unit_of_the_file_holds(tmp_path, unit, factor) -> None:
    part = load(tmp_path, archive(model(mesh_object(1), unit=unit)))
    assert part.solid.extent == pytest.approx(np.array([20, 30, 40]) * factor)


def test_components_are_placed_within_items(tmp_path) -> None:
    turned = '<component objectid="1" transform="0 1 0 -1 0 0 0 0 1 5 0 0"/>'
    objects = mesh_object(1) + f'<object id="2"><components>{turned}</components></object>'
    item = '<item objectid="2" transform="1 0 0 0 1 0 0 0 1 100 0 0"/>'
    part = load(tmp_path, archive(model(objects, item)))
    assert part.solid.bounds == pytest.approx(np.array([[90, -10, -20], [120, 10, 20]]))


def test_a_mirrored_object_still_faces_out(tmp_path) -> None:
    item = '<item objectid="1" transform="-1 0 0 0 1 0 0 0 1 0 0 0"/>'
    part = load(tmp_path, archive(model(mesh_object(1), item)))
    assert part.solid.volume == pytest.approx(24000)
    assert part.warnings == ()


@pytest.mark.parametrize("kind", ["support", "solidsupport"])
def test_what_a_printer_adds_to_hold_the_part_is_no_body(tmp_path, kind) -> None:
    held = mesh_object(2, trimesh.creation.box((5, 5, 5))).replace('type="model"', f'type="{kind}"')
    part = load(tmp_path, archive(model(mesh_object(1) + held, ITEM + '<item objectid="2"/>')))
    assert part.solid.volume == pytest.approx(24000)
    assert part.warnings == ()


@pytest.mark.parametrize("target", ["/3D/My%20Part.model", "/3d/my part.MODEL"])
def test_the_model_is_found_however_its_name_is_written(tmp_path, target) -> None:
    data = archive(None, target, **{"3D/My Part.model": model(mesh_object(1))})
    assert load(tmp_path, data).solid.volume == pytest.approx(24000)


def test_objects_are_bodies_with_names(tmp_path) -> None:
    small = trimesh.creation.box((5, 5, 20))
    data = archive(
        model(mesh_object(1, BOX, "base plate") + mesh_object(2, small, "pin"), ITEM + '<item objectid="2"/>')
    )
    with pytest.raises(PalpateError, match=r"2 bodies.*1 base plate \(20 x 30 x 40 mm\), 2 pin"):
        load(tmp_path, data)
    assert load(tmp_path, data, body=2).solid.volume == pytest.approx(500)


def test_an_archive_that_inflates_past_a_gigabyte_is_refused_unopened(tmp_path, monkeypatch) -> None:
    held = io.BytesIO()
    with (
        zipfile.ZipFile(held, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as files,
        files.open("3D/3dmodel.model", "w") as file,
    ):
        for _ in range(3):
            file.write(bytes(1 << 20))
    monkeypatch.setattr(threemf, "MOST_INFLATED", 2_000_000)
    monkeypatch.setattr(zipfile.ZipFile, "read", lambda *_: pytest.fail("was inflated"))
    with pytest.raises(PalpateError, match="would inflate"):
        load(tmp_path, held.getvalue())


CYCLE = '<object id="1"><components><component objectid="1"/></components></object>'
DOUBLING = "".join(
    f'<object id="{i}"><components>{f"<component objectid={chr(34)}{i - 1}{chr(34)}/>" * 10}</components></object>'
    for i in range(2, 12)
)
BROKEN = {
    "no model": (archive(None), "which is not in it"),
    "leaves the archive": (
        archive(model(mesh_object(1)), "../../../etc/passwd"),
        "'etc/passwd', which is not",
    ),
    "cycle": (archive(model(CYCLE)), "without end"),
    "a component bomb": (
        archive(model(mesh_object(1) + DOUBLING, '<item objectid="11"/>')),
        "more than 1000 meshes",
    ),
    "entities": (
        archive('<!DOCTYPE m [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;&a;">]>' + model(mesh_object(1))),
        "broken XML or not 3MF",
    ),
    "cut": (archive(model(mesh_object(1)))[:400], "not a whole 3MF"),
    "cut inside": (archive("<model><resources>"), "broken XML"),
    "unknown unit": (archive(model(mesh_object(1), unit="parsec")), "parsec"),
    "corners not there": (archive(model(mesh_object(1).replace('v1="0"', 'v1="99"'))), "do not exist"),
    "not a number": (archive(model(mesh_object(1).replace('x="10.0"', 'x="nan"'))), "not finite"),
    "nothing to build": (archive(model(mesh_object(1), "")), "none of its objects"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_what_is_wrong_is_one_line(tmp_path, case) -> None:
    data, says = BROKEN[case]
    with pytest.raises(PalpateError, match=says) as caught:
        load(tmp_path, data)
    assert "\n" not in str(caught.value)
    assert [entry.name for entry in tmp_path.iterdir()] == ["part.3mf"]
