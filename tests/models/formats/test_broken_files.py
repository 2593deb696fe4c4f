import gzip
import os
import struct
import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import trimesh

from models.part import load_part
from primitives.errors import PalpateError

BOX = trimesh.creation.box((20, 30, 40))


def _stl(triangles: np.ndarray, count: int | None = None) -> bytes:
    rows = b"".join(struct.pack("<12fH", 0, 0, 0, *t.ravel(), 0) for t in np.asarray(triangles, np.float32))
    return bytes(80) + struct.pack("<I", len(triangles) if count is None else count) + rows


def _with(value: float) -> np.ndarray:
    corners = np.array(BOX.triangles)
    corners[corners == 10] = value
    return corners


def _folder(file: Path) -> None:
    file.mkdir()


def _unreadable(file: Path) -> None:
    file.write_bytes(_stl(BOX.triangles))
    file.chmod(0)


def _broken_link(file: Path) -> None:
    file.symlink_to(file.with_name("gone.stl"))


def _bytes(data: bytes) -> Callable[[Path], None]:
    return lambda file: file.write_bytes(data) and None


NOISE = np.random.default_rng(0).bytes(4000)
GLB = trimesh.Scene(BOX).export(file_type="glb")
HUGE_PLY = (
    b"ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n1234"
)
HUGE_GLB = GLB.replace(b'"count":24', b'"count":9999999999'[:10]) if b'"count":24' in GLB else GLB[:-40]

LIST_PLY = (
    b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
    b"element face 1\nproperty list uchar int vertex_indices\nend_header\n"
    b"0 0 0\n1 0 0\n0 1 0\n4000000000 0 1 2\n"
)
TWO_SIDES = (BOX.face_normals[:, 0] < 0.5) & (BOX.face_normals[:, 1] < 0.5)  # left out: two that meet

CASES: list[tuple[str, Callable[[Path], object], str]] = [
    ("empty.stl", _bytes(b""), "is empty"),
    ("blank.obj", _bytes(b" \n\t\n" * 5000), "only blanks"),
    ("truncated.stl", _bytes(_stl(BOX.triangles)[:-60]), "truncated"),
    ("truncated_text.stl", _bytes(BOX.export(file_type="stl_ascii").encode()[:900]), "truncated"),
    ("truncated.off", _bytes(b"OFF\n8 12 0\n0 0 0\n1 0 0\n"), "truncated"),
    ("truncated.glb", _bytes(GLB[:-40]), "not a whole GLB"),
    ("nan.stl", _bytes(_stl(_with(np.nan))), "not finite"),
    ("infinite.stl", _bytes(_stl(_with(np.inf))), "not finite"),
    ("one.stl", _bytes(_stl(BOX.triangles[:1])), "only 1 triangle"),
    ("really_a_ply.stl", _bytes(BOX.export(file_type="ply")), "rename it to end in .ply"),
    ("notes.txt", _bytes(b"hello"), "use one of .stl"),
    ("noise.stl", _bytes(NOISE), "truncated"),
    ("noise.obj", _bytes(NOISE), "binary where text should be"),
    ("noise.ply", _bytes(NOISE), "no complete PLY header"),
    ("noise.off", _bytes(NOISE), "binary where text should be"),
    ("noise.glb", _bytes(NOISE), "not a whole GLB"),
    ("folder.stl", _folder, "is a folder"),
    ("unreadable.stl", _unreadable, "permissions"),
    ("gone.stl", lambda file: None, "check the path"),
    ("link.stl", _broken_link, "is a link to"),
    ("none.stl", _bytes(_stl(np.empty((0, 3, 3)))), "no faces"),
    ("none.off", _bytes(b"OFF\n3 0 0\n0 0 0\n9 0 0\n0 9 0\n"), "no faces"),
    ("none.obj", _bytes(b"v 0 0 0\nv 9 0 0\nv 0 9 0\n"), ""),
    ("open.stl", _bytes(_stl(BOX.triangles[TWO_SIDES])), "not closed: 6 open edges"),
    ("garbage.stl", _bytes(b"the quick brown fox\n" * 50), "text but not STL"),
    ("garbage.obj", _bytes(b"f 1 2 x\nf 9 9 9\nv a b c\n"), ""),
    ("garbage.off", _bytes(b"OFF\nmany few none\n"), "line that OFF does not allow"),
    ("huge.stl", _bytes(_stl(BOX.triangles, 4_000_000_000)), "announces 4000000000"),
    ("huge.ply", _bytes(HUGE_PLY), "truncated"),
    ("huge.off", _bytes(b"OFF\n4000000000 4000000000 0\n0 0 0\n"), "truncated"),
    ("huge.glb", _bytes(HUGE_GLB), ""),
    ("huge_index.obj", _bytes(b"v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 4000000000\n"), ""),
    ("flat.stl", _bytes(_stl(np.repeat(BOX.triangles[:, :1], 3, axis=1))), "without area"),
    ("thin.stl", _bytes(_stl(BOX.triangles * [1, 0, 0])), "without area"),
    ("many.stl", _bytes(bytes(80) + struct.pack("<I", 1_000_001) + bytes(50 * 1_000_001)), "1,000,001 tri"),
    ("negative.obj", _bytes(b"v 0 0 0\nv 9 0 0\nv 0 9 0\nf -9 -2 -1\n"), "cannot read"),
    ("zero.obj", _bytes(b"v 0 0 0\nv 9 0 0\nv 0 9 0\nf 0 1 2\n"), "does not allow: f 0 1 2"),
    ("endless.obj", _bytes(b"v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 " + b"9" * 30 + b"\n"), "cannot read"),
    ("short.obj", _bytes(b"v 0 0 0\nv 9 0\nv 0 9 0\nf 1 2 3\n"), "cannot read"),
    ("pointer.stl", _bytes(b"version https://git-lfs.github.com/spec/v1\nsize 9\n"), "git lfs pull"),
    ("page.step", _bytes(b"\n<!DOCTYPE html><html>404</html>"), "download the file itself"),
    ("packed.stl", _bytes(gzip.compress(_stl(BOX.triangles))), "unpack it first"),
    ("lists.ply", _bytes(LIST_PLY), ""),
    ("negative.ply", _bytes(LIST_PLY.replace(b"vertex 3", b"vertex -3")), ""),
    ("deep.glb", _bytes(b"glTF" + struct.pack("<III", 2, 100020, 100000) + b"JSON" + b"[" * 100000), "not a"),
    ("hello.step", _bytes(b"hello world\n"), "ISO-10303-21"),
    ("noise.step", _bytes(NOISE), "binary where text"),
    ("noise.3mf", _bytes(b"PK\3\4" + NOISE), "not a whole 3MF"),
    ("stl_inside.3mf", _bytes(BOX.export(file_type="stl_ascii").encode()), "rename it to end in .stl"),
    ("small.stl", _bytes(_stl(BOX.triangles / 1000)), "--units m"),
    ("large.stl", _bytes(_stl(BOX.triangles * 1000)), "more than 10 m"),
]


@pytest.mark.parametrize(("name", "make", "says"), CASES, ids=[case[0] for case in CASES])
def test_a_broken_file_gives_one_line_with_the_fix(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, make: Callable[[Path], object], says: str
) -> None:
    file = tmp_path / name
    make(file)
    size = file.stat().st_size if file.is_file() else 0
    if "unreadable" in name and os.access(file, os.R_OK):

        def refuse(_: Path) -> bytes:
            raise PermissionError(13, "Permission denied")

        monkeypatch.setattr(Path, "read_bytes", refuse)
    tracemalloc.start()
    with pytest.raises(PalpateError) as caught:
        load_part(file)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    message = str(caught.value)
    assert "\n" not in message
    assert len(message) < 200
    assert says in message
    assert name in message
    assert peak < 50_000_000 + 3 * size
    assert ";" in message or ":" in message


def test_nothing_but_the_line_is_shown(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture
) -> None:
    text = BOX.export(file_type="stl_ascii").replace("normal ", "normal x", 1)
    (tmp_path / "box.stl").write_text(text)
    assert load_part(tmp_path / "box.stl").solid.volume == pytest.approx(24000)
    assert caplog.text == ""
    assert capfd.readouterr() == ("", "")
