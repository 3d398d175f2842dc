"""Whole sweeps of `configs/` through the command, against another version of it.

FIV_BASELINE names the other version's `fiv`. Both run the same case file from nothing stored, on
one worker, their code compiled before; processor times of the whole processes are compared.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.benchmarks.processes import processor_of_children

BASELINE = "FIV_BASELINE"
CONFIGS = Path(__file__).parents[2] / "configs"
CASES = (
    "ch3/fig_3_06", "ch7/fig_7_06_reached", "ch7/fig_7_17", "ch6/fig_6_09",  # motions
    "ch6/fig_6_10", "ch6/fig_6_26",  # followed, and on an elastic disc
    "ch4/fig_4_03", "ch6/fig_6_04", "ch6/fig_6_02", "ch7/fig_7_06_cycles",  # roots and branches
)  # fmt: skip
DONE = (0, 4, 8)  # exit codes of a run that is finished, or stopped where asked (4 in 0.1.0)


def report() -> None:
    """Print how much less processor time each sweep takes than with the other version."""
    other = os.environ.get(BASELINE)
    if other is None:
        print(f"maps: {BASELINE} names no fiv to compare with")
        return
    own = str(Path(sys.executable).with_name("fiv"))
    print("whole sweeps, one worker, processor time")
    for case in CASES:
        before, now = seconds(other, case), seconds(own, case)
        ratio = f"{before:.1f} s before, {now:.1f} s now: {before / now:.2f} times as fast"
        print(f"  {case}: {ratio}", flush=True)


def seconds(command: str, case: str) -> float:
    """Processor time of a run of a case with this `fiv`, s."""
    _run(command, case, "--max-points", "1")  # what is compiled is kept
    begun = processor_of_children()
    _run(command, case)
    return processor_of_children() - begun


def _run(command: str, case: str, *options: str) -> None:
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "case.toml").write_text(computed(f"{case}.toml"))
        given = ["run", "-q", "--workers", "1", *options, "case.toml"]
        done = subprocess.run([command, *given], cwd=folder, stdout=subprocess.DEVNULL)
    assert done.returncode in DONE, f"{command} ends with {done.returncode}"


def computed(case: str) -> str:
    """The text of a case without figures and claims, whose words another version may not know."""
    tables = re.split(r"^(?=\[)", (CONFIGS / case).read_text(), flags=re.MULTILINE)
    return "".join(part for part in tables if not part.startswith(("[[figure]]", "[[claim]]")))
