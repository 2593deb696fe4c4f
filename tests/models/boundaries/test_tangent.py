from math import pi

import numpy as np
import pytest

from models.boundaries.tangent import forward, on_tangents
from models.boundary import boundary
from models.brep import Brep
from models.csg import Cone, Csg, Cube, Cylinder, Sphere, Torus
from models.solid import Solid
from primitives import shapes

TURNED = ((1.0, 2.0, 3.0), 0.7)


def _brep(tree: Csg) -> Brep:
    return boundary(Solid.from_csg(tree.turned(*TURNED)))


def _kinds(brep: Brep) -> str:
    return " ".join(sorted(face.kind for face in brep.faces))


JOINED = {
    "a dome on its cylinder": (
        Cylinder(15, 30).at(0, 0, -15) | Sphere(15),
        "cylinder plane sphere",
        {"sphere": (30, 15), "cylinder": (30, 30 * pi)},
        [30 * pi],
    ),
    "a disc with a round rim": (
        Cylinder(30, 8) | Torus(30, 4),
        "plane plane torus",
        {"torus": (4 * pi, 60 * pi)},
        [60 * pi] * 2,
    ),
    "an arch on its walls": (
        Cube((50, 30, 40)).at(0, 0, 20) | Cylinder(25, 30).turned("x", pi / 2).at(0, 0, 40),
        "cylinder plane plane plane plane plane",
        {"cylinder": (30, 25 * pi)},
        [30, 30],
    ),
    "a fillet between boss and plate": (
        Cylinder(30, 10).at(0, 0, 5)
        | Cylinder(15, 40).at(0, 0, 20)
        | (Cylinder(20, 5).at(0, 0, 12.5) - Torus(20, 5).at(0, 0, 15)),
        "cylinder cylinder plane plane plane torus",
        {"torus": (2.5 * pi, 40 * pi)},
        [30 * pi, 40 * pi],
    ),
    "a ball that a cone touches": (
        Cone(0, 30, 30).at(0, 0, 15) & Cube((80, 80, 80)).at(0, 0, 46) | Sphere(12 / 2**0.5).at(0, 0, 12),
        "cone plane sphere",
        {"cone": (6, 30), "sphere": (12, 12 / 2**0.5 * (1 - 0.5**0.5))},
        [12 * pi],
    ),
}


@pytest.mark.parametrize(("tree", "kinds", "extents", "smooth"), JOINED.values(), ids=JOINED)
def test_what_joins_smoothly_has_no_more_faces_than_its_surfaces_and_exact_extents(
    tree: Csg, kinds: str, extents: dict[str, tuple[float, float]], smooth: list[float]
) -> None:
    brep = _brep(tree)
    assert brep.check() == ()
    assert _kinds(brep) == kinds
    for kind, extent in extents.items():
        assert any(f.extent == pytest.approx(extent, abs=1e-3) for f in brep.faces if f.kind == kind)
    found = sorted(edge.length for edge in brep.edges if edge.kind == "smooth")
    assert found == pytest.approx(sorted(smooth), abs=1e-3)


def test_a_slot_with_round_ends_has_half_circles_for_ends() -> None:
    ends = Cylinder(5, 30).at(-20, 0, 0) | Cylinder(5, 30).at(20, 0, 0)
    brep = _brep(Cube((80, 40, 10)) - (Cube((40, 10, 30)) | ends))
    assert brep.check() == ()
    halves = [f.extent for f in brep.faces if f.kind == "cylinder"]
    np.testing.assert_allclose(halves, [(10, 5 * pi)] * 2, atol=1e-3)
    assert [e.curve for e in brep.edges if e.kind == "smooth"] == ["line"] * 4


def test_surfaces_that_cross_at_a_small_angle_are_not_taken_for_tangent() -> None:
    brep = _brep(Cylinder(20, 30) & Cube((60, 39.99, 60)))
    assert brep.check() == ()
    flat = next(f for f in brep.faces if f.kind == "plane" and abs(f.extent[1] - 30) > 1)
    assert min(flat.extent) > 0.5


def test_points_move_to_where_a_plane_touches_a_cylinder() -> None:
    plane = shapes.Plane(np.array([5.0, 0, 0]), np.array([1.0, 0, 0]))
    cylinder = shapes.Cylinder(np.zeros(3), np.array([0.0, 0, 1]), 5.0)
    near = np.array([[5.0, 0.1, z] for z in (-3, 0, 4)])
    moved = on_tangents(near, [plane, cylinder], 20.0)
    assert moved is not None
    np.testing.assert_allclose(moved, [[5, 0, -3], [5, 0, 0], [5, 0, 4]], atol=1e-6)
    assert on_tangents(near, [plane, shapes.Plane(near[0], np.array([0.0, 1, 0]))], 20.0) is None


def test_running_back_along_a_line_or_a_circle_is_left_out() -> None:
    line = np.array([[0.0, 0, 0], [1, 0, 0], [0.5, 0, 0], [2, 0, 0], [4, 0, 0], [3, 0, 0]])
    assert forward(line, 1e-6).tolist() == [0, 1, 3, 5]
    turn = np.array([0, 1, 0.9, 2, 3, 4, 3.5, 5, 2 * pi])
    circle = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    assert forward(circle, 1e-6).tolist() == [0, 1, 3, 4, 5, 7, 8]


def test_a_closed_run_that_is_not_round_its_circle_keeps_all_its_points() -> None:
    thin = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0.1, 0], [0, 0, 0]])
    assert forward(thin, 1e-6).tolist() == [0, 1, 2, 3]
