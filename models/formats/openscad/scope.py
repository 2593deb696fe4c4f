"""Which name means what: lexical scopes, and `$` variables that pass from caller to called."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from models.formats.openscad.values import Closure, Value

_MISSING = object()


@dataclass(eq=False)
class Scope:
    """One block's names; `outer` is where it is written, `caller` where it is used from."""

    outer: Scope | None = None
    caller: Scope | None = None
    variables: dict[str, Value] = field(default_factory=dict)
    functions: dict[str, Closure] = field(default_factory=dict)
    modules: dict[str, Closure] = field(default_factory=dict)
    children: tuple[list[Any], Scope] | None = None  # of a module call: statements, and where they stand

    def inner(self) -> Scope:
        """A block within this one."""
        return Scope(self, self)

    def variable(self, name: str) -> tuple[bool, Value]:
        """Whether the name is known, and what it stands for."""
        scope: Scope | None = self
        while scope is not None:
            found = scope.variables.get(name, _MISSING)
            if found is not _MISSING:
                return True, found
            scope = scope.caller if name[0] == "$" else scope.outer
        return False, None

    def function(self, name: str) -> Closure | None:
        """The function of that name."""
        return self._written(lambda scope: scope.functions.get(name))

    def module(self, name: str) -> Closure | None:
        """The module of that name."""
        return self._written(lambda scope: scope.modules.get(name))

    def handed_down(self) -> tuple[list[Any], Scope] | None:
        """What `children()` stands for here."""
        scope: Scope | None = self
        while scope is not None:
            if scope.children is not None:
                return scope.children
            scope = scope.outer
        return None

    def _written(self, find: Callable[[Scope], Closure | None]) -> Closure | None:
        scope: Scope | None = self
        while scope is not None:
            if (found := find(scope)) is not None:
                return found
            scope = scope.outer
        return None
