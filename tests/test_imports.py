"""Commands that compute nothing do not wait for what computes."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest
from small_cases import BELT
from synthetic_datasets import bifurcation

CASE = BELT + '[[analysis]]\nkind = "history"\nt_end = 1.0\n'

HEAVY = ("numba", "llvmlite", "xarray", "netCDF4", "h5py", "matplotlib", "sympy", "scipy",
         "pydantic", "joblib", "numpy", "rich", "dask", "distributed")  # fmt: skip
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


def test_what_was_compiled_before_is_run_without_a_compiler(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(CASE)
    loaded_by("from fiv_cli.cli.main import run\nrun(['run', 'case.toml', '-q'])", tmp_path)
    arguments = ["run", "case.toml", "-q", "--fresh"]
    assert_loads_none(("numba", "sympy", "joblib", "xarray"), arguments, tmp_path)


def test_what_runs_on_this_machine_loads_no_cluster(tmp_path: Path) -> None:
    (tmp_path / "case.toml").write_text(CASE)
    program = (
        "import contextlib, sys\nfrom fiv_cli.cli.main import main\n"
        "sys.argv[1:] = ['run', 'case.toml', '-q', '--time-limit', '60']\n"
        "with contextlib.suppress(SystemExit):\n    main()\n"
        "sys.modules = {name: module for name, module in sys.modules.items() if module}"
    )
    assert loaded_by(program, tmp_path).isdisjoint(("dask", "distributed"))
    assert (tmp_path / "runs" / "case.nc").is_file()


@pytest.mark.parametrize(
    "arguments", [["--help"], ["--version"], ["run", "--help"], ["verify", "--help"]]
)
def test_help_is_light(arguments: list[str], tmp_path: Path) -> None:
    assert_loads_none(HEAVY, arguments, tmp_path)


def assert_loads_none(names: tuple[str, ...], arguments: list[str], folder: Path) -> None:
    """A command that succeeds and imports none of these packages."""
    program = f"from fiv_cli.cli.main import run\nassert run({arguments}) == 0"
    assert loaded_by(program, folder).isdisjoint(names)


def loaded_by(program: str, folder: Path) -> set[str]:
    """The modules that a program without complaints has imported at its end."""
    script = f"{program}\nimport sys\nprint('\\n', *sys.modules)"
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")
    return set(done.stdout.splitlines()[-1].split())


def test_models_and_laws_are_read_without_sympy(tmp_path: Path) -> None:
    program = (
        "from fiv_cli.friction import all_laws\nfrom fiv_cli.models import all_models\n"
        "all_laws(), all_models()"
    )
    assert loaded_by(program, tmp_path).isdisjoint({"sympy", "numpy"})
