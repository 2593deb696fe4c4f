"""What is installed, what is missing, what collides: the answers to most "it does not start" questions."""

from __future__ import annotations

import importlib.util
import os
import platform
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from glob import glob
from importlib.metadata import PackageNotFoundError, packages_distributions, requires, version
from pathlib import Path

OUR_PACKAGES = ("primitives", "models", "exploration", "recognition")
_MARKS = {"ok": "ok  ", "note": "note", "wrong": "!!  "}


@dataclass(frozen=True)
class Finding:
    """One thing looked at; `state` is ok, note (works, with a limit) or wrong."""

    subject: str
    state: str
    text: str


@dataclass(frozen=True)
class Findings:
    """Everything looked at."""

    rows: Sequence[Finding]

    @property
    def healthy(self) -> bool:
        """Whether nothing is wrong."""
        return all(row.state != "wrong" for row in self.rows)

    def as_json(self) -> dict[str, object]:
        """For `--json`."""
        return {"healthy": self.healthy, "findings": [vars(row) for row in self.rows]}

    def as_text(self) -> str:
        """One line each."""
        width = max(len(row.subject) for row in self.rows)
        lines = [f"{_MARKS[row.state]}  {row.subject.ljust(width)}  {row.text}" for row in self.rows]
        return "\n".join([*lines, "" if self.healthy else "\nnot healthy: see the lines marked !!"]).rstrip()


def examine() -> Findings:
    """Look at everything."""
    return Findings(
        [
            _python(),
            *_dependencies(),
            *_collisions(),
            _ray_caster(),
            _step_reader(),
            _step_writer(),
            _kernels(),
            *_serial_ports(),
        ]
    )


def _python() -> Finding:
    here = f"{platform.python_version()} at {sys.executable}, {platform.system()} {platform.machine()}"
    return Finding("python", "ok" if sys.version_info >= (3, 11) else "wrong", here)


def _dependencies() -> list[Finding]:
    try:
        lines = requires("palpate") or []
    except PackageNotFoundError:
        return [Finding("palpate", "wrong", "not installed; make, or pip install . in the checkout")]
    rows = [Finding("palpate", "ok", version("palpate"))]
    for line in lines:
        requirement, _, marker = line.partition(";")
        name = requirement.strip()
        for sign in "<>=!~ [":
            name = name.partition(sign)[0]
        if "extra" in marker or name in ("embreex", "cascadio"):
            continue
        try:
            rows.append(Finding(name, "ok", version(name)))
        except PackageNotFoundError:
            rows.append(Finding(name, "wrong", f"missing; pip install '{requirement.strip()}'"))
    return rows


def _collisions() -> list[Finding]:
    owners = packages_distributions()
    rows = []
    for package in OUR_PACKAGES:
        others = sorted(set(owners.get(package, [])) - {"palpate"})
        spec = importlib.util.find_spec(package)
        place = str(Path(spec.origin).parent) if spec and spec.origin else "nowhere"
        home = str(Path(__file__).parents[1] / package)
        if others:
            text = (
                f"{', '.join(others)} installs a package of this name too; give palpate its own environment"
            )
        elif place != home:
            text = f"imported from {place}, not {home}; give palpate its own environment"
        else:
            rows.append(Finding(package, "ok", place))
            continue
        rows.append(Finding(package, "wrong", text))
    return rows


def _ray_caster() -> Finding:
    if importlib.util.find_spec("embreex") is None:
        return Finding("embreex", "note", "missing: rays go through the slower portable caster")
    return Finding("embreex", "ok", version("embreex"))


def _step_reader() -> Finding:
    if importlib.util.find_spec("cascadio") is None:
        return Finding(
            "cascadio", "note", "missing: STEP files are not read; pip install cascadio, if it has a build"
        )
    return Finding("cascadio", "ok", version("cascadio"))


def _step_writer() -> Finding:
    if importlib.util.find_spec("OCP") is None:
        return Finding(
            "STEP out", "note", "not installed: no model.step is written; pip install 'palpate[step]'"
        )
    return Finding("STEP out", "ok", "model.step is written")


def _kernels() -> Finding:
    root = Path(__file__).parents[1]
    compiled = sum(1 for package in OUR_PACKAGES for _ in (root / package).rglob("__pycache__/*.nbi"))
    if compiled:
        return Finding("numba cache", "ok", f"{compiled} kernels compiled")
    if os.access(root / "exploration", os.W_OK) or os.environ.get("NUMBA_CACHE_DIR"):
        return Finding(
            "numba cache", "note", "empty: the first run compiles; python -m recognition.warm does it"
        )
    return Finding(
        "numba cache", "note", f"{root} cannot be written; set NUMBA_CACHE_DIR to keep what is compiled"
    )


def _serial_ports() -> list[Finding]:
    ports = sorted(
        port for pattern in ("/dev/ttyUSB*", "/dev/ttyACM*", "/dev/cu.usb*") for port in glob(pattern)
    )
    if not ports:
        return [Finding("serial ports", "note", "none found")]
    return [
        Finding(port, "ok", "readable and writable")
        if os.access(port, os.R_OK | os.W_OK)
        else Finding(
            port, "wrong", "no permission; join its group: sudo usermod -aG dialout $USER, then log in again"
        )
        for port in ports
    ]
