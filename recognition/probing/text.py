"""A probe as a terminal shows it once it has ended."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from exploration.control.procedures.catalog import CANNOT
from primitives.errors import PalpateError
from recognition.probing.options import ProbeOptions, procedure_rows
from recognition.report.terminal import table_text


def requested(options: ProbeOptions) -> None:
    """Refuse a procedure that is not there, with the list; one that cannot be, with the reason."""
    try:
        options.known()
    except PalpateError as error:
        if options.procedure in CANNOT:
            raise
        raise PalpateError(f"{error}\n\n{table_text(procedure_rows())}") from None


def summary_text(summary: Mapping[str, Any], folder: Path | None = None) -> str:
    """What was felt, what is true, where the run lies."""
    s = summary
    lines = [
        f"{s['part']}: {s['procedure']} ({s['property']}), {s['device_seconds']:.1f} s on the device, "
        f"{s['frames']} frames"
    ]
    lines += _told(s["found"])
    if s["truth"]:
        lines += ["against the truth:", *_told(s["truth"])]
    lines += [f"warning: {warning}" for warning in s["warnings"]]
    return "\n".join([*lines, *([f"run: {folder}"] if folder else [])])


def _told(values: Mapping[str, Any]) -> list[str]:
    return [
        f"  {name.ljust(24)}{_word(value)}"
        for name, value in values.items()
        if not isinstance(value, Mapping)
    ]


def _word(value: Any) -> str:
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, Sequence) and not isinstance(value, str):
        flat = [v for v in value if isinstance(v, int | float)]
        return ", ".join(map(_word, flat)) if len(flat) == len(value) else f"{len(value)}"
    if isinstance(value, float):
        return f"{value:.4g}"
    return "unknown" if value is None else str(value)
