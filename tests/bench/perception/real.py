"""Rows of real recordings: a Weiss array of six pads closing on a block, a ball and a cylinder.

Used where the data is, never copied: `$PALPATE_DATA`, or `shared` beside the checkout.  A contact frame is one
pad's frame with `FEWEST` taxels or more in contact.  Nobody has marked the lines in them; a block's edge lies
across the pads and a ball has none, so a contact frame of a block that has a line is taken as right, one of a
ball as wrong: precision = block / (block + ball) at equal numbers of contact frames, recall = the share in block
frames.  The block is often felt as a band two taxels wide: `named` rows tell what ours calls it then.

The residual is that of the outline's plateau, in sigmas as the recording's calibration states them and as a share
of the plateau, over frames with a line or an arc.
"""

import os
import sys
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from perception.edges import OURS, Finder
from perception.score import row

from exploration.recordings.open import open_recording
from exploration.sensing.contact_mask import contact_mask
from exploration.sensing.frame import TactileImage
from exploration.sensing.lines.outline import Outline, find_outline
from recognition.frames.felt import Feeler

FEWEST = 4
WITH, WITHOUT = "wooden_block", "golf_ball"


@dataclass
class Count:
    """Contact frames of some recordings, and those with lines by method."""

    frames: int = 0
    lines: dict[str, int] = field(default_factory=dict)
    kinds: dict[str, int] = field(default_factory=dict)
    chi: list[float] = field(default_factory=list)
    share: list[float] = field(default_factory=list)


def data_folder() -> Path:
    """Where outside data would be."""
    beside = Path(__file__).resolve().parents[4] / "shared"
    return Path(os.environ.get("PALPATE_DATA", beside)) / "recordings"


def real_rows(methods: dict[str, Finder]) -> list[dict[str, Any]]:
    """By recording, and block against ball."""
    paths = sorted(data_folder().glob("*.dsa"))
    if not paths:
        print(f"perception: no recordings in {data_folder()}: rows of real frames left out", file=sys.stderr)
        return []
    counts = {path: _counted(path, methods) for path in paths}
    rows = []
    for path, count in counts.items():
        rows.append(row("recording", f"{path.stem}: contact frames", count.frames, "1"))
        if count.frames:
            seen = 100 * count.lines[OURS] / count.frames
            rows.append(row(OURS, f"{path.stem}: contact frames with a line", seen, "%"))
            rows += _residual_rows(path.stem, count)
    objects = {
        name: _together(counts[p] for p in paths if p.stem.startswith(name)) for name in _objects(paths)
    }
    for name, count in objects.items():
        for kind, number in sorted(count.kinds.items(), key=lambda pair: -pair[1]):
            rows.append(row(OURS, f"{name}: named {kind}", 100 * number / max(1, count.frames), "%"))
        rows += _residual_rows(name, count)
        for method, number in count.lines.items():
            share = 100 * number / max(1, count.frames)
            rows.append(row(method, f"{name}: contact frames with a line", share, "%"))
    if WITH in objects and WITHOUT in objects:
        for method in methods:
            found = objects[WITH].lines[method] / max(1, objects[WITH].frames)
            false = objects[WITHOUT].lines[method] / max(1, objects[WITHOUT].frames)
            precision = 100 * found / (found + false) if found + false else 0.0
            rows.append(row(method, "lines, block against ball: precision", precision, "%"))
            rows.append(row(method, "lines, block against ball: recall", 100 * found, "%"))
    return rows


def _objects(paths: list[Path]) -> list[str]:
    return sorted({path.stem.rpartition("-")[0].removesuffix("_flat") for path in paths})


def _counted(path: Path, methods: dict[str, Finder]) -> Count:
    count = Count(lines=dict.fromkeys(methods, 0))
    for felt in Feeler.of(open_recording(path)).feel():
        image = felt.image
        if felt.unreadable or int(contact_mask(image).sum()) < FEWEST:
            continue
        count.frames += 1
        count.kinds[felt.touch.kind] = count.kinds.get(felt.touch.kind, 0) + 1
        for name, find in methods.items():
            count.lines[name] += bool(felt.touch.lines if name == OURS else find(image))
        outline = find_outline(image)
        if outline:
            count.chi.append(float(np.sqrt(outline.chi2 / max(1, outline.dof))))
            count.share.append(count.chi[-1] * _sigma_over_plateau(image, outline))
    return count


def _sigma_over_plateau(image: TactileImage, outline: Outline) -> float:
    living = np.isfinite(image.sigma)
    plateau = max(edge.plateau for edge in (*outline.lines, *outline.arcs))
    return float(np.sqrt(np.mean(np.square(image.sigma[living]))) / max(plateau, 1e-9))


def _residual_rows(name: str, count: Count) -> list[dict[str, Any]]:
    if not count.chi:
        return []
    return [
        row(OURS, f"{name}: residual of the plateau model, median", float(np.median(count.chi)), "sigma"),
        row(OURS, f"{name}: the same of the plateau", 100 * float(np.median(count.share)), "%"),
    ]


def _together(counts: Iterable[Count]) -> Count:
    whole = Count()
    for count in counts:
        whole.frames += count.frames
        whole.chi += count.chi
        whole.share += count.share
        for mine, other in ((whole.lines, count.lines), (whole.kinds, count.kinds)):
            for key, number in other.items():
                mine[key] = mine.get(key, 0) + number
    return whole
