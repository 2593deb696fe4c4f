"""A reconstruction on disk: contacts, boundary, CSG and meshes, each whole or not there."""

from __future__ import annotations

from models.formats import mesh, openscad, step_out
from models.formats.sound import sound
from primitives.errors import NotWritten, PalpateError
from recognition.assembly import NotClosed
from recognition.assembly.described import written_tree
from recognition.reconstruct import Reconstruction
from recognition.running.folder import RunFolder


def write_model(folder: RunFolder, made: Reconstruction) -> tuple[dict[str, str], list[str]]:
    """Write what there is; `files` of the summary, and what could not be written, as warnings."""
    folder.write_contacts(made.contacts, made.face_of_contact)
    folder.write_json("brep.json", made.brep_json())
    files = {"report": "report.html"}
    if isinstance(made.assembly, NotClosed):
        return files, []
    with folder.writing("model.csg") as path:
        openscad.write(written_tree(made.assembly), path)
    surface = sound(made.assembly.solid)
    for name in ("model.stl", "model.glb"):
        with folder.writing(name) as path:
            mesh.save(surface, path)
    files = {"model": "model.csg", "mesh": "model.stl", **files}
    if step_out.available():
        try:
            with folder.writing("model.step") as path:
                step_out.write(made.assembly.tree, path, name="model")
            files["step"] = "model.step"
        except NotWritten:
            raise
        except PalpateError as error:
            return files, [f"no model.step: {error}"]
    return files, []
