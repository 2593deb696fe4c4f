"""OpenSCAD text to syntax nodes, with the comment lines that name solids; the only parser import.

The parser is handed text and never a path: its own file door keeps pickled trees on disk.  What it would take
without end is refused first: long files, deep nesting.
"""

from __future__ import annotations

import contextlib
import io
import re
import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from openscad_lalr_parser import parse_ast

from primitives.errors import PalpateError

LARGEST = 2_000_000  # [characters] in one file
DEEPEST = 64  # brackets within one another
_FRAMES = 8000  # Python frames that parsing and evaluating may stack
_TOKEN = re.compile(
    r"(?P<line>//[^\n]*)|(?P<span>/\*[\s\S]*?(?:\*/|\Z))|(?P<string>\"(?:[^\"\\]|\\[\s\S])*+(?:\"|\Z))"
    r"|(?P<open>[\[({])|(?P<close>[\])}])"
)
_WHERE = re.compile(r"at line (\d+), column (\d+)")


@dataclass(frozen=True)
class Source:
    """One parsed file."""

    name: str  # as errors show it
    statements: tuple[object, ...]
    labels: Mapping[tuple[int, int], str]  # line, column -> the one-line comment alone on the line above


def parse(text: str, name: str) -> Source:
    """The statements of a file, or one line that says where it stops making sense."""
    text = text.replace("\r\n", "\n").removeprefix("\N{ZERO WIDTH NO-BREAK SPACE}")
    if len(text) > LARGEST:
        raise PalpateError(f"{name} has more than {LARGEST // 10**6} MB of text; export it as a mesh (STL)")
    labels = _labels(text, name)
    said = io.StringIO()
    try:
        with deep_stack(), contextlib.redirect_stdout(said):
            statements = parse_ast(text, origin=name)
    except Exception as error:  # the parser may raise anything on a broken file, and wraps what it meets
        if isinstance(error, RecursionError) or "recursion depth" in str(error):
            raise PalpateError(f"{name}: an expression is nested too deeply; split it up") from None
        reason = " ".join(str(error).split())[:80] or type(error).__name__
        raise PalpateError(f"cannot read {name} as OpenSCAD ({reason}); export it again") from None
    if statements is None:
        raise PalpateError(_syntax_error(text, name, said.getvalue()))
    return Source(name, tuple(statements), labels)


@contextlib.contextmanager
def deep_stack() -> Iterator[None]:
    """With room for more Python frames than usual, which cost no C stack."""
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(max(before, _FRAMES))
    try:
        yield
    finally:
        sys.setrecursionlimit(before)


def _labels(text: str, name: str) -> dict[tuple[int, int], str]:
    """Names by where the named statement begins; also refuses text whose brackets go too deep."""
    depth, line, seen = 0, 1, 0
    alone: dict[int, str] = {}
    for token in _TOKEN.finditer(text):
        line += text.count("\n", seen, token.start())
        seen = token.start()
        if token["open"]:
            depth += 1
            if depth > DEEPEST:
                raise PalpateError(
                    f"{name}, line {line}: more than {DEEPEST} brackets within one another; nest less"
                )
        elif token["close"]:
            depth -= 1
        elif token["line"] and not text[text.rfind("\n", 0, seen) + 1 : seen].strip():
            alone[line] = " ".join(token["line"][2:].split())
    lines = text.split("\n") if alone else []
    return {
        (at + 1, len(lines[at]) - len(lines[at].lstrip()) + 1): words
        for at, words in alone.items()
        if words and at < len(lines) and not {at - 1, at + 1} & alone.keys()
    }


def _syntax_error(text: str, name: str, said: str) -> str:
    where = _WHERE.search(said)
    if not where:
        return f"cannot read {name} as OpenSCAD; check its syntax"
    line, column = int(where[1]), int(where[2])
    lines = text.split("\n")
    if not 1 <= line <= len(lines):
        return f"{name} ends in the middle of a statement; close its brackets"
    if not "\n".join(lines[line - 1 :])[column:].strip():
        return f"{name}, line {line}: the file ends in the middle of a statement; close its brackets"
    rest = " ".join(lines[line - 1][max(column - 1, 0) :].split())[:24]
    return f"{name}, line {line}: cannot read {rest or 'the line'!r} as OpenSCAD; check the line and the one above"
