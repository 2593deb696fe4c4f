import numpy as np

from primitives.pose import pose, random_rotation, transform_points
from primitives.shapes import Plane
from recognition.assembly.prisms import prism


def sides_of(count, world_from_prism, reach=18.0, height=60.0):
    angle = 2 * np.pi * np.arange(count) / count
    normals = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    every = np.concatenate([normals, [[0, 0, 1.0], [0, 0, -1.0]]])
    points = np.concatenate([reach * normals, [[0, 0, height / 2], [0, 0, -height / 2]]])
    turn = world_from_prism[:3, :3]
    return {
        k: Plane(p, turn @ n)
        for k, (p, n) in enumerate(zip(transform_points(world_from_prism, points), every, strict=True))
    }


def test_a_hexagon_bar_is_one_prism_at_any_attitude():
    rng = np.random.default_rng(3)
    for _ in range(5):
        placed = pose(random_rotation(rng), rng.uniform(-50, 50, 3))
        planes = sides_of(6, placed)
        piece, taken = prism(planes, [], placed[:3, 3] + rng.uniform(-20, 20, (8, 3)))
        assert taken == tuple(range(8))
        assert piece.solid.height == np.float64(60.0).item() or abs(piece.solid.height - 60.0) < 1e-9
        middle = np.array([p.origin for p in planes.values()])
        assert np.abs(piece.placed.signed_distance(middle)).max() < 1e-9


def test_sides_that_leave_a_gap_are_no_prism():
    planes = sides_of(6, np.eye(4))
    open_ = {k: planes[k] for k in (0, 1, 2, 6, 7)}
    assert prism(open_, [], np.zeros((4, 3))) is None


def test_an_end_that_no_plane_closes_reaches_past_the_body():
    planes = sides_of(5, np.eye(4))
    del planes[5]
    piece, _ = prism(planes, [], np.array([[0, 0, -30.0], [10, 5, 41.0]]))
    assert piece.placed.signed_distance(np.array([[0, 0, 41.5]]))[0] < 0
    assert piece.ends[2][1] is None
