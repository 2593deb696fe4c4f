"""Fillets where a wall stands on a face, from pictures of the face that rises before it."""

import numpy as np
import pytest

from exploration.planning.inferring.fillets import fillets
from exploration.planning.known.mosaic import Lain
from exploration.sensing.lines.edge_profiles import risen
from primitives.evidence import Contacts
from primitives.fit import fit
from primitives.patch_graph import MergeOptions, ranked_face

SPREAD, SIGMA, NEAREST = 1.1, 0.02, 2.0
X, Y, Z = np.eye(3)


def grid(normal, first, second):
    """Contacts of a flat face through the origin that two ranges of places span."""
    a, b = np.meshgrid(first, second)
    along = [way for way in (X, Y, Z) if abs(float(way @ normal)) < 0.5]
    points = a.reshape(-1, 1) * along[0] + b.reshape(-1, 1) * along[1]
    return Contacts.of(points, np.tile(normal, (len(points), 1)), 0.02)


class Pictures:
    """Stands for a mosaic: pads on the floor z = 0, up to a wall so far from their places, with a fillet there."""

    def __init__(self, size, away, hole=None):
        self.size, self.away, self.hole, self.rng = size, away, hole, np.random.default_rng(6)

    def flush(self, anchor, normal):
        if normal @ Z < 0.9:
            return []
        found = []
        for before in (0.4, 0.7, 1.0):
            places = np.column_stack([self.rng.uniform(-45.0, 45.0, (4000, 2)), np.zeros(4000)])
            away = self.away(places)
            places, away = places[away > NEAREST], away[away > NEAREST]
            depth = (
                before + risen(self.size, SPREAD, NEAREST, away) if self.size else np.full(len(away), before)
            )
            depth = depth + SIGMA * self.rng.standard_normal(len(away))
            if self.hole is not None:
                depth = np.where(np.linalg.norm(places - self.hole, axis=1) < 3.0, 0.0, depth)
            sigma = np.full(len(away), SIGMA)
            found.append(Lain(places, np.full(len(away), before), depth, sigma, SPREAD))
        return found


def post(radius=12.0):
    turn = np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False)
    out = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])
    points = np.concatenate([radius * out + high * Z for high in (12.0, 20.0, 30.0)])
    return ranked_face(1, Contacts.of(points, np.tile(out, (3, 1)), 0.02), MergeOptions())


def floor(round_=True):
    lot = grid(Z, np.linspace(-40.0, 40.0, 17), np.linspace(-40.0, 40.0, 17))
    near = (
        np.linalg.norm(lot.points[:, :2], axis=1)
        if round_
        else lot.points[:, 0] + 100.0 * (lot.points[:, 0] > 0)
    )
    return ranked_face(0, lot.select(near > 15.0 if round_ else near > 10.0), MergeOptions())


def from_post(places):
    return np.linalg.norm(places[:, :2], axis=1) - 12.0


@pytest.mark.parametrize("size", [3.5, 5.0, 8.0])
def test_a_post_on_a_plate_has_a_ring_round_its_foot(size):
    ((lot, kind),) = fillets([floor(), post()], Pictures(size, from_post))
    ring = fit(kind, lot)
    assert kind == "torus"
    assert not ring.convex
    assert ring.shape.minor_radius == pytest.approx(size, abs=0.3)
    assert ring.shape.radius - ring.shape.minor_radius == pytest.approx(12.0, abs=1e-3)
    assert abs(float(ring.shape.anchor[2])) == pytest.approx(ring.shape.minor_radius, abs=1e-3)


def test_a_hole_in_the_plate_is_no_fillet_and_hides_none():
    hole = np.array([18.0, 0.0, 0.0])
    assert fillets([floor(), post()], Pictures(0.0, from_post, hole)) == []
    assert len(fillets([floor(), post()], Pictures(4.0, from_post, hole))) == 1


def test_a_wall_on_a_floor_has_a_round_inner_edge_and_a_sharp_one_none():
    wall = ranked_face(1, grid(X, np.linspace(-30.0, 30.0, 9), np.linspace(8.0, 30.0, 5)), MergeOptions())
    lot = grid(Z, np.linspace(8.0, 40.0, 9), np.linspace(-40.0, 40.0, 17))
    ground = ranked_face(0, lot, MergeOptions())
    ((found, kind),) = fillets([ground, wall], Pictures(4.0, lambda places: places[:, 0]))
    made = fit(kind, found)
    assert (kind, made.convex) == ("cylinder", False)
    assert made.shape.radius == pytest.approx(4.0, abs=0.3)
    assert np.abs(made.shape.anchor[[0, 2]]) == pytest.approx(made.shape.radius, abs=1e-3)
    assert fillets([ground, wall], Pictures(0.0, lambda places: places[:, 0])) == []


def test_a_post_that_stands_elsewhere_or_hangs_below_has_none():
    below = post()
    hanging = Contacts.of(below.contacts.points - 60.0 * Z, below.contacts.normals, 0.02)
    pictures = Pictures(4.0, from_post)
    assert fillets([floor(), ranked_face(1, hanging, MergeOptions())], pictures) == []
    high = Contacts.of(below.contacts.points + 60.0 * Z, below.contacts.normals, 0.02)
    assert fillets([floor(), ranked_face(1, high, MergeOptions())], pictures) == []
