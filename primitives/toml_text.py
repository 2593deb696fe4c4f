"""Values as TOML text: the standard library reads TOML and does not write it."""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def toml_lines(table: Mapping[str, object]) -> list[str]:
    """One `key = value` line per entry; a None is left out, as TOML has none."""
    return [f"{_key(key)} = {_value(value)}" for key, value in table.items() if value is not None]


def _key(key: str) -> str:
    return key if _BARE_KEY.fullmatch(key) else _string(key)


def _string(text: str) -> str:
    return json.dumps(text, ensure_ascii=False).replace("\x7f", "\\u007f")


def _value(value: object) -> str:
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return repr(value)
    if isinstance(value, str | Path):
        return _string(str(value))
    if isinstance(value, Mapping):
        return "{" + ", ".join(toml_lines(value)) + "}"
    if isinstance(value, Sequence):
        return "[" + ", ".join(map(_value, value)) + "]"
    raise TypeError(f"no TOML form for {type(value).__name__}")
