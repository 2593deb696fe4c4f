from collections import Counter
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

from models.boundary import boundary
from models.csg import Cylinder
from models.formats import step
from models.part import load_part
from models.solid import Solid, iou
from primitives.errors import PalpateError


def _write(folder: Path, text: str, name: str = "part.step") -> Path:
    (folder / name).write_text(text)
    return folder / name


@pytest.mark.parametrize(("unit", "factor"), [("mm", 1.0), ("inch", 25.4), ("m", 1000.0)])
def test_lengths_come_out_in_mm_whatever_the_file_is_in(tmp_path, step_box, unit, factor) -> None:
    size = np.array([20.0, 30.0, 40.0])
    part = load_part(_write(tmp_path, step_box(tuple(size / factor), unit)))
    assert part.solid.extent == pytest.approx(size, rel=1e-6)
    assert part.warnings == ()


def test_a_told_unit_overrides_that_of_the_file(tmp_path, step_box) -> None:
    file = _write(tmp_path, step_box((20.0, 30.0, 40.0)))
    assert load_part(file, "cm", 0.5).solid.extent == pytest.approx([100, 150, 200], rel=1e-6)


@pytest.mark.parametrize("before", [0, 20_000_000])
def test_the_unit_is_found_at_either_end_of_a_long_file(before) -> None:
    unit = b"#9=(CONVERSION_BASED_UNIT('INCH',#8)LENGTH_UNIT()NAMED_UNIT(#7));"
    assert step.unit_mm(b" " * before + unit + b" " * (20_000_000 - before)) == 25.4


def test_halves_of_a_cylinder_are_one_face_with_its_exact_radius(tmp_path, step_bar) -> None:
    solid = load_part(_write(tmp_path, step_bar(10.0, 30.0), "BAR.STP")).solid
    whole = boundary(solid)
    assert whole.check() == ()
    assert Counter(face.kind for face in whole.faces) == {"cylinder": 1, "plane": 2}
    (side,) = (face for face in whole.faces if face.kind == "cylinder")
    assert side.convex
    assert side.shape.radius == pytest.approx(10.0, abs=1e-9)
    assert side.extent == pytest.approx((30.0, 20 * np.pi), abs=1e-3)


def test_facets_enclose_the_volume_of_the_exact_solid(tmp_path, step_bar) -> None:
    solid = load_part(_write(tmp_path, step_bar(10.0, 30.0))).solid
    assert solid.volume == pytest.approx(np.pi * 100 * 30, rel=1e-5)
    exact = Solid.from_csg(Cylinder(10.0, 30.0).at(0, 0, 15), 1e-4)
    assert iou(solid, exact) > 0.9998


def test_planes_face_out(tmp_path, step_box) -> None:
    solid = load_part(_write(tmp_path, step_box())).solid
    for surface in solid.surfaces:
        assert surface.shape.signed_distance(solid.center[None])[0] < 0


def test_two_solids_are_listed_and_one_is_chosen(tmp_path, step_box) -> None:
    file = _write(tmp_path, step_box(at=((0.0, 0.0, 0.0), (50.0, 0.0, 0.0))))
    with pytest.raises(PalpateError, match=r"2 bodies.*--body.*20 x 30 x 40 mm"):
        load_part(file)
    assert load_part(file, body=2).solid.bounds[0] == pytest.approx([50, 0, 0], abs=1e-6)
    with pytest.raises(PalpateError, match="no body 3"):
        load_part(file, body=3)


def test_faces_that_are_not_sewn_but_close_are_a_solid(tmp_path, step_box) -> None:
    part = load_part(_write(tmp_path, step_box(sewn=False)))
    assert part.solid.volume == pytest.approx(24000)
    assert len(boundary(part.solid).faces) == 6


def test_a_face_that_is_missing_is_not_invented(tmp_path, step_box) -> None:
    with pytest.raises(PalpateError, match="4 open edges; sew"):
        load_part(_write(tmp_path, step_box(without=1, sewn=False)))


def test_a_reader_that_crashes_or_hangs_is_one_line(tmp_path, step_box, monkeypatch) -> None:
    text = step_box()
    crash = tmp_path / "crash.py"
    crash.write_text("import os, signal\nos.kill(os.getpid(), signal.SIGSEGV)\n")
    hang = tmp_path / "hang.py"
    hang.write_text("import time\ntime.sleep(60)\n")
    monkeypatch.setattr(step, "_WORKER", crash)
    with pytest.raises(PalpateError, match="as STEP; export it again"):
        step.parse(text.encode(), "part.step")
    monkeypatch.setattr(step, "_WORKER", hang)
    with pytest.raises(PalpateError, match="takes more than"):
        step.parse(text.encode(), "part.step", step.StepConfig(seconds=1))


@pytest.mark.slow
def test_damaged_text_never_ends_the_program(tmp_path, step_bar) -> None:
    rng = np.random.default_rng(0)
    for _ in range(5):
        text = bytearray(step_bar().encode())
        for place in rng.integers(400, len(text) - 40, rng.choice([1, 5, 50])):
            text[place] = rng.integers(32, 126)
        (tmp_path / "part.step").write_bytes(text)
        with suppress(PalpateError):
            assert load_part(tmp_path / "part.step").solid.volume > 0
    assert [entry.name for entry in tmp_path.iterdir()] == ["part.step"]
