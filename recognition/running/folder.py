"""A run on disk: one folder, every file written whole or not at all, `summary.json` last.

A file is written under a temporary name and renamed when it is whole, so a kill or a full disk never leaves
a half-written result under its own name; a folder without `summary.json` is a run that did not end.  The
recording alone is written in place: it reads up to its last whole chunk whenever it stops.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from primitives.arrays import Ints
from primitives.errors import NotWritten, PalpateError
from primitives.evidence import Contacts
from recognition.console.bugs import BUG

RECORDING = "episode.mcap"
SUMMARY = "summary.json"
RESULTS = (
    "contacts.csv", "brep.json", "model.csg", "model.stl", "model.glb", "model.step", "report.html", "config.toml",
    BUG,
)  # fmt: skip
_FILES = {SUMMARY, RECORDING, *RESULTS}
_MARKS = (SUMMARY, RECORDING, "config.toml")  # any of these makes a folder a run
_PARTIAL = ".partial"


@dataclass(frozen=True)
class RunFolder:
    """Where one run goes."""

    path: Path

    @staticmethod
    def create(out: Path | None, name: str, overwrite: bool = False) -> RunFolder:
        """A folder that is new or empty, or held a run and may be overwritten.

        Without `out` it is the first free one of runs/NAME, runs/NAME-2, ...
        """
        path = out if out is not None else _first_free(Path("runs"), name)
        try:
            path.mkdir(parents=True, exist_ok=True)
            present = {entry.name for entry in path.iterdir()}
            if present:
                _refuse_unless_run(path, present, overwrite)
                for old in sorted(present, key=lambda entry: entry != SUMMARY):
                    (path / old).unlink()
        except FileExistsError as error:
            raise PalpateError(f"--out {path} is a file; give a folder") from error
        except OSError as error:
            reason = error.strerror or str(error)
            raise NotWritten(f"cannot write to --out {path} ({reason}); choose another folder") from error
        return RunFolder(path)

    @property
    def recording(self) -> Path:
        """Where the episode is recorded."""
        return self.path / RECORDING

    @contextmanager
    def writing(self, name: str) -> Iterator[Path]:
        """A temporary path with the suffix of `name`, renamed to it once the block ends without error."""
        final = self.path / name
        temporary = final.with_name(f"{final.stem}{_PARTIAL}{final.suffix}")
        try:
            yield temporary
            with temporary.open("rb+") as file:
                os.fsync(file.fileno())
            temporary.replace(final)
        except OSError as error:
            raise NotWritten(
                f"cannot write {final} ({error.strerror or error}); choose another folder"
            ) from error
        finally:
            with suppress(OSError):
                temporary.unlink(missing_ok=True)

    def write_text(self, name: str, text: str) -> None:
        """Write one file of text."""
        with self.writing(name) as path:
            path.write_text(text, encoding="utf-8", newline="\n")

    def write_json(self, name: str, value: Mapping[str, object]) -> None:
        """Write one JSON object; what is not finite becomes null."""
        self.write_text(name, json_text(value, indent=1) + "\n")

    def write_contacts(self, contacts: Contacts, faces: Ints) -> None:
        """`contacts.csv`: a normal that was not felt is left empty, a face not known is -1."""
        lines = ["x,y,z,nx,ny,nz,sigma,face"]
        for point, normal, sigma, face in zip(
            contacts.points.tolist(), contacts.normals.tolist(), contacts.sigma.tolist(), faces, strict=True
        ):
            felt = ["" if math.isnan(n) else f"{n:.7f}" for n in normal]
            lines.append(",".join([*(f"{x:.5f}" for x in point), *felt, f"{sigma:.5g}", str(int(face))]))
        self.write_text("contacts.csv", "\n".join(lines) + "\n")

    def finish(self, summary: Mapping[str, object]) -> None:
        """Write the summary, which makes the run whole."""
        self.write_json(SUMMARY, summary)


def json_text(value: object, indent: int | None = None) -> str:
    """Strict JSON of plain values and arrays; nan and infinities, which JSON lacks, become null."""
    return json.dumps(_plain(value), indent=indent, allow_nan=False, ensure_ascii=False)


def _plain(value: object) -> object:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, Mapping):
        return {str(key): _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return str(value) if isinstance(value, Path) else value


def _first_free(parent: Path, name: str) -> Path:
    candidate, number = parent / name, 1
    while candidate.exists():
        number += 1
        candidate = parent / f"{name}-{number}"
    return candidate


def _refuse_unless_run(path: Path, present: set[str], overwrite: bool) -> None:
    own = {n for n in present if n in _FILES or (_PARTIAL in n and n.replace(_PARTIAL, "") in _FILES)}
    if strangers := sorted(present - own):
        raise PalpateError(
            f"--out {path} holds {strangers[0]}, which is no part of a run; give a new or empty folder"
        )
    if not any(mark in present for mark in _MARKS):
        raise PalpateError(f"--out {path} is not empty and holds no run; give a new or empty folder")
    if not overwrite:
        raise PalpateError(f"--out {path} already holds a run; add --overwrite to replace it")
