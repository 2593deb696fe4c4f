"""What `palpate locate` and `palpate recognize` print."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from recognition.matching.belief import UNKNOWN
from recognition.report.terminal import table_text

_LEAST = 1e-6  # [mm] below which a residual is rounding

_TITLES = dict.fromkeys(
    (
        "object",
        "probability",
        "x, y, z [mm]",
        "quaternion w, x, y, z",
        "+- mm",
        "+- deg",
        "symmetry",
        "residual [mm]",
    ),
    "",
)


def summary_text(summary: Mapping[str, Any]) -> str:
    """The decision, then the candidates as a table."""
    s = summary
    what = "none of the library's objects" if s["decision"] == UNKNOWN else s["decision"]
    many = "1 contact" if s["contacts"] == 1 else f"{s['contacts']} contacts"
    head = f"{what}: {100 * s['confidence']:.1f} % sure from {many}, in {s['wall_seconds']:.2f} s"
    rows = [{**_TITLES, **_row(c)} for c in s["candidates"]]
    return "\n".join([head, table_text(rows), *_why(s["why"]), *(f"note: {line}" for line in s["warnings"])])


def _why(why: Mapping[str, Any]) -> list[str]:
    """The contacts that speak against the runner-up, and the touch that would tell more."""
    told = []
    if why["separating_contacts"] and why["runner_up"] != UNKNOWN:
        numbers = ", ".join(map(str, why["separating_contacts"]))
        told.append(f"not {why['runner_up']}: contacts {numbers} speak against it, counted from 0")
    if touch := why.get("separating_touch"):
        at, way = touch["start"]["translation_mm"], touch["direction"]
        what = (
            "a touch that would tell more"
            if touch["bits"]
            else "none tells them apart before one that places it"
        )
        more = f", {touch['bits']:.2f} bits expected" if touch["bits"] else ""
        told.append(f"{what}: from {_three(at, 1)} mm along {_three(way, 2)}{more}")
    return told


def _three(numbers: Sequence[float], places: int) -> str:
    return ", ".join(f"{x:.{places}f}" for x in numbers)


def _row(c: Mapping[str, Any]) -> dict[str, str]:
    told = {"object": c["name"], "probability": f"{c['probability']:.4f}"}
    if c["pose"] is None:
        return told
    return told | {
        "x, y, z [mm]": ", ".join(f"{x:.2f}" for x in c["pose"]["translation_mm"]),
        "quaternion w, x, y, z": ", ".join(f"{x:.4f}" for x in c["pose"]["quaternion_wxyz"]),
        "+- mm": f"{c['pose_sigma']['translation_mm']:.2g}",
        "+- deg": f"{c['pose_sigma']['rotation_deg']:.2g}",
        "symmetry": c["symmetry"],
        "residual [mm]": f"{c['residual_mm']:.3g}" if c["residual_mm"] > _LEAST else "0",
    }
