"""JSON schemas of a recording's messages; the `foxglove.` ones are Foxglove's well-known message types."""

from typing import Any


def _object(title: str, **properties: Any) -> dict[str, Any]:
    return {"title": title, "type": "object", "properties": properties}


_NUMBER = {"type": "number"}
_TEXT = {"type": "string"}
_WHOLE = {"type": "integer", "minimum": 0}
_TIME = _object("time", sec=_WHOLE, nsec={"type": "integer", "minimum": 0, "maximum": 999_999_999})
_VECTOR = _object("foxglove.Vector3", x=_NUMBER, y=_NUMBER, z=_NUMBER)
_QUATERNION = _object("foxglove.Quaternion", x=_NUMBER, y=_NUMBER, z=_NUMBER, w=_NUMBER)

SCHEMAS: dict[str, dict[str, Any]] = {
    "foxglove.RawImage": _object(
        "foxglove.RawImage",
        timestamp=_TIME,
        frame_id=_TEXT,
        width=_WHOLE,
        height=_WHOLE,
        encoding=_TEXT,
        step=_WHOLE,
        data={"type": "string", "contentEncoding": "base64"},
    ),
    "foxglove.FrameTransform": _object(
        "foxglove.FrameTransform",
        timestamp=_TIME,
        parent_frame_id=_TEXT,
        child_frame_id=_TEXT,
        translation=_VECTOR,
        rotation=_QUATERNION,
    ),
    "palpate.Wrench": _object("palpate.Wrench", timestamp=_TIME, force=_VECTOR, torque=_VECTOR),
    "palpate.Event": _object("palpate.Event", timestamp=_TIME, kind=_TEXT, detail={"type": "object"}),
}
