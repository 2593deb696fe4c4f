"""A track as a terminal shows it once it has ended."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from recognition.report.terminal import table_text
from recognition.tracking.surface import SHORTEST

_TRUTH = (
    ("rms_mm", "rms", " mm"),
    ("max_mm", "greatest", " mm"),
    ("normal_rms_deg", "normals rms", " deg"),
    ("dihedral_deg", "dihedral angle", " deg"),
    ("shape", "shape", ""),
)


def nothing_followed(summary: Mapping[str, Any]) -> str | None:
    """Why nothing was followed at all, in one line; None where something was."""
    found = summary["found"]
    if len(summary["trace"]) and found.get("length_mm", SHORTEST) >= SHORTEST:
        return None
    return f"no {summary['what']} was followed: {found.get('why', 'contact was lost')}"


def summary_text(summary: Mapping[str, Any], folder: Path | None = None) -> str:
    """What was followed, what it is, how true that is, where the run lies."""
    s, found, force = summary, summary["found"], summary["force_n"]
    until = "until something stood in the way" if found.get("ended") == "blocked" else "to its end"
    how = "closed" if s["closed"] else "lost" if s["lost"] else f"followed {until}"
    how = "not followed" if nothing_followed(s) else how
    lines = [f"{s['part']}: {s['what']} {how}, {_length(found)} in {s['device_seconds']:.1f} s on the device"]
    if force["mean"] is not None:
        lines.append(f"force: mean {force['mean']:.1f} N, greatest {force['max']:.1f} N")
    lines.append(f"the stage obeys {s['latency_ms']:.1f} ms late, as measured")
    if found.get("edges"):
        lines += ["", table_text([_edge_row(k, edge) for k, edge in enumerate(found["edges"])])]
    if found.get("shape"):
        sizes = ", ".join(
            f"{name} {value:.3f}" for name, value in found["parameters"].items() if isinstance(value, float)
        )
        lines.append(f"surface: {found['shape']}" + (f" ({sizes})" if sizes else ""))
    if found.get("order"):
        order = found["order"]
        lines.append(f"curvature where it was found: {order['name']} ({100 * order['probability']:.0f} %)")
    if truth := s["truth"]:
        told = [
            f"{word} {value:.3g}{unit}" if isinstance(value, float) else f"{word} {value}"
            for key, word, unit in _TRUTH
            if (value := truth.get(key)) is not None
        ]
        lines += ["", "against the truth: " + ", ".join(told)]
    lines += [f"warning: {warning}" for warning in s["warnings"]]
    if folder is not None:
        lines += ["", f"run: {folder}"]
    return "\n".join(lines)


def _length(found: Mapping[str, Any]) -> str:
    return f"{found.get('length_mm', 0.0):.0f} mm"


def _edge_row(number: int, edge: Mapping[str, Any]) -> dict[str, object]:
    def told(key: str) -> str:
        return "" if edge[key] is None else f"{edge[key]:.2f}"

    return {
        "edge": number,
        "curve": edge["curve"],
        "length_mm": told("length_mm"),
        "radius_mm": told("radius_mm"),
        "dihedral_deg": told("dihedral_deg"),
        "rounding_mm": told("rounding_mm"),
    }
