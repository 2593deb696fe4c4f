"""Normals of which some point the other way than those beside them."""

from pathlib import Path

import numpy as np
import pytest

from models import parts
from models.solid import Solid
from primitives.evidence import Contacts
from recognition.reconstructing.facing_alike import facing_alike
from recognition.reconstructing.options import ReconstructSourceOptions
from recognition.reconstructing.run import run
from recognition.sources import Source
from recognition.truth import LabeledFaces, TruthOptions, sample_surface


def on_a_part(name, rng, count=2000, sigma=0.02):
    solid = Solid.from_csg(parts.build(name))
    points = sample_surface(solid, TruthOptions(samples=count), LabeledFaces.of(solid))[0].points
    normals = solid.normals(points) + 0.02 * rng.standard_normal(points.shape)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return points + sigma * rng.standard_normal((len(points), 1)) * normals, normals


def source(points, normals, kind="contacts"):
    return Source(Path("c.csv"), kind, "c", Contacts.of(points, normals, 0.02, 0.05), False)


@pytest.mark.parametrize("share", [0.02, 0.3])
@pytest.mark.parametrize("name", ["bracket", "flange", "dish", "pipe"])
def test_what_points_the_other_way_than_its_face_is_turned(name, share):
    rng = np.random.default_rng(0)
    points, normals = on_a_part(name, rng)
    flipped = rng.random(len(points)) < share
    told = facing_alike(source(points, np.where(flipped[:, None], -normals, normals)))
    assert (
        np.mean((told.contacts.normals * normals).sum(axis=1) < 0) < 0.02
    )  # a face of a few contacts may be turned by chance
    assert len(told.warnings) == 1
    assert f"{flipped.mean():.0%} of the contacts" in told.warnings[0]


@pytest.mark.parametrize("name", ["bracket", "flange", "dish", "pipe", "t_plate"])
def test_normals_that_agree_stay_as_they_are(name):
    rng = np.random.default_rng(1)
    points, normals = on_a_part(name, rng)
    for few in (slice(None), slice(None, None, 20)):
        given = source(points[few], normals[few])
        assert facing_alike(given) is given
    inward = source(points, -normals)
    assert facing_alike(inward) is inward  # all of them


def test_the_sides_of_a_thin_sheet_are_two():
    rng = np.random.default_rng(2)
    up = np.tile([0.0, 0.0, 1.0], (400, 1))
    side = np.where(rng.random(400) < 0.5, 1.0, -1.0)[:, None]
    points = np.column_stack([rng.uniform(-50.0, 50.0, (400, 2)), np.zeros(400)]) + 0.4 * side * up
    given = source(points + 0.02 * rng.standard_normal((400, 1)) * up, side * up)
    assert facing_alike(given) is given


def test_without_normals_and_in_a_run_nothing_is_turned():
    rng = np.random.default_rng(3)
    points, normals = on_a_part("bracket", rng)
    mixed = np.where(rng.random((len(points), 1)) < 0.3, -normals, normals)
    for given in (source(points, None), source(points, mixed, "run"), source(points[:5], mixed[:5])):
        assert facing_alike(given) is given


@pytest.mark.slow
def test_a_cloud_with_mixed_normals_is_reconstructed_and_that_is_told(tmp_path):
    rng = np.random.default_rng(4)
    points, normals = on_a_part("stepped_block", rng)
    mixed = np.where(rng.random((len(points), 1)) < 0.3, -normals, normals)
    np.savetxt(tmp_path / "c.csv", np.hstack([points, mixed]), delimiter=",")
    told = run(ReconstructSourceOptions(tmp_path / "c.csv", out=tmp_path / "run"), lambda _: None)
    assert told["closed"]
    assert len(told["faces"]) == 8
    assert any("point against those beside them" in warning for warning in told["warnings"])
