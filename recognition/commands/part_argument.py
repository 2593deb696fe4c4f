"""The PART that a command is given: looked at early, and what there is listed where it is unknown."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from primitives.errors import PalpateError
from recognition.commands.answering import one_line_errors


def look_at_file(part: str) -> None:
    """Say what is wrong with a file at a glance, which takes no second of imports."""
    from models.formats.intake import glance, looks_like_a_file

    if looks_like_a_file(part):
        glance(Path(part))


@contextmanager
def listing_parts_if_unknown(part: str, command: str = "explore") -> Iterator[None]:
    """After the line that says what was wrong with a part that is not there, list what there is."""
    with one_line_errors():
        try:
            if not part:
                raise PalpateError(f"{command} needs a part: a built-in name, or a CAD file")
            yield
        except PalpateError as error:
            if Path(part).suffix or (part and Path(part).exists()):
                raise
            from models.parts import names
            from recognition.builtin import part_rows
            from recognition.report.terminal import table_text

            if part in names():
                raise
            raise PalpateError(f"{error}\n\n{table_text(part_rows())}") from None
