import numpy as np
import pytest

from exploration.sensing.lines.edges import edge_points


@pytest.mark.parametrize("angle", [0.0, 0.4, np.pi / 2, 2.5])
@pytest.mark.parametrize("depth", [0.15, 0.5])
def test_points_lie_on_the_edge_whatever_the_press(frames, angle, depth):
    image = frames(frames.edge(angle, 1.1, depth=depth))
    points = edge_points(image)
    normal = np.array([-np.sin(angle), np.cos(angle)])
    seen = (np.abs(points.points) < [10.0, 5.0]).all(
        axis=1
    )  # beyond, the pad shows too little of the plateau
    assert seen.sum() >= 6
    assert np.abs(points.points[seen] @ normal - 1.1).max() < 0.1
    assert (points.directions[seen] @ normal).min() > 0.95


def test_stated_sigma_is_the_scatter(frames):
    rng = np.random.default_rng(0)
    field = frames.edge(0.3, 0.7)
    z = []
    for _ in range(60):
        points = edge_points(frames(field, rng))
        z.extend((points.points @ [-np.sin(0.3), np.cos(0.3)] - 0.7) / points.sigma)
    assert 0.6 < np.std(z) < 1.3


def test_noise_alone_and_full_contact_have_no_edge_points(frames):
    rng = np.random.default_rng(1)
    for _ in range(50):
        assert not edge_points(frames(frames.plane(0.0), rng))
        assert not edge_points(frames(frames.plane(0.5, (0.005, 0.01)), rng))
