"""Contacts that speak against the model that is made of them."""

import numpy as np

from models.csg import Cube
from models.solid import Solid
from recognition.reconstructing.options import ReconstructSourceOptions
from recognition.reconstructing.run import run
from recognition.truth import LabeledFaces, TruthOptions, sample_surface


def _told(tmp_path, more=()):
    """Warnings of a block of which (n, 3) more places were touched."""
    rng = np.random.default_rng(0)
    solid = Solid.from_csg(Cube((60.0, 40.0, 20.0)))
    points = sample_surface(solid, TruthOptions(samples=300), LabeledFaces.of(solid))[0].points
    points = points + 0.03 * rng.standard_normal(points.shape)
    normals = solid.normals(points)
    rows = [*np.hstack([points, normals]).tolist(), *([*place, 1.0, 0.0, 0.0] for place in more)]
    lines = ["x,y,z,nx,ny,nz", *(",".join(f"{value:.5f}" for value in row) for row in rows)]
    path = tmp_path / "cloud.csv"
    path.write_text("\n".join(lines) + "\n")
    return run(ReconstructSourceOptions(source=path, out=tmp_path / "made"), lambda told: None)["warnings"]


def test_contacts_within_the_body_are_told_with_how_deep_they_lie(tmp_path):
    (told,) = [
        w for w in _told(tmp_path, [[5.0, 3.0, 7.0], [6.0, -4.0, 2.0]]) if "contacts lie on no face" in w
    ]
    assert told.startswith("2 contacts")
    assert "8.0 mm off" in told


def test_contacts_of_the_body_alone_speak_against_nothing(tmp_path):
    assert not any("lie on no face" in w for w in _told(tmp_path))
