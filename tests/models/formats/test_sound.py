"""What is written in single precision reads back as one closed solid."""

import numpy as np
import pytest

from models.csg import Cube, Cylinder
from models.formats import mesh, sound
from models.part import load_part
from models.solid import Solid
from primitives.pose import pose, rotation_exp

TURNED = pose(rotation_exp([0.3, 0.5, 0.7]), [30, 20, 10])
BORED = Solid.from_csg((Cube((60, 40, 20)) - Cylinder(10, 60)).placed(TURNED))


def with_fin() -> Solid:
    """A block beside a fin 10 nm thick, which single precision folds flat."""
    fin = Cube((1e-5, 30, 10)).at(40, 0, 0)
    return Solid.from_csg((Cube((60, 40, 20)) | fin).placed(TURNED))


def test_what_reads_back_stays_as_it_is() -> None:
    assert sound.sound(BORED) is BORED


def test_splinters_are_not_written(tmp_path) -> None:
    made = sound.sound(with_fin())
    assert len(made.body.mesh.decompose()) == 1
    mesh.save(made, tmp_path / "part.stl")
    part = load_part(tmp_path / "part.stl")
    assert part.solid.volume == pytest.approx(60 * 40 * 20, rel=1e-6)
    assert not any("splinter" in line for line in part.warnings)


def test_it_is_simplified_by_the_least_that_reads_back(monkeypatch) -> None:
    asked = []

    def third(solid: Solid) -> bool:
        asked.append(solid)
        return len(asked) == 3

    monkeypatch.setattr(sound, "_reads_back", third)
    made = sound.sound(BORED)
    assert made is asked[2]
    assert made.volume == pytest.approx(BORED.volume, rel=1e-6)
    assert np.allclose(made.bounds, BORED.bounds, atol=1e-3)


def test_a_surface_through_itself_does_not_read_back() -> None:
    flipped = BORED.vertices.copy()
    flipped[np.argmax(flipped[:, 0])] -= [80, 5, 5]
    crossed = Solid.from_mesh(flipped, BORED.triangles)
    assert not sound._reads_back(crossed)
    assert sound._reads_back(BORED)
