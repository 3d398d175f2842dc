"""A sweep of a million points within 700 MiB, of ten million within a gibibyte."""

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


TEN_MILLION = """
import resource
import sys
import time
from pathlib import Path
from types import SimpleNamespace
import numpy as np
import sweep_fakes
from fiv_cli.case.identity import document
from fiv_cli.data.block import joined, pack
from fiv_cli.sweep import journal as store
from fiv_cli.sweep.plan import make_plan
from fiv_cli.sweep.queue import Queue
from fiv_cli.sweep.run import assemble_case, count_statuses

AT_ONCE = 10_000
case = sweep_fakes.case(sweep_fakes.MILLION.replace("stop = 1000, num = 1000", "num = 10_000"
    ", stop = 1000", 1))
plan, folder = make_plan(case), Path("a.run")
(analysis,) = plan.analyses

def stored():
    store.create(folder)
    store.write_identity(folder, document(case), case.text)
    journal = store.Journal(folder, plan)
    queue = Queue(analysis, journal.records[0], "")
    variables = analysis.layout.variables
    point = sweep_fakes.cheap(SimpleNamespace(parameters={"Omega": 1.0, "N0": 2.0}))
    alike = pack([point] * AT_ONCE, [bytes(32)] * AT_ONCE, variables)
    while (job := queue.next_job(AT_ONCE)) is not None:
        block = joined([alike], np.arange(len(job.positions)), variables)
        block.values["L_s"] = np.sin(job.positions)
        journal.write(0, job.positions, block)
    return len(list(folder.glob("shards/*.h5")))

def loaded():
    begun = time.process_time()
    journal = store.Journal(folder, plan)
    journal.load()
    assert count_statuses(journal)["ok"] == plan.size == 10_000_000
    assert Queue(analysis, journal.records[0], "").left == 0
    return round(time.process_time() - begun)

def assembled():
    summary, missing = assemble_case(case, Path("a.nc"))
    return len(missing) + summary.counts["pending"]

if __name__ == "__main__":
    print(globals()["%s"](), resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)
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


@pytest.mark.campaign
def test_ten_million_points_fit_into_a_gibibyte(tmp_path: Path) -> None:
    """Stored, loaded, assembled, each in a process of its own: some three minutes."""
    files, kibibytes = run_alone(tmp_path, TEN_MILLION % "stored")
    assert files < 300
    assert kibibytes < 1024 * 1024
    seconds, kibibytes = run_alone(tmp_path, TEN_MILLION % "loaded")
    assert seconds < 10
    assert kibibytes < 1024 * 1024
    missing, kibibytes = run_alone(tmp_path, TEN_MILLION % "assembled")
    assert missing == 0
    assert kibibytes < 1024 * 1024


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
