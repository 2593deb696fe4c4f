import numpy as np
import pytest

from exploration.sensing.spec import load_sensor
from models.csg import Csg, Cube, Cylinder
from models.library import Library
from models.solid import Solid
from primitives.pose import pose, rotation_exp, transform_points
from recognition.confusable import confusable
from recognition.confusable.overlay import overlay

PAD = load_sensor("lts210")
MOTION = pose(rotation_exp(np.array([0.4, -0.9, 0.3])), np.array([12.0, -7.0, 30.0]))


def library(**trees: Csg) -> Library:
    return Library.of({name: Solid.from_csg(tree) for name, tree in trees.items()})


def plate(holes: int) -> Csg:
    tree: Csg = Cube((100, 60, 10))
    for x, y in [(-35, 15), (30, -18)][:holes]:
        tree = tree - Cylinder(5, 30).at(x, y, 0)
    return tree


def test_the_overlay_undoes_a_motion() -> None:
    both = library(a=plate(2), b=plate(2).placed(MOTION))
    b_from_a = overlay(both["a"], both["b"])
    points = both["a"].samples.points
    away = both["b"].solid.signed_distance(transform_points(b_from_a, points))
    assert np.abs(away).max() < 0.02


def test_equal_objects_in_other_frames_are_told_by_chance_only() -> None:
    (pair,) = confusable(library(a=plate(2), b=plate(2).placed(MOTION)), PAD, 0.1)
    assert pair.probability == pytest.approx(0.5, abs=0.01)
    assert pair.touches == ()


def test_the_touch_proposed_lies_in_the_hole_that_differs() -> None:
    (pair,) = confusable(library(one=plate(1), two=plate(2)), PAD, 0.1)
    assert pair.probability < 1e-3
    assert pair.after_random[12] > 0.1
    best = pair.touches[0]
    assert best.on == "one"
    assert min(np.hypot(*(best.point[:2] - s * np.array([30, -18]))) for s in (-1, 1)) < 6


def test_noise_blurs_a_difference_of_size() -> None:
    both = library(a=Cylinder(20, 60), b=Cylinder(20.2, 60))
    sharp, blurred = (next(iter(confusable(both, PAD, sigma)), None) for sigma in (0.02, 1.0))
    assert sharp is None or sharp.probability < 0.01
    assert blurred is not None
    assert blurred.probability > 0.3


@pytest.mark.parametrize("order", [("solid", "hollow"), ("hollow", "solid")])
def test_a_cavity_inside_is_out_of_reach(order: tuple[str, str]) -> None:
    trees: dict[str, Csg] = {"solid": Cube((60, 50, 40)), "hollow": Cube((60, 50, 40)) - Cube((20, 20, 10))}
    (pair,) = confusable(library(**{name: trees[name] for name in order}), PAD, 0.1)
    assert pair.touches == ()
    assert pair.probability == pytest.approx(0.5, abs=0.02)


def test_objects_of_other_sizes_are_not_listed() -> None:
    assert confusable(library(a=Cube((60, 50, 40)), b=Cylinder(8, 90)), PAD, 0.1) == []
