"""The axis that facets were turned about, and that there is none of a block's or a ball's."""

import numpy as np
import pytest
import trimesh

from models.recovery.creases import find_creases
from models.recovery.flats import find_flats
from models.recovery.grow import Mesh
from models.recovery.turned import axis_of
from models.solid import Solid
from primitives.pose import random_rotation


def _mesh(made: trimesh.Trimesh) -> Mesh:
    body = Solid.from_mesh(made.vertices, made.faces).body
    flats = find_flats(body.vertices, body.triangles, body.neighbors, 1e-4, 1e-5, 0.009)
    creases = find_creases(body.vertices, body.triangles, body.neighbors, flats)
    return Mesh(body.vertices, flats, creases, flats.thin)


def _vase() -> trimesh.Trimesh:
    z = np.linspace(0.0, 80.0, 30)
    return trimesh.creation.revolve(
        [(0, 0), *zip(25 + 6 * np.sin(z / 12), z, strict=True), (0, 80)], sections=40
    )


def test_the_axis_of_a_vase_is_found_wherever_it_lies() -> None:
    rng = np.random.default_rng(0)
    turn, shift = random_rotation(rng), rng.uniform(-50.0, 50.0, 3)
    vase = _vase()
    vase.vertices = vase.vertices @ turn.T + shift
    mesh = _mesh(vase)
    found = axis_of(mesh, np.arange(len(mesh.flats)))
    assert found is not None
    point, along = found
    assert abs(along @ turn[:, 2]) == pytest.approx(1.0, abs=1e-6)
    assert np.linalg.norm(np.cross(point - shift, along)) < 1e-2


@pytest.mark.parametrize(
    "made",
    [trimesh.creation.icosphere(3, 20.0), trimesh.creation.icosphere(3, 20.0).apply_scale([1, 0.7, 0.4])],
)
def test_a_ball_and_an_ellipsoid_have_no_axis_of_their_own(made: trimesh.Trimesh) -> None:
    mesh = _mesh(made)
    assert axis_of(mesh, np.arange(len(mesh.flats))) is None
