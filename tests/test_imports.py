"""Commands that compute nothing do not wait for what computes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from small_cases import BELT
from synthetic_datasets import bifurcation

CASE = BELT + '[[analysis]]\nkind = "history"\nt_end = 1.0\n'

# What makes a shell wait: a quarter of a second and more each.
SLOW = ("numba", "scipy", "sympy", "matplotlib", "netCDF4")


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
    (tmp_path / "case.toml").write_text(CASE)
    assert_loads_none(SLOW, arguments, tmp_path)


@pytest.mark.parametrize(
    "arguments",
    [["show", "a.nc"], ["plot", "a.nc", "-o", "a.png"], ["claims", "case.toml"]],
    ids=lambda arguments: arguments[0],
)
def test_what_only_looks_at_results_loads_no_compiler(arguments: list[str], tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(CASE)
    bifurcation().to_netcdf(tmp_path / "a.nc")
    assert_loads_none(("numba",), arguments, tmp_path)


def assert_loads_none(names: tuple[str, ...], arguments: list[str], folder: Path) -> None:
    """A command that succeeds and imports none of these packages."""
    script = (
        "import sys\n"
        "from fiv_cli.cli.main import run\n"
        f"code = run({arguments})\n"
        f"loaded = [name for name in {names} if name in sys.modules]\n"
        "sys.exit(code or ', '.join(loaded) or 0)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], cwd=folder, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
