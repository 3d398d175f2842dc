"""A sweep of a million points within 700 MiB."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent

PROGRAM = """
import resource
from pathlib import Path
import sweep_fakes
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import Silent
from fiv_cli.sweep.run import run_case

if __name__ == "__main__":
    policy = Policy(executor="sweep_fakes:cheap", preparer="sweep_fakes:prepare")
    summary = run_case(sweep_fakes.case(sweep_fakes.MILLION), Path("a.nc"), policy, Silent())
    print(summary.counts["ok"], resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
"""


REFINED = PROGRAM.replace("sweep_fakes:cheap", "sweep_fakes:region").replace("MILLION", "FINEST")


@pytest.mark.campaign
def test_two_refined_maps_of_a_million_points_fit_into_a_gigabyte(tmp_path: Path) -> None:
    """In the parent: about twenty seconds."""
    points, kibibytes = run_alone(tmp_path, REFINED)
    assert points < 2 * 1025 * 1025 / 20
    assert kibibytes < 1024 * 1024


@pytest.mark.campaign
def test_a_million_points_fit_into_700_mebibytes(tmp_path: Path) -> None:
    """In the parent: a minute or two on two cores."""
    points, kibibytes = run_alone(tmp_path, PROGRAM)
    assert points == 1_000_000
    assert kibibytes < 700 * 1024


def run_alone(tmp_path: Path, program: str) -> tuple[int, int]:
    """Run a program of its own; how many points it computed, and the memory it took."""
    (tmp_path / "program.py").write_text(program)
    done = subprocess.run(
        [sys.executable, "program.py"],
        cwd=tmp_path,
        env={"PYTHONPATH": str(HERE), "PATH": ""},
        check=True,
        capture_output=True,
        text=True,
    )
    points, kibibytes = map(int, done.stdout.split())
    return points, kibibytes
