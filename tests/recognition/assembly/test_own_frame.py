"""A model is written as a person would draw it: square to its own axes, and flush where it is flush."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from models.boundary import boundary
from models.csg import Csg, Cube, Cylinder, Prism, Sphere
from models.normal.rounding import rounded
from models.solid import Solid, iou
from primitives.pose import pose, random_rotation
from recognition.assembly.own_frame import in_frame, own_frame
from recognition.assembly.piece import Piece, tree_of

UP_X = np.array([[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]])  # z along x


def piece(kind, solid: Csg, at, turn=None, operation="add"):
    return Piece(kind, operation, solid, pose(np.eye(3) if turn is None else turn, at), None, ())


def angle(a, b, t, width):
    """Two legs of a thickness, flush at their ends, and a hole; no size is round."""
    return [
        piece("cube", Cube((a, width, t)), [0.5 * a, 0.0, 0.5 * t], operation="intersect"),
        piece("cube", Cube((b, width, t)), [0.5 * t, 0.0, t + 0.5 * b], UP_X),
        piece("cylinder", Cylinder(0.2 * width, 9.0 * t), [0.6 * a, 0.0, 0.0], operation="subtract"),
    ]


def moved(pieces, seed):
    rng = np.random.default_rng(seed)
    world = pose(random_rotation(rng), rng.uniform(-40.0, 40.0, 3))
    return [Piece(p.kind, p.operation, p.solid, world @ p.world_from_piece, p.body, p.ends) for p in pieces]


def written(pieces, sigma):
    frame = own_frame(pieces)
    return rounded(tree_of([in_frame(p, frame) for p in pieces]), sigma), frame


@given(
    a=st.floats(30.0, 60.0),
    b=st.floats(20.0, 40.0),
    t=st.floats(5.0, 9.0),
    width=st.floats(20.0, 40.0),
    seed=st.integers(0, 999),
)
def test_sides_that_are_flush_are_flush_in_the_file_wherever_the_model_lies(a, b, t, width, seed):
    pieces = moved(angle(a, b, t, width), seed)
    tree, frame = written(pieces, 0.013)
    assert len(boundary(Solid.from_csg(tree)).faces) == 9
    for leaf in tree.leaves():
        turn = np.abs(leaf.part_from_primitive[:3, :3])
        assert np.isin(turn, (0.0, 1.0)).all()
    assert iou(Solid.from_csg(tree.placed(frame)), Solid.from_csg(tree_of(pieces))) > 0.995


def test_rounding_each_piece_where_it_lies_breaks_some_of_them():
    """So the test above can fail."""
    trees = [rounded(tree_of(moved(angle(41.237, 28.111, 6.013, 30.777), seed)), 0.013) for seed in range(6)]
    assert max(len(boundary(Solid.from_csg(tree)).faces) for tree in trees) > 9


def test_a_prism_is_written_by_outlines_along_the_frame():
    turn = np.array([[np.cos(0.7), -np.sin(0.7), 0.0], [np.sin(0.7), np.cos(0.7), 0.0], [0.0, 0.0, 1.0]])
    corners = np.array([[0.0, 0.0], [20.004, 0.0], [14.0, 9.996], [0.0, 9.996]])
    outline = tuple(map(tuple, corners @ turn[:2, :2]))
    pieces = moved([piece("prism", Prism(outline, 12.3456), [3.0, 4.0, 5.0], turn, "intersect")], 3)
    tree, frame = written(pieces, 0.02)
    (leaf,) = tree.leaves()
    sides = np.diff(np.array([*leaf.primitive.outline, leaf.primitive.outline[0]]), axis=0)
    assert sorted(np.abs(sides).round(6).ravel().tolist())[:3] == [0.0, 0.0, 0.0]
    assert iou(Solid.from_csg(tree.placed(frame)), Solid.from_csg(tree_of(pieces))) > 0.995


@pytest.mark.parametrize(
    "made",
    [
        piece("cylinder", Cylinder(7.7777, 20.123), [1.0, 2.0, 3.0], operation="intersect"),
        piece("sphere", Sphere(9.876), [1.0, 2.0, 3.0], operation="intersect"),
    ],
)
def test_round_ones_stand_on_or_about_the_origin(made):
    tree, _ = written(moved([made], 5), 0.02)
    low, high = tree.bounds()
    np.testing.assert_allclose((low + high)[:2], 0.0, atol=1e-9)
    assert low[2] == pytest.approx(0.0 if made.kind == "cylinder" else -9.88)
