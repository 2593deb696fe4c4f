"""Flat faces as the skin saw them, on the page: one picture a face, inked where it was there.

A picture is a mask, so that it has the page's own color, by day and by night.
"""

from __future__ import annotations

import base64
import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from PIL import Image

from exploration.planning.known.face_pictures import FacePicture
from primitives.arrays import Floats
from recognition.report.run_report import SkinPicture

_WIDEST = 260.0  # [px] of the widest picture; all are to one scale
_LEAST = 1.0  # [px/mm]
_MOST = 24  # pictures, the largest first
_FLUSH, _OFF = 0.995, 0.5  # least cosine of their ways and [mm] between a picture and its face
_BARE = 0.14  # of the ink, where a face was seen not to be


def of_faces(pictures: Sequence[FacePicture], faces: Sequence[Mapping[str, Any]]) -> list[SkinPicture]:
    """Pictures with the ids of the summary's faces that they are of."""
    return [SkinPicture(_face_of(picture, faces), picture.share, picture.step) for picture in pictures]


def _face_of(picture: FacePicture, faces: Sequence[Mapping[str, Any]]) -> int | None:
    """The largest face in the plane of a picture that looks its way."""
    best, area = None, 0.0
    for face in faces:
        if face["shape"] != "plane":
            continue
        told = face["parameters"]
        way = float(np.array(told["axis"]) @ picture.normal)
        off = abs(float((np.array(told["origin_mm"]) - picture.anchor) @ picture.normal))
        if way > _FLUSH and off < _OFF and (face["area_mm2"] or 0.0) >= area:
            best, area = int(face["id"]), face["area_mm2"] or 0.0
    return best


def skin_pictures(pictures: Sequence[SkinPicture]) -> str:
    """HTML of all pictures; nothing where there are none."""
    if not pictures:
        return ""
    shown = sorted(pictures, key=lambda picture: -picture.share.size)[:_MOST]
    widest = max(picture.share.shape[0] * picture.step for picture in shown)
    scale = max(_WIDEST / widest, _LEAST)
    figures = "".join(_figure(picture, scale) for picture in shown)
    told = "Inked where the face was under the skin, pale where it was not, blank where nobody looked."
    return f'<p class="felt">{told}</p><div class="skins">{figures}</div>'


def _figure(picture: SkinPicture, scale: float) -> str:
    wide, high = (count * picture.step * scale for count in picture.share.shape)
    url = f"url(data:image/png;base64,{base64.b64encode(_png(picture.share)).decode()})"
    style = f"width:{wide:.0f}px;height:{high:.0f}px;-webkit-mask-image:{url};mask-image:{url}"
    name = "A face" if picture.face is None else f"Face {picture.face}"
    label = f"{name}, as the skin saw it"
    return (
        f'<figure><i role="img" aria-label="{label}" style="{style}"></i>'
        f"<figcaption>{name}</figcaption></figure>"
    )


def _png(share: Floats) -> bytes:
    """An image, black and more or less opaque, of an (n, m) share with x along n and y up."""
    ink = _BARE + (1.0 - _BARE) * np.clip(share, 0.0, 1.0)
    ink[np.isnan(share)] = 0.0
    opacity = Image.fromarray(np.round(255.0 * ink.T[::-1]).astype(np.uint8))
    file = io.BytesIO()
    Image.merge("LA", (Image.new("L", opacity.size), opacity)).save(file, "PNG", optimize=True)
    return file.getvalue()
