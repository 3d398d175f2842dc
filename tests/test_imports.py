"""Which module may import which, and what a command that computes nothing must not load."""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import fiv_cli

PACKAGE = Path(fiv_cli.__file__).parent

# From the ground up: a package imports only from lines above its own.
FLOORS = (
    ("__init__", "__version__", "errors"),
    ("models",),
    ("friction",),
    ("codegen",),
    ("dynamics",),
    ("analyses",),
    ("case",),
    ("data",),
    ("sweep", "plots", "verify"),
    ("cli",),
)
FLOOR = {name: height for height, names in enumerate(FLOORS) for name in names}

# What makes a shell wait: half a second and more.
HEAVY = ("numba", "scipy", "sympy", "matplotlib", "netCDF4")


def imported(file: Path) -> Iterator[str]:
    """Packages of fiv_cli that a file imports, wherever in it that stands."""
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        yield from (name.split(".")[1] for name in names if name.startswith("fiv_cli."))


def package_of(file: Path) -> str:
    return file.relative_to(PACKAGE).parts[0].removesuffix(".py")


@pytest.mark.parametrize("file", sorted(PACKAGE.rglob("*.py")), ids=lambda f: f.stem)
def test_dependencies_point_downwards(file: Path) -> None:
    home = package_of(file)
    wrong = {name for name in imported(file) if name != home and FLOOR[name] >= FLOOR[home]}
    assert not wrong


def test_plots_know_nothing_of_models_and_workers() -> None:
    names = {name for file in (PACKAGE / "plots").glob("*.py") for name in imported(file)}
    assert not names & {"models", "dynamics", "analyses", "sweep"}


@pytest.mark.parametrize(
    "arguments",
    [
        ["models"],
        ["new", "belt-1dof", "--analysis", "response"],
        ["schema"],
        ["check", "case.toml"],
        ["status", "case.toml"],
    ],
    ids=lambda arguments: arguments[0],
)
def test_what_computes_nothing_loads_no_engine(arguments: list[str], tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(
        'schema = 1\n[model]\nname = "belt-1dof"\n[grid]\nv = [1.0, 2.0]\n'
        '[[analysis]]\nkind = "response"\n[[analysis]]\nkind = "history"\nt_end = 1.0\n'
    )
    script = (
        "import sys\n"
        "from fiv_cli.cli.main import run\n"
        f"code = run({arguments})\n"
        f"loaded = [name for name in {HEAVY} if name in sys.modules]\n"
        "sys.exit(code or ', '.join(loaded) or 0)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
