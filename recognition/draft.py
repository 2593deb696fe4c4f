"""A draft of the object while it is explored: the surface of the body that all faces so far make."""

from __future__ import annotations

import numpy as np

from exploration.planning.moves.drafted import SPACING
from exploration.planning.open.frontier import Predicted
from exploration.planning.touching.findings import Findings
from models.library.samples import SampleConfig, surface_samples
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.fit import Fit
from recognition.assembly import NotClosed
from recognition.best_body import FeltFace, best_body
from recognition.reconstruct import ReconstructOptions

_MOST = 6000  # places


def draft(found: Findings, box: Floats) -> Predicted:
    """Places on the body that findings make in a (2, 3) workspace `box` [mm]; none where they make no body."""
    shaped = [FeltFace(face.fit, face.contacts) for face in found.graph.faces if isinstance(face.fit, Fit)]
    loose = [face.contacts for face in found.graph.faces if not isinstance(face.fit, Fit)]
    free = np.concatenate(found.inside) if found.inside else None
    body = best_body(shaped, box, free, ReconstructOptions().run_on, Contacts.concatenate(loose))
    if isinstance(body.assembly, NotClosed):
        return Predicted(np.empty((0, 3)), np.empty((0, 3)), np.empty(0, dtype=np.int64))
    solid = body.assembly.solid
    count = min(_MOST, round(solid.area / SPACING**2))
    samples = surface_samples(solid, SampleConfig(count))
    return Predicted(samples.points, samples.normals, samples.face)
