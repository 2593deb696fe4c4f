"""Primitives run on past ends that abut, and only there."""

from types import SimpleNamespace

import numpy as np
import pytest

from models.csg import Cube, Sphere
from models.csg import Cylinder as CylinderSolid
from models.solid import Solid, iou
from primitives.arrays import frozen
from primitives.pose import pose, random_rotation, rotation_exp
from recognition.assembly.assemble import Assembly
from recognition.assembly.lapping import lapped
from recognition.assembly.piece import Piece, tree_of

SLIT = 5e-4  # [mm], more than meshing takes for nothing
STRAIGHT = np.eye(4)
TURNED = pose(rotation_exp([2e-6, 1e-6, 0.0]))  # so that nothing is flush to the last digit
WORLD = pose(random_rotation(np.random.default_rng(1)), [20.0, -30.0, 10.0])


def piece(operation, solid, at, ends, turned=STRAIGHT):
    placed = frozen(WORLD @ turned @ pose(None, at))
    return Piece(type(solid).__name__.lower(), operation, solid, placed, None, ends)


def box(operation, low, high, ends=((0, 1), (2, 3), (4, 5))):
    low, high = np.array(low, dtype=float), np.array(high, dtype=float)
    return piece(operation, Cube(tuple(high - low)), 0.5 * (low + high), ends)


def upright(operation, radius, low, high, ends=((0, 1),)):
    at = [0.0, 0.0, 0.5 * (low + high)]
    return piece(operation, CylinderSolid(radius, high - low), at, ends, TURNED)


def assembly(*named):
    tree = tree_of(named)
    told = SimpleNamespace(slices=[])
    return Assembly((), told, (), tuple(named), tree, Solid.from_csg(tree, 0.005), ())


STEM = upright("add", 5.0, -20.0, -SLIT)
CASES = {
    "a stem below a cap": (box("add", [-20, -20, 0], [20, 20, 9]), STEM),
    "a stem below half a ball": (
        piece("add", Sphere(20.0), [0, 0, 0], ()),
        box("subtract", [-30, -30, -30], [30, 30, 0]),
        STEM,
    ),
    "ears below an arch": (
        upright("add", 20.0, -20.0, 20.0),
        box("subtract", [-30, -30, -30], [30, 0, 30]),
        box("add", [-40, -9, -20], [40, -SLIT, 20]),
        upright("subtract", 12.0, -30.0, 30.0, ((None, None),)),
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_what_abuts_becomes_one_body(name):
    before = assembly(*CASES[name])
    assert before.solid.shells > 1
    after = lapped(before)
    assert after.solid.shells == 1
    assert iou(after.solid, before.solid) > 1.0 - 1e-4
    assert iou(Solid.from_csg(after.tree, 0.005), after.solid) > 1.0 - 1e-9


def test_a_film_between_two_pockets_goes():
    block = box("add", [-20, -20, -10], [20, 20, 10])
    before = assembly(
        block, box("subtract", [-9, -9, SLIT], [9, 9, 30]), upright("subtract", 5.0, -30.0, 0.0)
    )
    after = lapped(before)
    assert (before.solid.genus, after.solid.genus) == (0, 1)
    assert after.solid.volume == pytest.approx(before.solid.volume, rel=1e-4)


def test_an_end_that_runs_on_is_no_surfaces_and_others_stay():
    after = lapped(assembly(*CASES["a stem below a cap"]))
    assert after.pieces[0] is CASES["a stem below a cap"][0]
    assert after.pieces[1].ends == ((0, None),)
    assert after.pieces[1].solid.bounds()[1][2] == pytest.approx(10.5, abs=SLIT)


def test_a_small_pin_is_not_cut_off_by_a_wide_box_that_ends_on_it():
    slab, pin = box("add", [-50, -50, 0], [50, 50, 10]), box("add", [-1, -1, 10], [1, 1, 12])
    before = assembly(slab, pin, box("subtract", [-48, -48, 12], [48, 48, 40]))
    assert lapped(before).solid.volume == pytest.approx(before.solid.volume, abs=1e-3)


def test_nothing_runs_on_into_the_open_or_out_of_a_thin_wall():
    thin = assembly(box("add", [-20, -20, 0], [20, 20, 0.5]), STEM)
    assert lapped(thin).pieces == thin.pieces
    apart = assembly(box("add", [-20, -20, 5], [20, 20, 9]), STEM)
    assert lapped(apart) is apart
