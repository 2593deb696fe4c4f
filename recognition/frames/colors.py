"""The colors of taxel images and what is drawn over them, the same as on a run's page."""

Color = tuple[int, int, int]


def _color(text: str) -> Color:
    return int(text[0:2], 16), int(text[2:4], 16), int(text[4:6], 16)


PAPER, INK, SOFT, RULE = _color("fbfaf8"), _color("1c2024"), _color("5d646b"), _color("e3e0da")
HEAT = tuple(map(_color, ("efece6", "b9d3d3", "6aa5ac", "2b6b7c", "0f3347")))
LINES = tuple(map(_color, ("c4502e", "d99a2b", "8d5fb0", "2d7a4f")))
ARC = _color("c2367a")
POINT = _color("e0642f")
KINDS = {
    "nothing": _color("c9c4bb"),
    "flat": _color("8fb4d6"),
    "edge": _color("c4502e"),
    "ridge": _color("e6b04a"),
    "corner": _color("8d5fb0"),
    "curved": _color("1f8a70"),
}


def heat(share: float) -> Color:
    """Untouched at 0, the firmest at 1."""
    place = min(3.999, max(0.0, share * 4))
    i = int(place)
    return blend(HEAT[i], HEAT[i + 1], place - i)


def blend(a: Color, b: Color, share: float) -> Color:
    """From a to b."""
    r, g, blue = (round(x + (y - x) * share) for x, y in zip(a, b, strict=True))
    return r, g, blue
