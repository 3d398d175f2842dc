"""The house: dependencies point downwards, the command line stays light, tables agree."""

from __future__ import annotations

import ast
from pathlib import Path

import pytest
from conftest import KEPT

import fiv_cli
from fiv_cli.codegen.assembly import LIBRARY
from fiv_cli.codegen.codes import (
    CODE_NAMES,
    CODE_SEPARATION,
    CODE_SLIP_MINUS,
    CODE_SLIP_PLUS,
    CODE_STICK,
    SLIP,
    index_of,
)
from fiv_cli.codegen.emit import PARTNER, TaylorStep
from fiv_cli.codegen.graph import UNARY
from fiv_cli.dynamics import kernel, motion

PACKAGE = Path(fiv_cli.__file__).parent
FILES = sorted(PACKAGE.rglob("*.py"))

# A file may import from its own package and from floors below its own.
FLOORS = {
    "__main__": 10,
    "ending": 0,
    "errors": 0,
    "files": 1,
    "flags": 0,
    "fourier": 0,
    "friction": 1,
    "models": 1,
    "notation": 0,
    "plate": 1,
    "schedule": 0,
    "codegen": 2,
    "own": 3,
    "dynamics": 3,
    "analyses": 4,
    "case": 5,
    "data": 5,
    "reading": 5,
    "plots": 6,
    "sweep": 6,
    "api": 7,
    "verify": 8,
    "trial": 8,
    "cli": 9,
}
# Within one floor: laws are parametrised like models; datasets know the case they came from.
NEIGHBOURS = {
    ("friction", "models"),
    ("notation", "errors"),
    ("models", "plate"),
    ("data", "case"),
    ("reading", "data"),
    ("reading", "case"),
    ("trial", "verify"),
}


def part_of(path: Path) -> str:
    """Package or module of fiv_cli that a file belongs to; "" for the root."""
    relative = path.relative_to(PACKAGE)
    return (
        ""
        if relative.name == "__init__.py" and len(relative.parts) == 1
        else (relative.parts[0].removesuffix(".py"))
    )


def imported_modules(path: Path) -> set[str]:
    """What a file imports, wherever in the file, by full name."""
    modules: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            modules |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            modules |= {f"{node.module}.{alias.name}" for alias in node.names}
    return modules


def imported_parts(path: Path) -> set[str]:
    """Parts of fiv_cli that a file imports."""
    own = [name.split(".") for name in imported_modules(path) if name.startswith("fiv_cli.")]
    return {parts[1] for parts in own if parts[1] in FLOORS}


def test_every_part_has_a_floor() -> None:
    assert {part_of(path) for path in FILES} - {""} == set(FLOORS)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_dependencies_point_downwards(path: Path) -> None:
    part = part_of(path)
    for other in imported_parts(path) - {part}:
        assert part != "", f"fiv_cli/__init__.py imports {other}"
        allowed = FLOORS[other] < FLOORS[part] or (part, other) in NEIGHBOURS
        assert allowed, f"{part} imports {other}"


def test_numba_is_asked_by_what_it_offers() -> None:
    modules = {
        f"{node.module}.{alias.name}"
        for path in FILES
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.ImportFrom) and str(node.module).startswith("numba")
        for alias in node.names
    }
    assert {"numba.cfunc", "numba.types", "numba.extending.overload"} <= modules
    assert [name for name in modules if ".core" in name or "._" in name] == []


@pytest.mark.parametrize(
    ("file", "stranger"),
    [("data", "sweep"), ("plots", "models"), ("plots", "analyses"), ("plots", "dynamics"),
     ("sweep", "dynamics"), ("sweep", "codegen"), ("analyses", "sweep")],
)  # fmt: skip
def test_who_knows_nothing_of_whom(file: str, stranger: str) -> None:
    users = [path for path in FILES if part_of(path) == file and stranger in imported_parts(path)]
    assert users == []


def test_the_kernel_is_read_through_motions_systems_and_other_kernels() -> None:
    others = [path for path in FILES if part_of(path) != "dynamics"]
    known = {
        name
        for path in others
        if "@native" not in path.read_text()
        for name in imported_modules(path)
    }
    assert [name for name in known if name.startswith("fiv_cli.dynamics.kernel")] == []


def test_kinds_are_indexed_alike() -> None:
    import numpy as np

    for kinds in ([0], [2], [0, 1], [2, 1, 0], [1, 1, 2]):
        found = kernel.state_index(np.array(kinds, np.int64), len(kinds))
        assert found == index_of(kinds)


def test_codes_have_names() -> None:
    codes = (CODE_SLIP_PLUS, CODE_SLIP_MINUS, CODE_STICK, CODE_SEPARATION)
    assert [CODE_NAMES[code] for code in codes] == ["slip+", "slip-", "stick", "separation"]
    assert [kernel.kind_of(code) for code in codes] == [0, 0, 1, 2]
    for sign, code in ((1.0, CODE_SLIP_PLUS), (-1.0, CODE_SLIP_MINUS)):
        assert kernel.code_of(SLIP, sign) == code


def test_every_stop_has_a_reason_with_advice() -> None:
    from fiv_cli.flags import REASONS

    known = {reason.name for reason in REASONS}
    assert set(motion.STOP_REASONS.values()) <= known
    going_on = {motion.Stop.REACHED, motion.Stop.SECTION_FULL}
    assert set(motion.STOP_REASONS) == set(motion.Stop) - going_on


def test_every_function_of_the_graph_has_a_series_and_machine_code() -> None:
    for op in UNARY:
        assert hasattr(TaylorStep, f"_series_{op}")
        assert op in LIBRARY or op == "sqrt"
    assert set(PARTNER) <= set(UNARY)


def test_the_tests_that_are_kept_in_part_are_there() -> None:
    for file, tests in KEPT.items():
        text = (Path(__file__).parent / file).read_text()
        assert [name for name in tests if f"def {name}(" not in text] == []
