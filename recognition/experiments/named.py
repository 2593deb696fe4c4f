"""What a suite names must be there before anything is tried: parts, arrays, folders of a library, covers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from primitives.errors import PalpateError
from recognition.experiments.settings import Value
from recognition.experiments.trial import Work


def require_there(key: str, values: Sequence[Value], place: str, base: Path) -> None:
    """Refuse a name that nothing has, and a file that is not there; what a file holds its trial will tell."""
    if key in _REQUIRED:
        for value in values:
            _REQUIRED[key](str(value), place, base)


def _part(text: str, place: str, base: Path) -> None:
    from models import parts
    from models.formats.intake import looks_like_a_file

    if text in parts.names():
        return
    if not looks_like_a_file(text):
        raise PalpateError(f"{place}: {parts.unknown(text)}")
    _file(text, place, base)


def _sensor(text: str, place: str, base: Path) -> None:
    from exploration.sensing.spec import load_sensor

    try:
        load_sensor(Work(base, base).file(text))
    except PalpateError as error:
        raise PalpateError(f"{place}: {error}") from error


def _file(text: str, place: str, base: Path) -> None:
    if not (base / text).is_file():
        raise PalpateError(
            f"{place}: there is no file {text} in {base}; paths are relative to the suite's folder"
        )


def _folder(text: str, place: str, base: Path) -> None:
    if not (base / text).is_dir():
        raise PalpateError(
            f"{place}: there is no folder {text} in {base}; paths are relative to the suite's folder"
        )


_REQUIRED: Mapping[str, Callable[[str, str, Path], None]] = {
    "part": _part,
    "sensor": _sensor,
    "cover": _file,
    "library": _folder,
}
