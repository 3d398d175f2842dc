"""Shards are merged as they age, and nothing of what they hold changes."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import pytest
import sweep_fakes

from fiv_cli.data.netcdf import read_datasets
from fiv_cli.sweep import journal
from fiv_cli.sweep.journal import Journal
from fiv_cli.sweep.plan import make_plan
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import Silent
from fiv_cli.sweep.run import Summary, run_case

HERE = Policy(workers=1, executor="sweep_fakes:answer", preparer="sweep_fakes:prepare")
CASES = {
    "map": (sweep_fakes.BELT, "answer", 1),
    "there and back": (sweep_fakes.LOOP, "answer", 1),
    "refined": (sweep_fakes.REFINED, "region", 40),
}


def sweep(output: Path, text: str, **changes: Any) -> Summary:
    """Run a case from text, a point at a time if nothing else is said."""
    policy = dataclasses.replace(HERE, **{"chunk_points": 1, **changes})
    return run_case(sweep_fakes.case(text), output, policy, Silent())


def stored(output: Path) -> list[Path]:
    """The shards of a run."""
    return sorted((output.with_suffix(".run") / "shards").glob("*.h5"))


def merge_soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four shards are many, whether of a point or of several."""
    monkeypatch.setattr(journal, "MANY", 4)
    monkeypatch.setattr(journal, "AGES", (1200, 6000))


@pytest.fixture
def soon(monkeypatch: pytest.MonkeyPatch) -> None:
    """As above, from the beginning."""
    merge_soon(monkeypatch)


@pytest.mark.parametrize("name", CASES)
def test_merging_leaves_no_trace(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    text, executor, points = CASES[name]
    own = {"executor": f"sweep_fakes:{executor}", "chunk_points": points}
    monkeypatch.setattr(journal, "MANY", 1000)
    summary = sweep(tmp_path / "a.nc", text, **own)
    expected = (tmp_path / "a.nc").read_bytes()
    assert len(stored(tmp_path / "a.nc")) >= 30
    merge_soon(monkeypatch)
    output = tmp_path / "b.nc"
    for most in (5, 9, 10_000):
        sweep(output, text, max_points=most, **own)
    assert output.read_bytes() == expected
    assert len(stored(output)) < len(stored(tmp_path / "a.nc")) / 3
    found = Journal(tmp_path / "b.run", make_plan(sweep_fakes.case(text)))
    found.load()
    assert not found.ignored
    assert sum(len(shard.positions) for shard in found.records[0].shards) == summary.ran


@pytest.mark.usefixtures("soon")
def test_what_is_killed_between_writing_and_removing_is_stored_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep(tmp_path / "a.nc", sweep_fakes.BELT, max_points=3)
    sweep(tmp_path / "a.nc", sweep_fakes.BELT)
    with monkeypatch.context() as killed:
        killed.setattr(Path, "unlink", _nothing)
        sweep(tmp_path / "b.nc", sweep_fakes.BELT)
    assert len(stored(tmp_path / "b.nc")) > 30
    (tmp_path / "b.nc").unlink()
    assert sweep(tmp_path / "b.nc", sweep_fakes.BELT).ran == 0
    assert (tmp_path / "b.nc").read_bytes() == (tmp_path / "a.nc").read_bytes()


def _nothing(path: Path, missing_ok: bool = False) -> None:
    """A process that was killed removes nothing."""


def test_what_is_merged_while_it_is_read_is_found_where_it_went(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As by a live run, beside `fiv status`."""
    sweep(tmp_path / "a.nc", sweep_fakes.BELT, max_points=6)
    first, *others = stored(tmp_path / "a.nc")
    found = Journal(tmp_path / "a.run", make_plan(sweep_fakes.case(sweep_fakes.BELT)))
    read = journal.read_shard

    def read_beside_a_run(path: Path) -> object:
        if path == first:
            for number, other in enumerate(others, 900):
                other.rename(other.with_name(f"{number:06d}.h5"))
        return read(path)

    monkeypatch.setattr(journal, "read_shard", read_beside_a_run)
    found.load()
    assert not found.ignored
    assert sum(len(shard.positions) for shard in found.records[0].shards) == 6


@pytest.mark.usefixtures("soon")
def test_an_answer_outlives_the_failures_before_it(tmp_path: Path) -> None:
    output = tmp_path / "a.nc"
    sweep(output, sweep_fakes.BELT, executor="sweep_fakes:endless", time_limit=0.2)
    assert (read_datasets(output)[""]["status"] == 0).sum() == 28
    longer = sweep_fakes.BELT.replace("stop = 5, num = 5", "stop = 9, num = 9")
    assert sweep(output, longer).complete
    assert sweep(output, sweep_fakes.BELT).ran == 0
    sweep(tmp_path / "b.nc", sweep_fakes.BELT)
    assert output.read_bytes() == (tmp_path / "b.nc").read_bytes()


@pytest.mark.usefixtures("soon")
def test_a_shorter_plan_keeps_what_a_longer_one_has_stored(tmp_path: Path) -> None:
    output = tmp_path / "a.nc"
    sweep(output, sweep_fakes.BELT)
    for text in (
        sweep_fakes.BELT.replace("v = [0.5, 1.0, 2.0]", "v = [2.0, 0.25]"),
        sweep_fakes.BELT.replace("v = [0.5, 1.0, 2.0]", "v = [0.125, 0.0625]"),
    ):
        sweep(output, text)
    assert sweep(output, sweep_fakes.BELT).ran == 0
