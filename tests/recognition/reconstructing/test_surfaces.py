"""Clouds of any size to the faces that they lie on."""

import numpy as np
import pytest

from primitives.evidence import Contacts
from primitives.fit import fit
from recognition.reconstructing.options import ReconstructSourceOptions
from recognition.reconstructing.run import run
from recognition.reconstructing.surfaces import SurfaceOptions, _owners, surfaces


def on_a_block(count, size=(60.0, 40.0, 12.0), seed=0):
    rng, half = np.random.default_rng(seed), np.array(size) / 2
    axis = rng.choice(3, count)
    sign = rng.choice([-1.0, 1.0], count)
    points = rng.uniform(-1, 1, (count, 3)) * half
    points[np.arange(count), axis] = sign * half[axis]
    normals = np.zeros((count, 3))
    normals[np.arange(count), axis] = sign
    return points, normals


@pytest.mark.slow
def test_contacts_that_were_not_chosen_join_the_face_that_explains_them():
    points, normals = on_a_block(1200)
    graph = surfaces(Contacts.of(points, normals, 0.01, 0.02), SurfaceOptions(chosen=250, fitted=200))
    assert [face.fit.kind for face in graph.faces] == ["plane"] * 6
    assert sum(len(face.contacts) for face in graph.faces) > 1150


@pytest.mark.slow
def test_two_faces_of_one_cylinder_do_not_share_its_contacts_by_the_side_that_noise_put_them_on():
    """A rod of 17 mm with a groove round it: what is above it is one face, what is below another."""
    rng, count, sigma = np.random.default_rng(0), 6000, 0.1
    turn, height = rng.uniform(0.0, 2 * np.pi, count), rng.uniform(0.0, 60.0, count)
    outward = np.column_stack([np.cos(turn), np.sin(turn), 0.0 * turn])
    points = 17.0 * outward + height[:, None] * np.eye(3)[2] + sigma * rng.standard_normal((count, 3))
    rod = np.abs(height - 20.0) > 4.0
    graph = surfaces(Contacts.of(points[rod], outward[rod], sigma, 0.05))
    above, below = (face for face in graph.faces if face.fit)
    assert above.contacts.points[:, 2].min() > 20.0 > below.contacts.points[:, 2].max()
    for face in (above, below):
        assert face.fit.shape.radius == pytest.approx(17.0, abs=0.01)


@pytest.mark.slow
def test_a_cloud_becomes_a_run_folder_with_one_cube(tmp_path):
    points, normals = on_a_block(240)
    np.savetxt(tmp_path / "c.csv", np.hstack([points, normals]), delimiter=",")
    out = tmp_path / "run"
    told = run(ReconstructSourceOptions(tmp_path / "c.csv", 0.01, out=out), lambda _: None)
    assert told["closed"]
    assert told["csg"] == {"leaves": 1}
    assert abs(told["volume_mm3"] - 60 * 40 * 12) < 1.0
    assert {"summary.json", "model.csg", "model.stl", "report.html"} <= {p.name for p in out.iterdir()}


@pytest.mark.slow
def test_places_that_were_read_often_are_one_contact_each(tmp_path):
    points, normals = on_a_block(200)
    rng = np.random.default_rng(2)
    points += 0.03 * rng.standard_normal((200, 1)) * normals
    table = np.repeat(np.hstack([points, normals]), 8, axis=0)
    table[:, :3] += 0.002 * rng.standard_normal((1600, 3))
    np.savetxt(tmp_path / "c.csv", table, delimiter=",")
    told = run(ReconstructSourceOptions(tmp_path / "c.csv", out=tmp_path / "run"), lambda _: None)
    assert told["closed"]
    assert len(told["faces"]) == 6
    assert told["contacts"] == 200
    assert "1400 of 1600 contacts were read where another was, and count once with it" in told["warnings"]


@pytest.mark.slow
def test_a_step_of_which_nobody_felt_the_bottom_ends_where_contacts_do(tmp_path):
    # an L of 60 x 40 x 12 with an upright leg of 20 x 40 x 28: corner, two sides, and the way each face looks
    faces = [
        ((-30, -20, 0), (0, 40, 0), (0, 0, 40), (-1, 0, 0)), ((30, -20, 0), (0, 40, 0), (0, 0, 12), (1, 0, 0)),
        ((-10, -20, 12), (0, 40, 0), (0, 0, 28), (1, 0, 0)), ((-30, -20, 40), (20, 0, 0), (0, 40, 0), (0, 0, 1)),
        ((-10, -20, 12), (40, 0, 0), (0, 40, 0), (0, 0, 1)), ((-30, -20, 0), (60, 0, 0), (0, 0, 12), (0, -1, 0)),
        ((-30, 20, 0), (60, 0, 0), (0, 0, 12), (0, 1, 0)), ((-30, -20, 12), (20, 0, 0), (0, 0, 28), (0, -1, 0)),
        ((-30, 20, 12), (20, 0, 0), (0, 0, 28), (0, 1, 0)),
    ]  # fmt: skip
    rng = np.random.default_rng(0)
    each = [
        np.array(c) + rng.random((200, 1)) * np.array(a) + rng.random((200, 1)) * b for c, a, b, _ in faces
    ]
    table = np.hstack([np.concatenate(each), np.repeat([n for *_, n in faces], 200, axis=0)])
    np.savetxt(tmp_path / "c.csv", table, delimiter=",")
    told = run(ReconstructSourceOptions(tmp_path / "c.csv", 0.01, out=tmp_path / "run"), lambda _: None)
    assert told["volume_mm3"] == pytest.approx(60 * 40 * 12 + 20 * 40 * 28, rel=0.01)
    assert not told["closed"]
    assert any("cut off where contact ended" in warning for warning in told["warnings"])


@pytest.mark.slow
def test_a_cloud_without_normals_knows_its_faces_and_their_sides():
    points, normals = on_a_block(500)
    rng = np.random.default_rng(1)
    noisy = points + 0.1 * rng.standard_normal(points.shape)
    graph = surfaces(Contacts.of(noisy, None, 0.1))
    faces = [face for face in graph.faces if face.fit]
    assert [face.fit.kind for face in faces] == ["plane"] * 6
    row = {tuple(point): k for k, point in enumerate(noisy)}
    agree = [
        normals[row[tuple(p)]] @ n
        for face in faces
        for p, n in zip(face.contacts.points, face.contacts.normals, strict=True)
    ]
    assert np.mean(np.array(agree) > 0.9) > 0.97


def test_a_contact_that_its_neighbors_face_cannot_explain_is_of_another_that_can():
    """Nearest to contacts of the lower plane, and just too far from it; only the upper one explains it."""
    up, sigma = np.array([0.0, 0.0, 1.0]), 0.1
    spread = np.random.default_rng(0).uniform(-5.0, 5.0, (40, 2))
    low = np.column_stack([spread, np.zeros(40)])
    high = np.column_stack([spread[:, 0] + 30.0, spread[:, 1], np.full(40, 1.22)])
    points = np.concatenate([low, high, [[0.0, 0.0, 0.64]]])
    contacts = Contacts.of(points, np.tile(up, (len(points), 1)), sigma, 0.05)
    fits = [fit("plane", contacts.select(np.arange(40) + k)) for k in (0, 40)]
    before = np.repeat([0, 1, -1], [40, 40, 1])
    assert _owners(contacts, fits, before, SurfaceOptions())[-1] == 1
