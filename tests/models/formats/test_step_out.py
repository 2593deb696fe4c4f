from collections import Counter

import pytest

from models import parts
from models.boundary import boundary
from models.csg import Cone, Cube, Cylinder, Polyhedron, Prism, Sphere, Torus
from models.formats import step_out
from models.part import load_part
from models.solid import Solid, iou
from primitives.errors import PalpateError

needs_kernel = pytest.mark.skipif(
    not step_out.available(), reason="left out: the extra 'step' is not installed"
)
TETRAHEDRON = Polyhedron(
    ((0, 0, 0), (20, 0, 0), (0, 20, 0), (0, 0, 20)), ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
)
TREES = {
    "all_round": Cone(20.0, 12.0, 30.0) - Cylinder(4.0, 40.0),
    "torus": Torus(30.0, 5.0),
    "half": Sphere(20.0) & Cube((50.0, 50.0, 50.0)).at(0, 0, 25),
    "prism": Prism(((0, 0), (40, 0), (40, 10), (10, 10), (10, 40), (0, 40)), 15.0).turned("x", 0.3),
    "tetrahedron": TETRAHEDRON.at(5, 6, 7),
}


def test_without_the_kernel_one_line_says_what_to_install(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(step_out, "available", lambda: False)
    with pytest.raises(PalpateError, match=r"palpate\[step\]"):
        step_out.write(Cube((20.0, 20.0, 20.0)), tmp_path / "part.step")
    assert not list(tmp_path.iterdir())


def _comes_back(tree, file) -> None:
    step_out.write(tree, file)
    came = load_part(file)
    gone = Solid.from_csg(tree)
    there, back = boundary(gone), boundary(came.solid)
    assert Counter(f.kind for f in back.faces) == Counter(f.kind for f in there.faces)
    assert len(back.edges) == len(there.edges)
    assert came.solid.volume == pytest.approx(gone.volume, rel=1e-4)
    assert iou(came.solid, gone) > 0.999


@needs_kernel
@pytest.mark.slow
@pytest.mark.parametrize("name", TREES)
def test_every_primitive_comes_back_with_the_same_faces(tmp_path, name) -> None:
    _comes_back(TREES[name], tmp_path / "part.step")


@needs_kernel
@pytest.mark.slow
@pytest.mark.parametrize("name", ["bracket", "flange", "countersunk_plate"])
def test_parts_come_back_with_the_same_faces(tmp_path, name) -> None:
    _comes_back(parts.build(name), tmp_path / "part.step")
