"""Parts of a plan that run apart are joined to the dataset of one run, to the last bit."""

from __future__ import annotations

import dataclasses
import os
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sweep_fakes
from small_cases import FAR

from fiv_cli.cli.main import run
from fiv_cli.data.netcdf import read_datasets
from fiv_cli.errors import LockedError, StoreMismatchError
from fiv_cli.sweep.journal import Journal
from fiv_cli.sweep.lock import hold
from fiv_cli.sweep.parts import Part, dealt_out
from fiv_cli.sweep.plan import make_plan
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import Silent
from fiv_cli.sweep.queue import spread
from fiv_cli.sweep.run import Summary, assemble_case, run_case

HERE = Policy(workers=1, executor="sweep_fakes:answer", preparer="sweep_fakes:prepare")
CASES = {
    "map": (sweep_fakes.BELT, "sweep_fakes:counted"),
    "chains": (sweep_fakes.CHAIN, "sweep_fakes:counted"),
    "there and back": (sweep_fakes.LOOP, "sweep_fakes:counted"),
    "refined": (sweep_fakes.REFINED, "sweep_fakes:region_counted"),
}


def sweep(output: Path, text: str, part: str = "", **changes: Any) -> Summary:
    """Run a case from text, or a part of it."""
    own = Part(*map(int, part.split("/"))) if part else None
    policy = dataclasses.replace(HERE, part=own, **changes)
    return run_case(sweep_fakes.case(text), output, policy, Silent())


def assembled(output: Path, text: str) -> tuple[Summary, list[str]]:
    """What the parts of a case give."""
    return assemble_case(sweep_fakes.case(text), output)


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("of", [1, 2, 7])
def test_parts_leave_no_trace(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, of: int
) -> None:
    text, executor = CASES[name]
    count_file = tmp_path / "count"
    monkeypatch.setenv("FIV_TEST_COUNT", str(count_file))
    sweep(tmp_path / "a.nc", text, executor=executor)
    ran = Counter(count_file.read_text().splitlines())
    count_file.unlink()
    output = tmp_path / "b.nc"
    sweep(output, text, f"1/{of}", executor=executor, max_points=3)
    for number in range(of, 0, -1):
        assert not output.exists()
        sweep(output, text, f"{number}/{of}", executor=executor, chunk_points=3)
    assert Counter(count_file.read_text().splitlines()) == ran
    summary, missing = assembled(output, text)
    assert (summary.complete, missing) == (True, [])
    assert output.read_bytes() == (tmp_path / "a.nc").read_bytes()
    assert sweep(output, text, executor="sweep_fakes:malformed").ran == 0


def test_what_is_missing_is_said_part_by_part(tmp_path: Path) -> None:
    output = tmp_path / "a.nc"
    sweep(output, sweep_fakes.CHAIN, "1/3")
    sweep(output, sweep_fakes.CHAIN, "3/3", max_points=1)
    summary, missing = assembled(output, sweep_fakes.CHAIN)
    assert summary.counts["pending"] == sum(int(line.split()[2]) for line in missing)
    assert [line.split(":")[0] for line in missing] == ["part 2/3", "part 3/3"]
    assert read_datasets(output)[""].attrs["partial"]
    with hold(tmp_path / "a.run" / "parts" / "3" / "3"):
        assert f"process {os.getpid()} is running it" in assembled(output, sweep_fakes.CHAIN)[1][1]
        with pytest.raises(LockedError, match="part 3/3"):
            sweep(output, sweep_fakes.CHAIN, fresh=True)
        sweep(output, sweep_fakes.CHAIN, "2/3")
    assert sweep(output, sweep_fakes.CHAIN).complete  # the rest, here
    sweep(tmp_path / "b.nc", sweep_fakes.CHAIN)
    assert output.read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_an_answer_outdoes_a_failure_of_another_part(tmp_path: Path) -> None:
    output = tmp_path / "a.nc"
    for number in (1, 2):
        sweep(
            output,
            sweep_fakes.BELT,
            f"{number}/2",
            executor="sweep_fakes:endless",
            time_limit=0.3,
            workers=1,
        )
    assert assembled(output, sweep_fakes.BELT)[0].counts["failed"] == 2
    assert sweep(output, sweep_fakes.BELT).complete
    assert assembled(output, sweep_fakes.BELT)[0].complete
    assert sweep(output, sweep_fakes.BELT, executor="sweep_fakes:malformed").ran == 0


def test_parts_cost_the_same_where_costs_are_known(tmp_path: Path) -> None:
    plan = make_plan(sweep_fakes.case(sweep_fakes.BELT))
    costs = [np.where(np.isin(np.arange(plan.size) % 6, [0, 5]), 100.0, 1.0)]
    (dealt,) = dealt_out(plan, 3, tmp_path, lambda: costs)
    shares = np.bincount(dealt, costs[0])[1:]
    assert shares.max() - shares.min() <= 100.0
    (blind,) = dealt_out(plan, 3, tmp_path / "blind")
    assert np.bincount(blind, costs[0])[1:].max() > 2.0 * shares.max()
    (again,) = dealt_out(plan, 3, tmp_path, lambda: [costs[0][::-1]])  # once dealt, they stay
    assert (again == dealt).all()


def test_what_was_run_tells_what_the_rest_will_cost(tmp_path: Path) -> None:
    output = tmp_path / "a.nc"
    sweep(output, sweep_fakes.BELT, chunk_points=1, max_points=6, executor="sweep_fakes:slow")
    journal = Journal(tmp_path / "a.run", make_plan(sweep_fakes.case(sweep_fakes.BELT)))
    journal.load()
    costs = journal.costs(0)
    was_run = np.isin(np.arange(costs.size), spread(np.arange(costs.size))[:6])
    assert (costs[was_run] == 0.0).all()
    assert (costs[~was_run] > 0.05).all()


def test_a_part_of_another_case_is_refused(tmp_path: Path) -> None:
    output = tmp_path / "a.nc"
    sweep(output, sweep_fakes.BELT, "1/2")
    other = sweep_fakes.BELT.replace('kind = "response"', 'kind = "response"\nt_max = 7.0')
    with pytest.raises(StoreMismatchError):
        sweep(output, other, "1/2")


def test_the_commands(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    case = tmp_path / "case.toml"
    case.write_text(FAR.format(v=2, N=3, transient=100.0, t_max=200.0))
    one, joined = str(tmp_path / "one.nc"), str(tmp_path / "joined.nc")
    assert run(["run", str(case), "-o", one, "--workers", "1"]) == 0
    own = [str(case), "-o", joined]
    assert run(["run", *own, "--shard", "2/2", "--workers", "1"]) == 0
    assert run(["show", joined]) == 2
    assert "joined.nc: not written; its points are run in parts" in capfd.readouterr().err
    assert run(["assemble", *own]) == 8
    assert "part 1/2: 3 points to run; --shard 1/2 runs them" in capfd.readouterr().err
    assert run(["status", *own, "--exit-code"]) == 8
    assert run(["run", *own, "--shard", "1/2", "--workers", "1"]) == 0
    assert run(["assemble", *own]) == 0
    assert Path(joined).read_bytes() == Path(one).read_bytes()
    for wrong in ("0/2", "3/2", "1", "a/b", "1/100000"):
        assert run(["run", *own, "--shard", wrong]) == 2
        assert "I/N" in capfd.readouterr().err
