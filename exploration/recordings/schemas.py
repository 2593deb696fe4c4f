"""JSON schemas of a recording's messages; the `foxglove.` ones are Foxglove's well-known message types."""

from typing import Any


def _object(title: str, **properties: Any) -> dict[str, Any]:
    return {"title": title, "type": "object", "properties": properties}


_NUMBER = {"type": "number"}
_TEXT = {"type": "string"}
_WHOLE = {"type": "integer", "minimum": 0}
_TIME = _object("time", sec=_WHOLE, nsec={"type": "integer", "minimum": 0, "maximum": 999_999_999})
_FLAG = {"type": "boolean"}
_VECTOR = _object("foxglove.Vector3", x=_NUMBER, y=_NUMBER, z=_NUMBER)
_QUATERNION = _object("foxglove.Quaternion", x=_NUMBER, y=_NUMBER, z=_NUMBER, w=_NUMBER)

_POSE = _object("foxglove.Pose", position=_VECTOR, orientation=_QUATERNION)
_COLOR = _object("foxglove.Color", r=_NUMBER, g=_NUMBER, b=_NUMBER, a=_NUMBER)


def _list(of: dict[str, Any]) -> dict[str, Any]:
    return {"type": "array", "items": of}


_ANY = _list({"type": "object"})  # of kinds that a recording never holds
_ENTITY = _object(
    "foxglove.SceneEntity",
    timestamp=_TIME,
    frame_id=_TEXT,
    id=_TEXT,
    lifetime=_object("duration", sec={"type": "integer"}, nsec=_WHOLE),
    frame_locked=_FLAG,
    metadata=_ANY,
    arrows=_ANY,
    cubes=_list(_object("foxglove.CubePrimitive", pose=_POSE, size=_VECTOR, color=_COLOR)),
    spheres=_ANY,
    cylinders=_ANY,
    lines=_ANY,
    triangles=_ANY,
    texts=_ANY,
    models=_ANY,
)

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
    "foxglove.SceneUpdate": _object("foxglove.SceneUpdate", deletions=_ANY, entities=_list(_ENTITY)),
    "foxglove.Log": _object(
        "foxglove.Log", timestamp=_TIME, level=_WHOLE, message=_TEXT, name=_TEXT, file=_TEXT, line=_WHOLE
    ),
    "palpate.Wrench": _object("palpate.Wrench", timestamp=_TIME, force=_VECTOR, torque=_VECTOR),
    "palpate.Event": _object("palpate.Event", timestamp=_TIME, kind=_TEXT, detail={"type": "object"}),
}
