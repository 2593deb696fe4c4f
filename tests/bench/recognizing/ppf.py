"""Point pair features of OpenCV (Drost et al. 2010), refined by point-to-plane ICP and ranked by residual.

OpenCV's own ICP moves a dense model onto the scene, which a dozen contacts do not carry; contacts are moved onto
the exact model instead, by the same Gauss-Newton that refines ours.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from recognizing.residual import by_residual

from models.library import Entry
from primitives.arrays import Floats
from primitives.evidence import Contacts
from primitives.pose import inverse

_POSES = 8  # of an object that are refined
_MODEL = 350  # samples of an object


class Ppf:
    """Every object of a library trained once."""

    def __init__(self, library: Mapping[str, Entry]) -> None:
        import cv2

        self._library = library
        self._trained: dict[str, Any] = {}
        for name, entry in library.items():
            rows = np.hstack([entry.samples.points, entry.samples.normals])[:_MODEL].astype(np.float32)
            detector = cv2.ppf_match_3d.PPF3DDetector(0.05, 0.05, 30)
            detector.trainModel(rows)
            self._trained[name] = detector

    def __call__(self, contacts: Contacts) -> tuple[str, Floats]:
        """The name with the least residual, and its pose."""
        import cv2

        scene = np.hstack([contacts.points, contacts.normals]).astype(np.float32)
        best: tuple[float, str, Floats] = (np.inf, "", np.eye(4))
        for name, detector in self._trained.items():
            try:
                found = detector.match(scene, 1.0, 0.02)[:_POSES]
            except cv2.error:
                continue
            starts = [inverse(np.asarray(f.pose, dtype=float).reshape(4, 4))[:3] for f in found]
            if starts:
                residual, at = by_residual(self._library[name], contacts, np.stack(starts))
                best = min(best, (residual, name, at), key=lambda b: b[0])
        return best[1], best[2]
