"""Pictures of flat faces, written into the recording when exploration ends, and read back.

    picture: {"anchor_mm", "normal", "step_mm", "shape": [n, m], "share": base64 of n * m bytes, row by row}

A byte is the share of the face under the skin, 0 to 250 for 0 to 1; 255 where nobody looked.
"""

from __future__ import annotations

import base64
import binascii
from collections.abc import Mapping
from typing import Any

import numpy as np

from exploration.planning.known.face_pictures import FacePicture

PICTURE = "picture"
_WHOLE, _UNKNOWN = 250, 255
_FLAT = 2  # dimensions


def told(picture: FacePicture) -> dict[str, object]:
    """A picture as an event's detail."""
    share = np.round(_WHOLE * np.clip(np.nan_to_num(picture.share), 0.0, 1.0))
    share[np.isnan(picture.share)] = _UNKNOWN
    return {
        "anchor_mm": picture.anchor.tolist(),
        "normal": picture.normal.tolist(),
        "step_mm": picture.step,
        "shape": list(picture.share.shape),
        "share": base64.b64encode(share.astype(np.uint8).tobytes()).decode(),
    }


def picture(detail: Mapping[str, Any]) -> FacePicture | None:
    """What an event tells; None where it is not as this version writes it."""
    try:
        raw = np.frombuffer(base64.b64decode(detail["share"]), dtype=np.uint8).astype(float)
        share = np.where(raw == _UNKNOWN, np.nan, raw / _WHOLE).reshape(detail["shape"])
        if share.ndim != _FLAT or not share.size:
            return None
        anchor, normal = (np.array(detail[key], dtype=float).reshape(3) for key in ("anchor_mm", "normal"))
        step = float(detail["step_mm"])
        whole = np.isfinite([*anchor, *normal, step]).all() and step > 0.0
        return FacePicture(anchor, normal, share, step) if whole else None
    except (KeyError, TypeError, ValueError, binascii.Error):
        return None
