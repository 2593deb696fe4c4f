"""Which faces stay."""

from dataclasses import replace

import numpy as np
import pytest

from exploration.planning.faces.consistency import drop_astride, drop_poor, flattened
from primitives.evidence import Contacts
from primitives.fit import fit
from primitives.patch_graph import Face, PatchGraph
from primitives.shapes import Plane


def flat(off):
    """A flat face of contacts that lie as far off it as is said [mm]."""
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(-30, 30, (len(off), 2)), off])
    contacts = Contacts.of(points, np.tile([0.0, 0.0, 1.0], (len(off), 1)), 0.05, 0.02)
    return PatchGraph((Face(0, fit("plane", contacts), contacts),), ())


@pytest.mark.parametrize(
    ("off", "stays"),
    [
        (np.r_[np.tile([0.01, -0.01], 12), 0.3, 0.25], True),  # a narrow ring, two contacts at its rim
        (np.tile([0.1, -0.1], 13), False),  # a pad across an inside corner
        (np.r_[0.01, -0.01, 0.0, 0.0, 0.01, 0.4], False),  # too few to tell strays from the face
        (np.tile([0.1, -0.1], 20), True),  # many say what they say
    ],
)
def test_few_scattered_contacts_are_no_face_and_a_few_strays_do_not_undo_one(off, stays):
    graph = flat(off)
    assert graph.faces[0].fit.rms > 0.05
    assert bool(drop_poor(graph).faces) == stays


@pytest.mark.parametrize(("half", "stays"), [(0.7, True), (0.1, False)])
def test_a_trough_that_a_pad_bridged_stays_where_it_was_felt_round_it(half, stays):
    turn, along = np.meshgrid(np.linspace(-half, half, 4), np.linspace(-12.0, 12.0, 5), indexing="ij")
    turn, along = turn.ravel(), along.ravel()
    out = np.column_stack([np.sin(turn), np.zeros(20), -np.cos(turn)])
    points = 17.0 * out + along[:, None] * np.eye(3)[1]
    bridged = points - np.tile([0.12, -0.12], 10)[:, None] * out
    contacts = Contacts.of(bridged, -out, 0.02, 0.02)
    wall = replace(fit("cylinder", Contacts.of(points, -out, 0.02, 0.02)), inliers=np.ones(20, dtype=bool))
    assert wall.shape.radius == pytest.approx(17.0, abs=1e-6)
    assert bool(drop_poor(PatchGraph((Face(0, wall, contacts),), ())).faces) == stays


@pytest.mark.parametrize(("sigma", "unsure", "stays"), [(0.06, 0, True), (0.02, 0, False), (0.02, 5, False)])
def test_contacts_scatter_as_they_say_and_unsure_ones_excuse_no_sure_ones(sigma, unsure, stays):
    off = np.r_[np.tile([0.065, -0.065], 4), 0.065, np.zeros(unsure)]
    sigmas = np.r_[np.full(9, sigma), np.full(unsure, 0.14)]
    points = np.column_stack([10.0 * np.cos(np.arange(len(off))), 10.0 * np.sin(np.arange(len(off))), off])
    contacts = Contacts.of(points, np.tile([0.0, 0.0, 1.0], (len(off), 1)), sigmas, 0.02)
    plane = replace(fit("plane", contacts), shape=Plane(np.zeros(3), [0.0, 0.0, 1.0]))
    assert bool(drop_poor(PatchGraph((Face(0, plane, contacts),), ())).faces) == stays


def test_contacts_that_are_unsure_of_themselves_do_not_make_a_face_poor():
    off = np.array([0.01, -0.02, 0.01, 0.02, -0.01, 0.9, -0.8, 0.7])
    points = np.column_stack([np.arange(8.0), np.arange(8.0)[::-1] ** 2 / 7.0, off])
    sigma = np.array([0.02] * 5 + [0.8] * 3)
    contacts = Contacts.of(points, np.tile([0.0, 0.0, 1.0], (8, 1)), sigma, 0.02)
    assert drop_poor(PatchGraph((Face(0, fit("plane", contacts), contacts),), ()), 0.15).faces
    sure = Contacts.of(points, np.tile([0.0, 0.0, 1.0], (8, 1)), 0.02, 0.02)
    assert not drop_poor(PatchGraph((Face(0, fit("plane", sure), sure),), ()), 0.15).faces
    fewer = contacts.select(np.array([0, 1, 2, 3, 5, 6, 7]))
    assert not drop_poor(PatchGraph((Face(0, fit("plane", fewer), fewer),), ()), 0.15).faces


@pytest.mark.parametrize(("thick", "count", "stays"), [(1.2, 5, False), (12.0, 5, True), (1.2, 12, True)])
def test_a_few_contacts_past_both_sides_of_a_sheet_are_no_round_face_of_its_edge(thick, count, stays):
    grid = np.array(np.meshgrid(np.arange(-30.0, 1.0, 5.0), np.arange(-20.0, 21.0, 5.0))).reshape(2, -1).T
    sides = []
    for number, up in enumerate((1.0, -1.0)):
        points = np.column_stack([grid, np.full(len(grid), 0.5 * up * thick)])
        contacts = Contacts.of(points, np.tile([0.0, 0.0, up], (len(grid), 1)), 0.02, 0.02)
        sides.append(Face(number, fit("plane", contacts), contacts))
    height = np.linspace(-2.0, 2.0, count)
    turn = np.tile([-0.2, 0.1, 0.25], count)[:count]
    normals = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(count)])
    points = np.column_stack([12.0 * normals[:, :2] - [12.0, 0.0], height])
    edge = Contacts.of(points, normals, 0.02, 0.02)
    made = fit("cylinder", edge)
    assert made
    kept = drop_astride(PatchGraph((*sides, Face(2, made, edge)), ())).faces
    assert [face.id for face in kept] == ([0, 1, 2] if stays else [0, 1])


@pytest.mark.parametrize(("tilt", "kind"), [(0.1, "plane"), (34.0 / 600.0, "sphere")])
def test_a_narrow_ring_is_flat_though_a_few_pads_leaned_over_its_rim(tilt, kind):
    """Of a dome every normal leans, and not only those of strays."""
    turn, rng = np.linspace(0.0, 6.0, 20), np.random.default_rng(2)
    out = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])
    stray = np.arange(20) % 4 == 0  # sure of itself, as a pad is that most of a face fills
    leans = np.where(stray, tilt, 0.0 if kind == "plane" else tilt)
    points = rng.normal(34.0, 0.8, (20, 1)) * out + rng.normal(0.0, 0.035, (20, 1)) * [0.0, 0.0, 1.0]
    normals = np.column_stack([np.sin(leans)[:, None] * out[:, :2], np.cos(leans)])
    contacts = Contacts.of(points, normals, 0.03, np.where(stray, 0.02, 0.1 if kind == "plane" else 0.02))
    bent = fit("sphere", contacts)
    (face,) = flattened(PatchGraph((Face(0, bent, contacts),), ())).faces
    assert bent.shape.radius > 360.0
    assert face.fit.kind == kind
