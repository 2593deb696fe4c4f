"""The direction of every import: between the packages, between the rooms, and out of the house."""

import ast
import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import networkx
import pytest

ROOT = Path(__file__).parents[1]
MAY_IMPORT = {
    "primitives": set(),
    "models": {"primitives"},
    "exploration": {"primitives"},
    "recognition": {"primitives", "models", "exploration"},
}
ROOMS = ("sensing", "devices", "recordings", "control", "planning")
PLANNING = ("ways", "known", "faces", "open", "touching", "moves", "inferring")
ONE_FILE_ONLY = {
    "embreex": "models/raycast.py",
    "manifold3d": "models/meshing/manifold.py",
    "OCP": "models/formats/step_out_worker.py",
    "cascadio": "models/formats/step_worker.py",
    "mcap": "exploration/recordings/container.py",
    "typer": "recognition/cli.py recognition/commands",  # the command line
    "cv2": "exploration/sensing/baselines/opencv_lines.py",
    "skimage": "exploration/sensing/baselines/skimage_lines.py",
}
DISTRIBUTION_OF = {
    "PIL": "pillow",
    "serial": "pyserial",
    "OCP": "cadquery_ocp_novtk",
    "cv2": "opencv_contrib_python_headless",
    "skimage": "scikit_image",
}
FILES = sorted(path for package in MAY_IMPORT for path in (ROOT / package).rglob("*.py"))
MODULES = {
    ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path for path in FILES
}


def imports_of(module: str) -> Iterator[str]:
    """Every module that `module` names in an import, wherever in the file."""
    path = MODULES[module]
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parents = package.split(".")
                base = ".".join([*parents[: len(parents) - node.level + 1], *filter(None, [node.module])])
            for alias in node.names:
                child = f"{base}.{alias.name}"
                yield child if child in MODULES else base


OURS = {module: sorted({n for n in imports_of(module) if n in MODULES}) for module in MODULES}
OUTSIDE = {
    module: sorted({top for n in imports_of(module) if (top := n.partition(".")[0]) not in MAY_IMPORT})
    for module in MODULES
}


def room_of(module: str) -> int | None:
    parts = module.split(".")
    return ROOMS.index(parts[1]) if parts[0] == "exploration" and len(parts) > 1 else None


def test_every_import_of_ours_exists():
    missing = [
        (module, name)
        for module in MODULES
        for name in imports_of(module)
        if name.partition(".")[0] in MAY_IMPORT and name not in MODULES
    ]
    assert not missing


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_packages_import_only_downward(package):
    upward = [
        (module, name)
        for module, names in OURS.items()
        if module.partition(".")[0] == package
        for name in names
        if name.partition(".")[0] not in MAY_IMPORT[package] | {package}
    ]
    assert not upward


def planning_room_of(module: str) -> int | None:
    """Which room of planning; its conductors stand above all of them."""
    parts = module.split(".")
    if parts[:2] != ["exploration", "planning"] or len(parts) < 3:
        return None
    return PLANNING.index(parts[2]) if parts[2] in PLANNING else len(PLANNING)


def test_every_module_of_exploration_is_in_a_room():
    rooms = {module.split(".")[1] for module in MODULES if module.startswith("exploration.")}
    assert rooms <= set(ROOMS)


def test_rooms_of_exploration_import_only_earlier_rooms():
    upward = [
        (module, name)
        for module, names in OURS.items()
        for name in names
        if (here := room_of(module)) is not None and (there := room_of(name)) is not None and there > here
    ]
    assert not upward


def test_rooms_of_planning_import_only_earlier_rooms():
    upward = [
        (module, name)
        for module, names in OURS.items()
        for name in names
        if (here := planning_room_of(module)) is not None
        and (there := planning_room_of(name)) is not None
        and there > here
    ]
    assert not upward


@pytest.mark.parametrize("package", MAY_IMPORT)
def test_no_circle_of_imports_inside_a_package(package):
    graph = networkx.DiGraph(
        (m, n) for m, names in OURS.items() for n in names if m.partition(".")[0] == package
    )
    assert list(networkx.simple_cycles(graph)) == []


@pytest.mark.parametrize("outside", ONE_FILE_ONLY)
def test_one_place_imports_each_outside_system(outside):
    importers = {
        MODULES[module].relative_to(ROOT).as_posix() for module, names in OUTSIDE.items() if outside in names
    }
    allowed = [ROOT / place for place in ONE_FILE_ONLY[outside].split()]
    elsewhere = [i for i in importers if not any((ROOT / i).is_relative_to(place) for place in allowed)]
    assert not elsewhere


def test_primitives_stand_on_numpy_and_scipy_alone():
    names = {name for m, found in OUTSIDE.items() if m.partition(".")[0] == "primitives" for name in found}
    assert names - set(sys.stdlib_module_names) <= {"numpy", "scipy", "numba"}


def test_every_outside_import_is_declared():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    listed = project["dependencies"] + [
        line for extra in project["optional-dependencies"].values() for line in extra
    ]
    declared = {re.match(r"[\w.-]+", line).group().lower().replace("-", "_") for line in listed}
    used = {name for names in OUTSIDE.values() for name in names} - set(sys.stdlib_module_names)
    assert {DISTRIBUTION_OF.get(name, name) for name in used} <= declared


def test_no_package_marker_below_tests():
    assert list((ROOT / "tests").rglob("__init__.py")) == []
