import base64
import json
import struct

import numpy as np
import pytest
import trimesh

from models.part import load_part
from primitives.errors import PalpateError

BOX = trimesh.creation.box((0.02, 0.03, 0.04))  # [m]
DATA = BOX.vertices.astype("<f4").tobytes() + BOX.faces.astype("<u4").tobytes()


def scene(**changed):
    return {
        "asset": {"version": "2.0"},
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5125, "count": 36, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteLength": 96},
            {"buffer": 0, "byteOffset": 96, "byteLength": 144},
        ],
        "buffers": [{"byteLength": 240}],
    } | changed


def glb(tree):
    text = json.dumps(tree).encode()
    text += b" " * (-len(text) % 4)
    head = struct.pack("<4sIII4s", b"glTF", 2, 28 + len(text) + len(DATA), len(text), b"JSON")
    return head + text + struct.pack("<I4s", len(DATA), b"BIN\0") + DATA


def load(tmp_path, data, name="part.glb", **how):
    (tmp_path / name).write_bytes(data)
    return load_part(tmp_path / name, **how)


def test_lengths_are_meters_unless_told(tmp_path) -> None:
    part = load(tmp_path, glb(scene()))
    assert part.solid.extent == pytest.approx([20, 30, 40], rel=1e-6)
    assert part.warnings == ()
    assert load(tmp_path, glb(scene()), units="in", scale=1000).solid.extent[0] == pytest.approx(508)


def test_nodes_are_bodies_placed_where_they_stand(tmp_path) -> None:
    nodes = [
        {"name": "left", "mesh": 0},
        {"name": "right", "translation": [0.1, 0, 0], "children": [2]},
        {"mesh": 0, "rotation": [0, 0, np.sqrt(0.5), np.sqrt(0.5)], "scale": [-2, 1, 1]},
    ]
    data = glb(scene(nodes=nodes, scenes=[{"nodes": [0, 1]}]))
    with pytest.raises(PalpateError, match=r"1 left .*2 right \(30 x 40 x 40 mm\)"):
        load(tmp_path, data)
    right = load(tmp_path, data, body=2)
    assert right.solid.bounds.mean(axis=0) == pytest.approx([100, 0, 0], abs=1e-4)
    assert right.warnings == ()


def test_a_gltf_reads_buffers_from_its_text_and_its_folder_only(tmp_path) -> None:
    inside = {"uri": "data:application/octet-stream;base64," + base64.b64encode(DATA).decode()}
    assert load(tmp_path, json.dumps(scene(buffers=[inside])).encode(), "a.gltf").solid.volume > 23999
    (tmp_path / "part.bin").write_bytes(DATA)
    beside = json.dumps(scene(buffers=[{"uri": "part.bin"}])).encode()
    assert load(tmp_path, beside, "b.gltf").solid.volume > 23999
    for outside in ("../part.bin", "/etc/passwd", "file:///etc/passwd", "sub/part.bin"):
        with pytest.raises(PalpateError, match="outside its folder"):
            load(tmp_path, json.dumps(scene(buffers=[{"uri": outside}])).encode(), "c.gltf")


def _with(where, **changed):
    tree = scene()
    tree[where][1 if where == "accessors" else 0] |= changed
    return tree


BROKEN = {
    "huge count": (_with("accessors", count=4_000_000_000), "announces more data"),
    "negative count": (_with("accessors", count=-36), "announces more data"),
    "negative place": (_with("bufferViews", byteOffset=-96), "not a whole glTF"),
    "past the end": (_with("bufferViews", byteOffset=200), "not a whole glTF"),
    "corner not there": (_with("accessors", bufferView=0), "do not exist"),
    "node in itself": (scene(nodes=[{"mesh": 0, "children": [0]}]), "not a whole glTF"),
    "nodes without end": (
        scene(nodes=[*({"children": [i + 1] * 10} for i in range(20)), {"name": "end"}]),
        "not a whole glTF",
    ),
    "compressed": (scene(extensionsRequired=["KHR_draco_mesh_compression"]), "without compression"),
    "empty": (scene(nodes=[{}]), "no faces"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_what_is_wrong_is_one_line(tmp_path, case) -> None:
    tree, says = BROKEN[case]
    with pytest.raises(PalpateError, match=says) as caught:
        load(tmp_path, glb(tree))
    assert "\n" not in str(caught.value)
