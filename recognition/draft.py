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
from recognition.bridging import NOWHERE, bridging
from recognition.reconstruct import ReconstructOptions

_MOST = 6000  # places


def draft(found: Findings, box: Floats) -> Predicted:
    """Places on the body that findings make in a (2, 3) workspace `box` [mm]; none where they make no body.

    Where that is in pieces, places between them come first.
    """
    shaped = [FeltFace(face.fit, face.contacts) for face in found.graph.faces if isinstance(face.fit, Fit)]
    loose = [face.contacts for face in found.graph.faces if not isinstance(face.fit, Fit)]
    free = np.concatenate(found.inside) if found.inside else None
    body = best_body(
        shaped, box, free, ReconstructOptions().run_on, Contacts.concatenate(loose), found.plates
    )
    if isinstance(body.assembly, NotClosed):
        return NOWHERE
    solid = body.assembly.solid
    count = min(_MOST, round(solid.area / SPACING**2))
    samples = surface_samples(solid, SampleConfig(count))
    joins = bridging(solid) if solid.parts > 1 else NOWHERE
    return Predicted(
        np.concatenate([joins.points, samples.points]),
        np.concatenate([joins.normals, samples.normals]),
        np.concatenate([joins.face, samples.face]),
    )
