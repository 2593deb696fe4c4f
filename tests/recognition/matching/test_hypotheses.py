"""Which contacts a search of poses begins with."""

from collections.abc import Sequence

import numpy as np

from primitives.evidence import Contacts
from recognition.matching.hypotheses import SearchConfig, begin


def _touch(middle: Sequence[float], normal: Sequence[float]) -> tuple[np.ndarray, np.ndarray]:
    """Four contacts of one touch on a face."""
    n = np.array(normal)
    across = np.eye(3)[n == 0.0]
    corners = np.array([[5.0, 4.0], [5.0, -4.0], [-5.0, 4.0], [-5.0, -4.0]])
    return np.array(middle) + corners @ across, np.tile(n, (4, 1))


def test_a_pose_is_scored_by_every_face_that_was_felt() -> None:
    """Five touches on two opposite faces leave it sliding along them; only the sixth, the last, holds its end."""
    up, down = [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]
    broad = [([0, 0, 8], up), ([5, 9, -8], down), ([-9, 0, -8], down), ([-20, 4, 8], up), ([9, -9, -8], down)]
    felt = [_touch(*told) for told in [*broad, ([-30, 0, 0], [-1.0, 0.0, 0.0])]]
    points, normals = (np.concatenate(part) for part in zip(*felt, strict=True))
    _, first, _ = begin(Contacts.of(points, normals, 0.1, 0.02), SearchConfig(), 0.1).few
    assert (first[:, 0] < -0.9).any()
