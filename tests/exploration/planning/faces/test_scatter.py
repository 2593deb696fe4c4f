"""By how much a stage's errors make the contacts of one face disagree."""

import numpy as np
import pytest

from exploration.planning.faces.attribution import CONVEX
from exploration.planning.faces.scatter import scatter_of
from primitives.evidence import Contacts
from primitives.patch_graph import PatchGraph

FOOT = np.array([[6.0, 0.0], [-6.0, 0.0], [0.0, 6.0], [0.0, -6.0]])  # [mm] where a flat frame yields contacts
NONE = Contacts.of([])


def touches(rng, count, reading, touch, first=0):
    """Contacts of touches of the plane z = 0, six readings each, on a stage that errs."""
    points, normals, of = [], [], []
    for t in range(count):
        middle, lift = rng.uniform(-30, 30, 2), rng.normal(0, touch)
        for _ in range(6):
            at = middle + rng.uniform(-8, 8, 2) + FOOT
            points.append(np.column_stack([at, lift + rng.normal(0, reading) + rng.normal(0, 0.005, 4)]))
            normals.append(np.tile(np.append(rng.normal(0, 0.002, 2), 1.0), (4, 1)))
            of += [first + t] * 4
    n = np.concatenate(normals)
    return Contacts.of(
        np.concatenate(points), n / np.linalg.norm(n, axis=1, keepdims=True), 0.01, 0.004, touch=np.array(of)
    )


def graph_of(contacts):
    """A graph of one face."""
    return PatchGraph(options=CONVEX).add_stroke(contacts)[0]


@pytest.mark.parametrize(("reading", "touch"), [(0.05, 0.02), (0.02, 0.05), (0.1, 0.1)])
def test_touches_tell_what_stage_and_touch_add(reading, touch):
    found = scatter_of(graph_of(touches(np.random.default_rng(0), 30, reading, touch)), NONE)
    assert found == pytest.approx(np.hypot(reading, touch), rel=0.35)


def test_an_exact_stage_adds_next_to_nothing():
    assert scatter_of(graph_of(touches(np.random.default_rng(1), 12, 0.0, 0.0)), NONE) < 0.008


@pytest.mark.parametrize("sigma", [0.03, 0.06, 0.1])
def test_what_contacts_say_themselves_that_they_err_is_no_scatter(sigma):
    rng = np.random.default_rng(4)
    exact = touches(rng, 12, 0.0, 0.0)
    points = exact.points + rng.normal(0, sigma, (len(exact), 1)) * [0.0, 0.0, 1.0]
    assert (
        scatter_of(graph_of(Contacts.of(points, exact.normals, sigma, 0.004, touch=exact.touch)), NONE) == 0.0
    )


def test_lone_contacts_tell_nothing_of_touches():
    rng = np.random.default_rng(5)
    points = np.column_stack([rng.uniform(-30, 30, (20, 2)), rng.normal(0, 0.2, 20)])
    lone = Contacts.of(points, np.tile([0.0, 0.0, 1.0], (20, 1)), 0.01, 0.004, touch=np.arange(20))
    assert scatter_of(graph_of(lone), NONE) == 0.0


def test_what_was_held_to_lie_beside_the_face_counts():
    rng = np.random.default_rng(2)
    near, far = touches(rng, 6, 0.0, 0.01), touches(rng, 12, 0.0, 0.2, first=6)
    far = far.select(np.abs(far.points[:, 2]) < 0.39)
    graph = graph_of(near)
    assert scatter_of(graph, far) > 3 * scatter_of(graph, NONE)
    away = Contacts.of(far.points + np.array([0, 0, 3.0]), far.normals, 0.01, touch=far.touch)
    assert scatter_of(graph, away) == scatter_of(graph, NONE)


def test_nothing_felt_tells_nothing():
    assert scatter_of(PatchGraph(options=CONVEX), NONE) == 0.0


def test_a_face_takes_in_what_the_scatter_allows():
    rng = np.random.default_rng(3)
    graph = graph_of(touches(rng, 10, 0.05, 0.05))
    rough = graph.scattered(0.07)
    assert (
        rough.faces[0].fit.chi2 / rough.faces[0].fit.dof
        < 1.5
        < graph.faces[0].fit.chi2 / graph.faces[0].fit.dof
    )
    assert np.array_equal(rough.faces[0].contacts.sigma, graph.faces[0].contacts.sigma)
    assert np.allclose(rough.faces[0].weighed.sigma, np.hypot(0.01, 0.07))
