import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from models.csg import Cube
from models.formats import mesh
from models.solid import Solid
from primitives.evidence import Contacts
from recognition.cli import app
from recognition.report.relabeled import labeled_mesh
from recognition.report.rewritten import rewrite
from recognition.running.folder import RunFolder


@pytest.fixture
def run(tmp_path) -> Path:
    folder = RunFolder(tmp_path)
    points = np.array([[0.0, 0.0, 5.0], [1.0, 0.0, 5.0], [0.0, 0.0, -5.0]])
    folder.write_contacts(Contacts.of(points), np.array([3, 3, 1]))
    mesh.save(Solid.from_csg(Cube((10.0, 10.0, 10.0))), tmp_path / "model.stl")
    folder.finish(
        {"command": "reconstruct", "version": "0", "part": "cube", "closed": True, "faces": [], "edges": []}
    )
    return tmp_path


def test_a_page_is_written_again_without_anything_but_its_folder(run):
    assert rewrite(run).read_text(encoding="utf-8").startswith("<!")
    assert "cube" in (run / "report.html").read_text(encoding="utf-8")


def test_triangles_have_the_face_of_the_contacts_on_them(run):
    model = labeled_mesh(run / "model.stl", np.array([[0.0, 0.0, 5.0], [0.0, 0.0, -5.0]]), np.array([3, 1]))
    height = model.vertices[model.triangles][:, :, 2]
    assert (model.face[(height > 4.99).all(axis=1)] == 3).all()
    assert (model.face[(height < -4.99).all(axis=1)] == 1).all()
    assert (model.face == -1).sum() == 8


@pytest.mark.parametrize(
    "summary", [None, "{", "[]", json.dumps({"command": 3}), '{"command": "experiment"}']
)
def test_a_folder_that_is_no_run_is_one_line(tmp_path, summary):
    if summary is not None:
        (tmp_path / "summary.json").write_text(summary)
    ended = CliRunner().invoke(app, ["report", str(tmp_path)])
    assert ended.exit_code == 1
    assert len(ended.stderr.strip().splitlines()) == 1
    assert "Traceback" not in ended.output
    assert not (tmp_path / "report.html").exists()
