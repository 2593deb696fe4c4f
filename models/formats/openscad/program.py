"""A parsed file run to the flat list of shapes that it draws.

Blocks are read as OpenSCAD reads them: of several assignments of one name the last counts, at the place of the
first; functions and modules hold through the whole block; `$` names pass to what is called.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import openscad_lalr_parser as syntax

from models.formats.openscad.expressions import Evaluator
from models.formats.openscad.folder import Folder
from models.formats.openscad.limits import Budget
from models.formats.openscad.scope import Scope
from models.formats.openscad.shapes import (
    ARGUMENTS,
    CHILDLESS,
    REFUSED,
    REFUSED_ARGUMENTS,
    RENAMED,
    Shape,
)
from models.formats.openscad.syntax import Source
from models.formats.openscad.values import Closure, Value, is_number, true

_SPECIALS: dict[str, Value] = {
    "$fn": 0.0,
    "$fa": 12.0,
    "$fs": 2.0,
    "$t": 0.0,
    "$preview": False,
    "$children": 0.0,
    "$vpt": (0.0, 0.0, 0.0),
    "$vpr": (55.0, 0.0, 25.0),
    "$vpd": 140.0,
    "$vpf": 22.5,
    "$parent_modules": 0.0,
}
_ABSENT = (syntax.ModularModifierBackground, syntax.ModularModifierDisable)
_DECLARATIONS = (syntax.Assignment, syntax.ModuleDeclaration, syntax.FunctionDeclaration)


class Program:
    """Runs one file and what it includes."""

    def __init__(self, budget: Budget, folder: Folder) -> None:
        self.budget = budget
        self.folder = folder
        self.evaluate = Evaluator(budget)
        self.warnings: list[str] = []
        self.labels: dict[tuple[str, tuple[int, int]], str] = {}

    def run(self, source: Source, file: Path) -> list[Shape]:
        """What the file draws."""
        used = Scope(variables=dict(_SPECIALS))
        scope = used.inner()
        return self._block(self._expanded(source, file, (file,), used), scope)

    def _expanded(self, source: Source, file: Path, chain: tuple[Path, ...], used: Scope) -> list[Any]:
        """A file's statements, included files in their places; what it uses is put into that scope."""
        self.labels.update({(source.name, at): words for at, words in source.labels.items()})
        out: list[Any] = []
        for node in source.statements:
            if isinstance(node, syntax.IncludeStatement | syntax.UseStatement):
                self.evaluate.at(node)
                other = self.folder.find(node.filepath.val, file, chain, self.budget)
                included = self.folder.read(other, self.budget)
                if isinstance(node, syntax.IncludeStatement):
                    out += self._expanded(included, other, (*chain, other), used)
                else:
                    around = Scope(variables=dict(_SPECIALS))
                    library = around.inner()
                    self._declare(self._expanded(included, other, (*chain, other), around), library)
                    used.functions.update(library.functions)
                    used.modules.update(library.modules)
            else:
                out.append(node)
        return out

    def _declare(self, statements: list[Any], scope: Scope) -> list[Any]:
        """Take a block's names into its scope; what is left are the statements that draw."""
        last: dict[str, Any] = {}
        drawing = []
        for node in statements:
            match node:
                case syntax.Assignment():
                    last[node.name.name] = node
                case syntax.FunctionDeclaration():
                    scope.functions[node.name.name] = Closure(node.parameters, node.expr, scope)
                case syntax.ModuleDeclaration():
                    scope.modules[node.name.name] = Closure(node.parameters, node.children, scope)
                case _:
                    drawing.append(node)
        for name, node in last.items():
            scope.variables[name] = self.evaluate.value(node.expr, scope)
        return drawing

    def _block(self, statements: list[Any], scope: Scope) -> list[Shape]:
        drawing = self._declare(statements, scope)
        return [shape for node in drawing if (shape := self._shape(node, scope)) is not None]

    def _shape(self, node: Any, scope: Scope) -> Shape | None:
        """What one statement draws; None where it is as if it were not there."""
        self.budget.spend()
        self.evaluate.at(node)
        if isinstance(node, _ABSENT):
            return None
        self.budget.count_solid()
        handler = _STATEMENTS.get(type(node))
        if handler is None:
            raise self.evaluate.error(node, f"no {type(node).__name__} here; check the line")
        shape = handler(self, node, scope)
        if shape is not None:
            where = node.position
            shape.label = self.labels.get((where.origin, (where.line, where.column)), shape.label)
        return shape

    def _highlighted(self, node: Any, scope: Scope) -> Shape | None:
        return self._shape(node.child, scope)

    def _shown_alone(self, node: Any, scope: Scope) -> Shape | None:
        shape = self._shape(node.child, scope)
        if shape is not None:
            shape.root = True
        return shape

    def _group(self, node: Any, children: list[Shape], name: str = "group") -> Shape:
        return Shape(name, f"{node.position.origin}, line {node.position.line}", children=children)

    def _if(self, node: Any, scope: Scope) -> Shape | None:
        if true(self.evaluate.value(node.condition, scope)):
            return self._group(node, self._block(node.true_branch, scope.inner()))
        branch = getattr(node, "false_branch", None)
        return None if branch is None else self._group(node, self._block(branch, scope.inner()))

    def _for(self, node: Any, scope: Scope) -> Shape:
        shapes: list[Shape] = []
        for inner in self.evaluate.loops(node.assignments, scope):
            self.evaluate.at(node)
            turn = self._block(node.body, inner)
            shapes += (
                turn if len(turn) < 2 or isinstance(node, syntax.ModularFor) else [self._group(node, turn)]
            )
        name = "group" if isinstance(node, syntax.ModularFor) else "intersection"
        return self._group(node, shapes, name)

    def _let(self, node: Any, scope: Scope) -> Shape:
        return self._group(node, self._block(node.children, self.evaluate.bind(node.assignments, scope)))

    def _said(self, node: Any, scope: Scope) -> Shape | None:
        """An echo, which is silent here, or an assertion, which is held."""
        if isinstance(node, syntax.ModularAssert):
            self.evaluate.check(node, scope)
        return self._group(node, self._block(node.children, scope.inner())) if node.children else None

    def _call(self, node: Any, scope: Scope) -> Shape | None:
        name = node.name.name
        if (module := scope.module(name)) is not None:
            return self._module(node, module, scope)
        if name == "children":
            return self._children(node, scope)
        if name in REFUSED:
            raise self.evaluate.error(node, f"{name}() is outside the subset that is read; {REFUSED[name]}")
        if name not in ARGUMENTS:
            raise self.evaluate.error(node, f"no module {name}; define it, or check its spelling")
        inner = scope.inner()
        placed, named = self.evaluate.arguments(node.arguments, scope)
        inner.variables.update({k: v for k, v in named.items() if k[0] == "$"})
        named = {RENAMED.get((name, k), k): v for k, v in named.items()}
        arguments = dict(zip(ARGUMENTS[name], placed, strict=False)) | named
        self._look_at(node, name, named)
        shape = self._group(node, [], name)
        shape.arguments = arguments
        shape.facets = tuple(_size(inner.variable(k)[1]) for k in ("$fn", "$fa", "$fs"))  # type: ignore[assignment]
        if node.children and name in CHILDLESS:
            raise self.evaluate.error(node, f"{name} holds nothing; end it with a semicolon")
        shape.children = self._block(node.children, inner)
        return shape

    def _look_at(self, node: Any, name: str, named: dict[str, Value]) -> None:
        """Refuse arguments that would change the shape; warn of others, which OpenSCAD leaves out as well."""
        for argument, value in named.items():
            if argument[0] == "$" or argument in ARGUMENTS[name]:
                continue
            if argument == "start" and (value == 0 or named.get("angle", 360.0) == 360):
                continue  # newer dumps have it, and a whole turn is the same from anywhere
            if cure := REFUSED_ARGUMENTS.get((name, argument)):
                raise self.evaluate.error(node, f"{name} with {argument} is outside the subset; {cure}")
            where = f"{node.position.origin}, line {node.position.line}"
            self.warnings.append(f"{where}: {name} has no argument {argument}; it is left out")

    def _module(self, node: Any, module: Closure, scope: Scope) -> Shape:
        budget = self.budget
        budget.calls += 1
        if budget.calls > budget.limits.calls:
            raise self.evaluate.error(
                node, f"calls go more than {budget.limits.calls} deep; end the recursion"
            )
        inner = self.evaluate.enter(module, node.arguments, scope)
        block = scope.inner()
        inner.children = (self._declare(node.children, block), block)
        inner.variables["$children"] = float(len(inner.children[0]))
        shape = self._group(node, self._block(module.body, inner))
        budget.calls -= 1
        return shape

    def _children(self, node: Any, scope: Scope) -> Shape:
        handed = scope.handed_down()
        placed, named = self.evaluate.arguments(node.arguments, scope)
        statements, block = handed or ([], scope)
        if placed or named:
            chosen = placed[0] if placed else named.get("index")
            numbers = [i for i in self.evaluate.each(chosen, node) if is_number(i)]
            statements = [statements[int(i)] for i in numbers if 0 <= i < len(statements)]
        inside = Scope(block, scope)
        shapes = [self._shape(statement, inside) for statement in statements]
        return self._group(node, [shape for shape in shapes if shape is not None])


def _size(value: Value) -> float:
    return value if is_number(value) else 0.0


_STATEMENTS: dict[type, Callable[[Program, Any, Scope], Shape | None]] = {
    syntax.ModularIf: Program._if,
    syntax.ModularIfElse: Program._if,
    syntax.ModularFor: Program._for,
    syntax.ModularIntersectionFor: Program._for,
    syntax.ModularLet: Program._let,
    syntax.ModularEcho: Program._said,
    syntax.ModularAssert: Program._said,
    syntax.ModularCall: Program._call,
    syntax.ModularModifierHighlight: Program._highlighted,
    syntax.ModularModifierShowOnly: Program._shown_alone,
}
