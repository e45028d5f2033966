"""The house rules: layers, lint, types, doctests and the README's promises."""

import ast
import doctest
import importlib
import pkgutil
import subprocess
import sys
from pathlib import Path

import pytest

import crowquill

ROOT = Path(__file__).parent.parent
SOURCE = ROOT / "src" / "crowquill"

# Who may import whom: a module imports from lines above its own, and from no other module of its line.
LAYERS = """
units kernel
knobs processes
paths cluster
heap
levels
expense greys hilbert
halftone exact vector picture lettering marks hatching
regular mending
circles
light footprint delaunay frontier
tone tracing sheet curves
cells glyphs raster forme scale plotforms greydots printable inks
trimming plots strips
moments measure field layout contact grid separation
spectrum quadrature texture likeness inertia tiles
spacing objects parting tesserae
settling shapes refining
relax route
capacity splitting
stippling screening laying inkdots exemplar
aligned contrast nibs mingling reversal
plotting finishing
styles formats
inking
recipe seen calibration
making
judge plate delivery
preflight batch service
figure editor
__init__
options
commands
__main__
"""


def imports(path: Path) -> set[str]:
    """The modules of crowquill that a file imports, by their first name below the package."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] == "crowquill":
            parts = node.module.split(".")[1:]
            found |= {parts[0]} if parts else {alias.name for alias in node.names}
        if isinstance(node, ast.Import):
            found |= {alias.name.split(".")[1] for alias in node.names if alias.name.startswith("crowquill.")}
    return found


def breaches(name: str, wants: set[str], layers: str = LAYERS) -> list[str]:
    """Imports of a module that are not above it."""
    rank = {module: line for line, row in enumerate(layers.split("\n")) for module in row.split()}
    return sorted(other for other in wants - {name} if rank[other] >= rank[name])


@pytest.mark.parametrize("path", sorted(SOURCE.rglob("*.py")), ids=lambda path: str(path.relative_to(SOURCE)))
def test_a_module_imports_only_from_layers_above_its_own(path):
    name = path.relative_to(SOURCE).parts[0].removesuffix(".py")
    assert breaches(name, imports(path)) == []


def test_the_layer_check_sees_an_import_from_below():
    assert breaches("tone", {"paths", "relax"}) == ["relax"]


def test_the_layer_check_sees_an_import_within_a_layer():
    assert breaches("styles", {"formats"}) == ["formats"]


def rooms(table: str, known: set[str]) -> list[str]:
    """The rooms of a table in its order: each line begins with their names, and words follow after two spaces and more."""
    found = []
    for line in table.strip().splitlines():
        for word in line.split():
            if word not in known or word in found:
                break
            found.append(word)
    return found


def test_the_architecture_has_the_rooms_in_the_order_of_their_layers():
    page = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    told = rooms(page.split("```")[1], set(LAYERS.split()))
    assert sorted(told) == sorted(LAYERS.split())
    rank = {module: line for line, row in enumerate(LAYERS.split("\n")) for module in row.split()}
    assert [rank[name] for name in told] == sorted(rank[name] for name in told)


def test_a_room_that_is_missing_is_seen():
    assert rooms("units  kernel   lengths", {"units", "kernel", "paths"}) == ["units", "kernel"]


def run(*command: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("command", [("ruff", "check", "."), ("ruff", "format", "--check", "."), ("mypy",)], ids=" ".join)
def test_lint_and_types_are_clean(command):
    found = run(*command)
    assert found.returncode == 0, found.stdout + found.stderr


MODULES = [module.name for module in pkgutil.walk_packages(crowquill.__path__, "crowquill.")]


@pytest.mark.parametrize("name", [name for name in MODULES if not name.endswith("__main__")])
def test_examples_in_docstrings_are_true(name):
    found = doctest.testmod(importlib.import_module(name))
    assert found.failed == 0


def test_some_docstrings_have_examples():
    tried = sum(doctest.testmod(importlib.import_module(f"crowquill.{name}")).attempted for name in ("units", "paths", "moments"))
    assert tried >= 4


def test_public_names_can_be_imported():
    assert all(getattr(crowquill, name) is not None for name in crowquill.__all__)


def test_a_name_that_is_not_public_is_refused():
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = crowquill.nothing


def test_no_module_is_longer_than_a_chapter():
    lengths = {path.name: len(path.read_text(encoding="utf-8").splitlines()) for path in SOURCE.rglob("*.py")}
    assert {name: length for name, length in lengths.items() if length > 320} == {}
