"""A suite file: what is tried with what, as TOML, every key checked.

    name = "noise"
    about = "one sentence"
    [limits]                      # of one trial
    seconds = 120.0
    memory_mb = 4000
    [[trials]]                    # a group; every list is an axis, and the group is the product of its axes
    kind = "explore"
    part = ["block", "@convex"]   # built-in parts, files, *.stl, @convex, @all
    noise = [0.0, 0.05]
    seeds = 3                     # as seed = [0, 1, 2]

The first key turns slowest and the seed fastest, whatever the order of the file; a trial's number is its place.
"""

from __future__ import annotations

import glob
import hashlib
import itertools
import json
import math
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from primitives.errors import PalpateError
from recognition.experiments.kinds import KINDS, Kind
from recognition.experiments.named import require_there
from recognition.experiments.settings import Setting, Value, closest
from recognition.experiments.trial import Row, Trial

_TOP = {"name": "", "about": "", "limits": "", "trials": "", "keep_runs": ""}
_LIMITS = {
    "seconds": Setting(float, 600.0, "a trial that takes longer is ended", 1e-3, 1e8),
    "memory_mb": Setting(float, 4000.0, "a trial that needs more is ended", 1.0, 1e9),
}
_MANY = 1_000_000  # trials; a suite of more is a slip of the pen


@dataclass(frozen=True)
class Limits:
    """Of one trial."""

    seconds: float
    memory_mb: float


@dataclass(frozen=True)
class Group:
    """The trials of one table, and what varies among them."""

    name: str
    kind: Kind
    axes: Mapping[str, tuple[Value, ...]]  # settings with more than one value

    @property
    def conditions(self) -> tuple[str, ...]:
        """The axes that tell trials apart; the part and the seed repeat them."""
        return tuple(axis for axis in self.axes if axis not in ("part", "seed"))

    def unit(self, row: Row) -> Value:
        """What a trial is an instance of: its part where there are several, or itself."""
        return row["part"] if "part" in self.axes else row["trial"]


@dataclass(frozen=True)
class Suite:
    """Everything that is tried."""

    name: str
    about: str
    limits: Limits
    groups: tuple[Group, ...]
    trials: tuple[Trial, ...]
    keep_runs: bool = False
    source: str = field(default="", repr=False)

    @property
    def fingerprint(self) -> str:
        """The same for suites whose trials are."""
        told = [(t.number, t.group, t.kind, dict(t.settings)) for t in self.trials]
        return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()[:16]

    @property
    def columns(self) -> dict[str, type]:
        """Of the table, with their types: what every trial has, settings, metrics; fixed by the suite alone."""
        kinds = list(dict.fromkeys(group.kind.name for group in self.groups))
        out: dict[str, type] = {"trial": int, "group": str, "kind": str}
        for name in kinds:
            out |= {key: setting.type for key, setting in KINDS[name].settings.items()}
        out |= {"outcome": str, "reason": str}
        for name in kinds:
            out |= {key: metric.type for key, metric in KINDS[name].metrics.items()}
        return out | {"trial_seconds": float}


def load_suite(path: Path) -> Suite:
    """A suite from its file."""
    try:
        source = path.read_text(encoding="utf-8")
        told = tomllib.loads(source)
    except OSError as error:
        raise PalpateError(
            f"cannot read suite {path} ({error.strerror or error}); give a TOML file, as docs/suites/smoke.toml"
        ) from error
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise PalpateError(f"suite {path} is not valid TOML: {str(error).splitlines()[0]}") from error
    where = f"suite {path.name}"
    _refuse_unknown(told, _TOP, where)
    name, about, keep = told.get("name", path.stem), told.get("about", ""), told.get("keep_runs", False)
    if not isinstance(name, str) or not isinstance(about, str) or not isinstance(keep, bool):
        raise PalpateError(f"{where}: name and about must be texts, keep_runs true or false")
    if not _is_file_name(name):
        raise PalpateError(
            f"{where}: name must be a plain file name, as {path.stem or 'noise'}, not {name!r}"
        )
    tables = told.get("trials")
    if not isinstance(tables, list) or not tables or not all(isinstance(t, dict) for t in tables):
        raise PalpateError(f"{where} tries nothing; it needs a table [[trials]] with a kind")
    groups, trials, base = list[Group](), list[Trial](), str(path.resolve().parent)
    for number, table in enumerate(tables, 1):
        group, points = _group(table, f"{where}, [[trials]] {number}", Path(base))
        if group.name in {other.name for other in groups}:
            raise PalpateError(f"{where} has two groups {group.name!r}; give each [[trials]] its own name")
        groups.append(group)
        for settings in points:
            trials.append(Trial(len(trials), group.name, group.kind.name, settings, base))
            if len(trials) > _MANY:
                raise PalpateError(f"{where} has more than {_MANY} trials; make its lists shorter")
    limits = _limits(told.get("limits", {}), where)
    return Suite(name, about, limits, tuple(groups), tuple(trials), keep, source)


def _limits(told: object, where: str) -> Limits:
    if not isinstance(told, Mapping):
        raise PalpateError(f"{where}: limits must be a table [limits]")
    _refuse_unknown(told, _LIMITS, f"{where}, [limits]")
    values: Any = {
        key: setting.checked(told.get(key, setting.default), f"{where}, [limits]: {key}")
        for key, setting in _LIMITS.items()
    }
    return Limits(**values)


def _group(table: Mapping[str, Any], where: str, base: Path) -> tuple[Group, Iterator[dict[str, Value]]]:
    told = dict(table)
    kind_name = told.pop("kind", None)
    if not isinstance(kind_name, str) or kind_name not in KINDS:
        what = "no kind" if kind_name is None else f"the unknown kind {kind_name!r}"
        raise PalpateError(f"{where} has {what}; it may be {', '.join(KINDS)}")
    kind = KINDS[kind_name]
    name = told.pop("name", kind.name)
    if not isinstance(name, str) or not name:
        raise PalpateError(f"{where}: name must be a text, not {name!r}")
    told = _with_seeds(told, where)
    _refuse_unknown(told, {"name": "", "kind": "", "seeds": "", **kind.settings}, where)
    order = [
        *(key for key in told if key != "seed"),
        *(key for key in kind.settings if key not in told),
        "seed",
    ]
    axes = {
        key: _values(kind, key, told.get(key, kind.settings[key].default), where, base)
        for key in dict.fromkeys(order)
        if key in kind.settings
    }
    for key, values in axes.items():
        if key in kind.needed and values == ("",):
            raise PalpateError(f"{where}: {kind.name} needs {key!r}, {kind.settings[key].about}")
    count = math.prod(len(values) for values in axes.values())
    if count > _MANY:
        raise PalpateError(f"{where} makes {count} trials, more than {_MANY}; make its lists shorter")
    points = (dict(zip(axes, point, strict=True)) for point in itertools.product(*axes.values()))
    ordered = ({key: point[key] for key in kind.settings} for point in points)
    return Group(name, kind, {key: values for key, values in axes.items() if len(values) > 1}), ordered


def _with_seeds(told: dict[str, Any], where: str) -> dict[str, Any]:
    if "seeds" not in told:
        return told
    count = told.pop("seeds")
    if not isinstance(count, int) or isinstance(count, bool) or count < 1:
        raise PalpateError(f"{where}: seeds must be how many there are, 1 or more, not {count!r}")
    if count > _MANY:
        raise PalpateError(f"{where}: seeds = {count} is more than the {_MANY} trials that a suite may have")
    if "seed" in told:
        raise PalpateError(f"{where} has both seed and seeds; keep one")
    return told | {"seed": list(range(count))}


def _values(kind: Kind, key: str, told: object, where: str, base: Path) -> tuple[Value, ...]:
    setting, place = kind.settings[key], f"{where}: {key}"
    listed = told if isinstance(told, list) else [told]
    if not listed:
        raise PalpateError(f"{place} is an empty list; give it a value, or leave it out")
    values: list[Value] = []
    for value in listed:
        if value is None or (value == "" and key not in kind.needed):
            values.append(setting.default)
        elif value == "":
            values.append("")
        else:
            checked = setting.checked(value, place)
            found = _expanded(checked, place, base) if key == "part" else [checked]
            require_there(key, found, place, base)
            values += found
    return tuple(dict.fromkeys(values))


def _expanded(value: Value, place: str, base: Path) -> list[Value]:
    """The parts behind `@convex`, `@all` or a pattern of files."""
    text = str(value)
    if text.startswith("@"):
        from models import parts

        chosen = {
            "@all": list(parts.names()),
            "@convex": [name for name in parts.names() if parts.describe(name).convex],
        }
        if text not in chosen:
            raise PalpateError(f"{place} is {text!r}; it may be @convex, @all, a built-in part or a file")
        return list[Value](chosen[text])
    if any(mark in text for mark in "*?["):
        found = sorted(n for n in glob.glob(text, root_dir=base, recursive=True) if (base / n).is_file())
        if not found:
            raise PalpateError(f"{place}: no file in {base} is like {text}")
        return list[Value](found)
    return [text]


def _is_file_name(name: str) -> bool:
    """Whether a folder of that name lies where it is made, on any system."""
    return name.isprintable() and name.strip(". ") != "" and not set(name) & set("/\\:") and len(name) < 100


def _refuse_unknown(told: Mapping[str, object], valid: Mapping[str, object], where: str) -> None:
    for key in told:
        if key not in valid:
            raise PalpateError(f"{where}: unknown key {key!r}{closest(key, valid)}")
