"""A run is the same to the last bit however it is cut, interrupted, resumed or extended."""

from __future__ import annotations

import dataclasses
import errno
import json
import os
import shlex
import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sweep_fakes

from fiv_cli import ending, files
from fiv_cli.data.course import Course
from fiv_cli.data.hdf5 import read_attributes
from fiv_cli.data.log import runs_in
from fiv_cli.data.netcdf import read_datasets
from fiv_cli.errors import LockedError, StorageError, StoreMismatchError, UsageError
from fiv_cli.sweep import journal, pool
from fiv_cli.sweep import progress as progress_of
from fiv_cli.sweep.lock import hold, holder
from fiv_cli.sweep.plan import make_plan
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import Lines, Silent
from fiv_cli.sweep.queue import spread
from fiv_cli.sweep.run import Summary, reproduction, run_case
from fiv_cli.sweep.scheduler import LARGEST_CHUNK, Pace
from fiv_cli.sweep.worker import Result, Task, run_task

HERE = Policy(workers=1, executor="sweep_fakes:answer", preparer="sweep_fakes:prepare")


def policy(**changes: Any) -> Policy:
    """The policy of the tests: in this process, with the stand-in physics."""
    return dataclasses.replace(HERE, **changes)


def sweep(output: Path, text: str = sweep_fakes.BELT, **changes: Any) -> Summary:
    """Run a case from text."""
    return run_case(sweep_fakes.case(text), output, policy(**changes), Silent())


@pytest.fixture
def count_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """File in which the executor `counted` writes its runs."""
    path = tmp_path / "count"
    monkeypatch.setenv("FIV_TEST_COUNT", str(path))
    return path


def runs(count_file: Path) -> list[str]:
    """What the executor `counted` was asked to run."""
    return count_file.read_text().splitlines() if count_file.exists() else []


@pytest.mark.parametrize("text", [sweep_fakes.BELT, sweep_fakes.CHAIN, sweep_fakes.LOOP])
def test_workers_and_chunks_leave_no_trace(tmp_path: Path, text: str) -> None:
    sweep(tmp_path / "a.nc", text)
    expected = (tmp_path / "a.nc").read_bytes()
    for name, changes in {
        "one": {"chunk_points": 1},
        "three": {"chunk_points": 3},
        "all": {"chunk_points": 1000},
        "workers": {"workers": 2, "in_process_below": 0.0, "chunk_points": 4},
    }.items():
        sweep(tmp_path / f"{name}.nc", text, **changes)
        assert (tmp_path / f"{name}.nc").read_bytes() == expected, name


@pytest.mark.parametrize("text", [sweep_fakes.BELT, sweep_fakes.CHAIN, sweep_fakes.LOOP])
@pytest.mark.parametrize("first", [1, 7, 20])
def test_a_run_in_two_goes_is_the_run_in_one(tmp_path: Path, text: str, first: int) -> None:
    sweep(tmp_path / "a.nc", text)
    partial = sweep(tmp_path / "b.nc", text, max_points=first, chunk_points=3)
    assert partial.ran == first
    assert not partial.complete
    rest = sweep(tmp_path / "b.nc", text)
    assert rest.ran == sum(rest.counts.values()) - first
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_a_deleted_dataset_comes_back_without_a_run(tmp_path: Path) -> None:
    output = tmp_path / "a.nc"
    sweep(output)
    before = output.read_bytes()
    output.unlink()
    assert sweep(output).ran == 0
    assert output.read_bytes() == before


def test_a_dataset_that_is_there_is_not_made_again(tmp_path: Path) -> None:
    output = tmp_path / "a.nc"
    sweep(output)
    content, written = output.read_bytes(), output.stat().st_ino
    assert sweep(output).ran == 0
    assert output.stat().st_ino == written
    output.write_bytes(content + b"\0")
    sweep(output)
    assert output.read_bytes() == content


def test_a_dataset_of_other_words_or_points_is_made_again(tmp_path: Path) -> None:
    output = tmp_path / "a.nc"
    sweep(output, max_points=7)
    assert (read_datasets(output)[""]["status"] == 0).sum() == 7
    sweep(output)
    assert (read_datasets(output)[""]["status"] == 0).all()
    sweep(output, sweep_fakes.BELT.replace("fake sweep", "a better title"))
    assert read_datasets(output)[""].attrs["title"] == "a better title"


def test_points_land_where_their_coordinates_say(tmp_path: Path) -> None:
    sweep(tmp_path / "a.nc")
    dataset = read_datasets(tmp_path / "a.nc")[""]
    assert dataset["L_s"].dims == ("N", "v", "initial")
    point = dataset.sel(N=3.0, v=2.0, initial="far")
    x = np.sin(3.0 * 1.7 + 2.0) + 0.3 * 2.0
    assert float(point["L_s"]) == pytest.approx(x * x, rel=1e-15)
    rows = dataset["section_row_size"].values.ravel()
    position = np.ravel_multi_index((2, 2, 1), (5, 3, 2))
    begin = rows[:position].sum()
    values = dataset["section_value"].values[begin : begin + rows[position]]
    assert values == pytest.approx(np.sin(np.arange(3) + x), rel=1e-15)
    assert np.isnan(dataset["floquet_multiplier"].sel(N=2.0).values[..., 1]).all()


def test_a_longer_axis_runs_its_new_points_only(tmp_path: Path, count_file: Path) -> None:
    longer = sweep_fakes.BELT.replace("stop = 5, num = 5", "stop = 7, num = 7")
    sweep(tmp_path / "a.nc", executor="sweep_fakes:counted")
    count_file.unlink()
    sweep(tmp_path / "a.nc", longer, executor="sweep_fakes:counted")
    assert sorted({float(line.split()[0]) for line in runs(count_file)}) == [6.0, 7.0]
    assert len(runs(count_file)) == 2 * 3 * 2
    sweep(tmp_path / "b.nc", longer)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_an_analysis_may_be_added_and_is_all_that_runs(tmp_path: Path, count_file: Path) -> None:
    """Also where the dataset, or what is beside it, was lost since; none may be taken away."""
    both = sweep_fakes.BELT + '[[analysis]]\nkind = "response"\nname = "longer"\nt_max = 10\n'
    sweep(tmp_path / "b.nc", both)
    for lost in ("nothing", "a.nc", "a.run/identity.json"):
        sweep(tmp_path / "a.nc", fresh=True)
        (tmp_path / lost).unlink(missing_ok=True)
        count_file.unlink(missing_ok=True)
        sweep(tmp_path / "a.nc", both, executor="sweep_fakes:counted")
        assert len(runs(count_file)) == 30
        assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()
    with pytest.raises(StoreMismatchError, match=r"analyses\.longer: stored, now absent"):
        sweep(tmp_path / "a.nc")


def test_a_start_may_be_added_and_is_all_that_runs(tmp_path: Path, count_file: Path) -> None:
    """Of random ones also more of them; none may be taken away, or changed."""
    random = '[[initial]]\nlabel = "any"\nkind = "random"\ncount = 2\nbox = { x = [0, 1] }\n'
    first, _ = sweep_fakes.BELT.split('[[initial]]\nlabel = "far"')
    first += '[[analysis]]\nkind = "response"\n'
    stages = [first, sweep_fakes.BELT, sweep_fakes.BELT + random]
    stages.append(stages[-1].replace("count = 2", "count = 5"))
    for text, new in zip(stages, (15, 15, 30, 45), strict=True):
        count_file.unlink(missing_ok=True)
        sweep(tmp_path / "a.nc", text, executor="sweep_fakes:counted")
        assert len(runs(count_file)) == new
    sweep(tmp_path / "b.nc", stages[-1])
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()
    for text, told in (
        (first, r"starts\.any: stored, now absent\n  starts\.far: stored, now absent\n"),
        (
            stages[-1].replace("1e-4", "2e-4"),
            r"starts\.near\.offset\.x: stored 0\.0001, now 0\.0002",
        ),
    ):
        with pytest.raises(StoreMismatchError, match=told):
            sweep(tmp_path / "a.nc", text)


def test_a_chain_goes_on_at_its_far_end(tmp_path: Path, count_file: Path) -> None:
    shorter = sweep_fakes.CHAIN.replace("stop = 8, num = 8", "stop = 5, num = 5")
    sweep(tmp_path / "a.nc", shorter, executor="sweep_fakes:counted")
    count_file.unlink()
    sweep(tmp_path / "a.nc", sweep_fakes.CHAIN, executor="sweep_fakes:counted")
    ran = {float(line.split()[0]) for line in runs(count_file)}
    assert {N for N in ran if N.is_integer()} == {6.0, 7.0, 8.0}
    assert all(6.0 < N < 7.0 for N in ran if not N.is_integer())  # the way on which it is lost
    sweep(tmp_path / "b.nc", sweep_fakes.CHAIN)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_a_chain_carries_and_stops_where_its_class_changes(tmp_path: Path) -> None:
    sweep(tmp_path / "a.nc", sweep_fakes.CHAIN)
    up = read_datasets(tmp_path / "a.nc")[""].sel(initial="up", v=1.0)
    assert up["status"].values.tolist() == [0, 0, 0, 0, 0, 0, 0, 4]
    assert up["attractor"].values.tolist() == [1, 1, 1, 1, 1, 1, 3, -1]
    x = np.sin(1.7 + 1.0) + 0.3
    for i, N in enumerate(up["N"].values):
        if i:
            x = np.sin(N * 1.7 + 1.0) + 0.1 * x
        if i < 7:
            assert float(up["L_s"][i]) == pytest.approx(x * x, rel=1e-14)


@pytest.mark.parametrize("on_loss", ["stop", "go-on"])
@pytest.mark.parametrize(("end", "last"), [(6.4, 6.0), (5.999, 5.0), (20.0, 8.0)])
def test_a_chain_is_lost_where_its_branch_ends_and_not_by_its_steps(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, end: float, last: float, on_loss: str
) -> None:
    """Steps of 1 throw the motion off everywhere; steps of 0.3 do nowhere before the end."""
    monkeypatch.setenv("FIV_TEST_END", f"{end}")
    text = sweep_fakes.CHAIN.replace('from = "far"', f'from = "far"\non_loss = "{on_loss}"')
    sweep(tmp_path / "a.nc", text, executor="sweep_fakes:slippery")
    up = read_datasets(tmp_path / "a.nc")[""].sel(initial="up")
    on_it = (up["attractor"] == 1).sum("N").values.tolist()
    assert on_it == [last, last]
    assert up["attractor"].sel(N=slice(last + 1, None)).isin([0, -1]).all()
    sweep(tmp_path / "b.nc", text, executor="sweep_fakes:slippery", max_points=11)
    sweep(tmp_path / "b.nc", text, executor="sweep_fakes:slippery")
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_a_chain_in_the_steps_of_the_grid_begins_where_the_point_before_ended(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An ordinary sweep: what a step of the grid throws off its branch is lost."""
    monkeypatch.setenv("FIV_TEST_END", "20.0")
    text = sweep_fakes.CHAIN.replace(
        'from = "far"', 'from = "far"\nsteps = "grid"\non_loss = "go-on"'
    )
    sweep(tmp_path / "a.nc", text, executor="sweep_fakes:slippery")
    up = read_datasets(tmp_path / "a.nc")[""].sel(initial="up", v=1.0)
    assert up["attractor"].values.tolist() == [1] + [0] * 7


def test_a_chain_that_is_lost_where_it_turns_is_lost(tmp_path: Path) -> None:
    """There is no way from the point before that could be gone in shorter steps."""
    text = sweep_fakes.LOOP.replace('on_loss = "go-on"', 'on_loss = "stop"')
    sweep(tmp_path / "a.nc", text, executor="sweep_fakes:turning")
    down = read_datasets(tmp_path / "a.nc")[""].sel(initial="down", v=1.0)
    assert down["attractor"].values.tolist() == [-1] * 7 + [0]


def test_a_chain_may_start_again_where_it_was_lost(tmp_path: Path) -> None:
    text = sweep_fakes.CHAIN.replace('from = "far"', 'from = "far"\non_loss = "restart"')
    sweep(tmp_path / "a.nc", text)
    dataset = read_datasets(tmp_path / "a.nc")[""]
    assert (dataset["status"] == 0).all()
    last = dataset["L_s"].sel(N=8.0)
    assert (last.sel(initial="up") == last.sel(initial="far")).all()


def test_a_chain_may_go_on_whatever_its_class(tmp_path: Path) -> None:
    text = sweep_fakes.CHAIN.replace('from = "far"', 'from = "far"\non_loss = "go-on"')
    sweep(tmp_path / "a.nc", text)
    up = read_datasets(tmp_path / "a.nc")[""].sel(initial="up", v=1.0)
    assert up["attractor"].values.tolist() == [1, 1, 1, 1, 1, 1, 3, 3]
    before = float(np.sqrt(up["L_s"][6])) * np.sign(np.sin(7 * 1.7 + 1.0))
    assert float(up["L_s"][7]) == pytest.approx((np.sin(8 * 1.7 + 1.0) + 0.1 * before) ** 2)
    for more in ({"max_points": 13}, {}):
        sweep(tmp_path / "cut.nc", text, **more)
    assert (tmp_path / "cut.nc").read_bytes() == (tmp_path / "a.nc").read_bytes()
    sweep(tmp_path / "ended.nc", text, executor="sweep_fakes:ended")
    up = read_datasets(tmp_path / "ended.nc")[""].sel(initial="up", v=1.0)
    assert up["status"].values.tolist() == [0, 0, 0, 0, 4, 4, 4, 4]


def test_a_chain_may_begin_where_another_ended(tmp_path: Path, count_file: Path) -> None:
    """Up, and down again; of a chain that grew at its far end the way back is another."""
    shorter = sweep_fakes.LOOP.replace("stop = 8, num = 8", "stop = 5, num = 5")
    sweep(tmp_path / "a.nc", shorter)
    sweep(tmp_path / "a.nc", sweep_fakes.LOOP, executor="sweep_fakes:counted")
    of_the_grid = [run for run in runs(count_file) if float(run.split()[0]).is_integer()]
    assert len(of_the_grid) == 2 * (3 + 3 + 8)  # far, up and down, at two speeds
    loop = read_datasets(tmp_path / "a.nc")[""].sel(v=1.0, initial=["up", "down"])["L_s"]
    expected, x = [], 3.0
    for N in [*range(1, 9), *range(8, 0, -1)]:
        x = np.sin(N * 1.7 + 1.0) + 0.1 * x
        expected.append(x * x)
    found = [*loop.sel(initial="up"), *loop.sel(initial="down")[::-1]]
    np.testing.assert_allclose(found, expected, rtol=1e-14)


def test_a_chain_goes_back_from_where_the_one_before_was_lost_or_restarts(tmp_path: Path) -> None:
    for on_loss, reached in {"stop": 6, "go-on": 6, "restart": 8}.items():
        up, down = (f'on_loss = "{word}"' for word in ("stop", on_loss))
        first, second, third = sweep_fakes.LOOP.split('on_loss = "go-on"')
        text, output = first + up + second + down + third, tmp_path / f"{on_loss}.nc"
        for most in (9, None):  # up to where it turns, and from there
            sweep(output, text, chunk_points=1, max_points=most)
        found = read_datasets(output)[""].sel(v=1.0)
        is_told = found["status"].sel(initial="down") == 0
        assert is_told.values.tolist() == [True] * reached + [False] * (8 - reached)
        assert int((found["status"].sel(initial="up") == 0).sum()) == 7  # the last of another class
        sweep(tmp_path / "whole.nc", text, fresh=True)
        assert output.read_bytes() == (tmp_path / "whole.nc").read_bytes()


@pytest.mark.parametrize("on_loss", ["stop", "restart"])
def test_a_chain_goes_through_points_that_could_not_be_told(tmp_path: Path, on_loss: str) -> None:
    """It hands on their states, and ends where the class changes from what was told before."""
    text = sweep_fakes.CHAIN.replace('from = "far"', f'from = "far"\non_loss = "{on_loss}"')
    sweep(tmp_path / "a.nc", text, executor="sweep_fakes:hazy")
    sweep(tmp_path / "told.nc", text)
    hazy, told = (read_datasets(tmp_path / name)[""] for name in ("a.nc", "told.nc"))
    up = hazy.sel(initial="up", v=1.0)
    last = 4 if on_loss == "stop" else 0
    assert up["status"].values.tolist() == [0, 0, 0, 0, 0, 0, 0, last]
    undecided = up["attractor"].values == up["attractor"].values[0]
    assert np.flatnonzero(undecided).tolist() == [0, 3, 4]
    np.testing.assert_array_equal(hazy["L_s"], told["L_s"])  # every state was handed on
    for name, changes in {"one": {"chunk_points": 1}, "cut": {"max_points": 13}}.items():
        for more in (changes, {}):
            sweep(tmp_path / f"{name}.nc", text, executor="sweep_fakes:hazy", **more)
        assert (tmp_path / f"{name}.nc").read_bytes() == (tmp_path / "a.nc").read_bytes()


def test_a_chain_ends_where_nothing_is_left_to_go_on_from(tmp_path: Path) -> None:
    sweep(tmp_path / "a.nc", sweep_fakes.CHAIN, executor="sweep_fakes:ended")
    up = read_datasets(tmp_path / "a.nc")[""].sel(initial="up", v=1.0)
    assert up["status"].values.tolist() == [0, 0, 0, 0, 4, 4, 4, 4]


def first_that_raises() -> tuple[int, int]:
    """The first point of `BELT`, as they are taken, where N = 2: how many before it, its number."""
    order = spread(np.arange(30)).tolist()
    return next((place, one) for place, one in enumerate(order) if one // 6 == 1)


def test_a_failed_point_loses_no_other_and_says_how_to_run_it_alone(tmp_path: Path) -> None:
    summary = sweep(tmp_path / "a.nc", executor="sweep_fakes:raising")
    assert summary.counts["failed"] == 6
    assert summary.counts["ok"] == 24
    assert not summary.complete
    ((what, command),) = summary.errors
    assert what == "ValueError: N is two"
    _, first = first_that_raises()
    speed = [0.5, 1.0, 2.0][first // 2 % 3]
    assert f"--set 'grid.N=[2.0]' --set 'grid.v=[{speed}]'" in command
    assert "ValueError: N is two" in (tmp_path / "a.run" / "run.log").read_text()
    again = sweep(tmp_path / "a.nc")
    assert (again.ran, again.complete) == (6, True)
    sweep(tmp_path / "b.nc")
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


class Notes(Silent):
    """Keeps what is worth a line."""

    def __init__(self) -> None:
        self.told: list[str] = []

    def note(self, text: str) -> None:
        self.told.append(text)


def test_a_vast_dataset_of_few_points_is_not_written_before_the_run_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A large one says what goes on; what is stored becomes the same dataset as ever."""
    for name, limit in (("SLOW", 30), ("VAST", 30), ("SCANT", 0.2)):
        monkeypatch.setattr(f"fiv_cli.sweep.run.{name}", limit)
    output, case, notes = tmp_path / "a.nc", sweep_fakes.case(), Notes()
    few = run_case(case, output, policy(max_points=5), notes)
    assert not output.exists() and not notes.told
    assert "as 5 of its 30 points are done" in few.unwritten in "\n".join(few.lines())
    assert f"`fiv assemble fake.toml -o {output}`" in few.unwritten
    assert not run_case(case, output, policy(max_points=5), notes).unwritten
    assert read_attributes(output)["partial"] == "10 of 30 points"
    assert notes.told[-1].startswith(f"writing {output}: 10 of its 30 points are done; Ctrl-C now")
    assert run_case(case, output, HERE, notes).complete
    sweep(tmp_path / "b.nc")
    assert output.read_bytes() == (tmp_path / "b.nc").read_bytes()


@pytest.mark.parametrize(
    ("executor", "first", "alike"),
    [("raising", "ValueError: N is two", 0), ("malformed", "cannot be stored", 1)],
)
def test_failures_are_told_as_they_happen_and_once_that_all_fail_alike(
    tmp_path: Path, executor: str, first: str, alike: int
) -> None:
    notes = Notes()
    chosen = policy(executor=f"sweep_fakes:{executor}", chunk_points=1)
    run_case(sweep_fakes.case(), tmp_path / "a.nc", chosen, notes)
    (one,) = (text for text in notes.told if text.startswith("a point failed, "))
    assert "N=" in one and first in one
    assert len([text for text in notes.told if text.startswith("all 20 points")]) == alike


def test_fail_fast_stops_and_keeps_what_is_finished(tmp_path: Path) -> None:
    summary = sweep(
        tmp_path / "a.nc", executor="sweep_fakes:raising", fail_fast=True, chunk_points=1
    )
    assert summary.counts["failed"] == 1
    before, _ = first_that_raises()
    assert summary.counts["pending"] == 29 - before
    assert summary.counts["ok"] == before


def test_a_chain_broken_by_an_outer_failure_is_made_whole_on_resume(tmp_path: Path) -> None:
    for on_loss in ("stop", "restart"):
        text = sweep_fakes.LOOP.replace('"go-on"', f'"{on_loss}"')
        output = tmp_path / f"{on_loss}.nc"
        broken = sweep(output, text, executor="sweep_fakes:raising")
        assert broken.counts["failed"] == 4
        sweep(output, text, max_points=5, chunk_points=1)
        sweep(output, text)
        sweep(tmp_path / "whole.nc", text, fresh=True)
        assert output.read_bytes() == (tmp_path / "whole.nc").read_bytes()


def test_a_result_that_cannot_be_stored_is_a_failed_point(tmp_path: Path) -> None:
    summary = sweep(tmp_path / "a.nc", executor="sweep_fakes:malformed")
    assert summary.counts["failed"] == 30
    assert "cannot be stored" in summary.errors[0][0]


def test_mu_k_above_mu_s_is_not_computed(tmp_path: Path) -> None:
    text = sweep_fakes.BELT.replace("v = [0.5, 1.0, 2.0]", "mu_k = [0.1, 0.9]")
    summary = sweep(tmp_path / "a.nc", text)
    assert (summary.counts["not_computed"], summary.counts["ok"]) == (10, 10)
    assert summary.complete


def test_another_case_is_refused_and_named(tmp_path: Path) -> None:
    sweep(tmp_path / "a.nc")
    other = sweep_fakes.BELT.replace('"belt-1dof"', '"belt-1dof"\nparameters = { k = 2.0 }')
    with pytest.raises(StoreMismatchError):
        sweep(tmp_path / "a.nc", other)
    (tmp_path / "a.nc").unlink()
    with pytest.raises(StoreMismatchError, match=r"parameters\.k") as caught:
        sweep(tmp_path / "a.nc", other)
    assert caught.value.exit_code == 6
    assert "--fresh" in str(caught.value)
    assert sweep(tmp_path / "a.nc", other, fresh=True).ran == 30


def test_titles_and_claims_do_not_count(tmp_path: Path) -> None:
    sweep(tmp_path / "a.nc")
    renamed = sweep_fakes.BELT.replace("fake sweep", "another title")
    assert sweep(tmp_path / "a.nc", renamed).ran == 0
    assert read_datasets(tmp_path / "a.nc")[""].attrs["title"] == "another title"


def test_a_damaged_shard_is_reported_and_its_points_are_run_again(tmp_path: Path) -> None:
    output = tmp_path / "a.nc"
    sweep(output, chunk_points=10)
    expected = output.read_bytes()
    first, second, _ = sorted((tmp_path / "a.run" / "shards").glob("*.h5"))
    first.write_bytes(first.read_bytes()[:-1000])
    second.write_bytes(b"not a shard")
    summary = sweep(output)
    assert [path for path, _ in summary.ignored] == [first, second]
    assert summary.ran == 20
    assert output.read_bytes() == expected


@pytest.mark.parametrize("number", range(6))
@pytest.mark.parametrize("step", ["open", "write", "fsync", "replace"])
def test_a_stop_at_any_write_loses_only_what_was_in_flight(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: int, step: str
) -> None:
    """Kill the program (as an exception that nothing catches) at each write of the store."""
    sweep(tmp_path / "whole.nc")
    output = tmp_path / "a.nc"

    class Killed(BaseException):
        pass

    calls = iter(range(1000))
    genuine = {"fsync": os.fsync, "replace": Path.replace, "write": files._fill}

    def strike() -> None:
        if next(calls) == number:
            raise Killed

    def half_written(path: Path, content: Sequence[bytes]) -> None:
        if next(calls) == number:
            whole = b"".join(content)
            path.write_bytes(whole[: len(whole) // 2])
            raise Killed
        genuine["write"](path, content)

    if step == "fsync":
        monkeypatch.setattr(files.os, "fsync", lambda fd: (strike(), genuine["fsync"](fd)))
    elif step == "replace":
        monkeypatch.setattr(
            Path, "replace", lambda self, to: (strike(), genuine["replace"](self, to))[1]
        )
    elif step == "write":
        monkeypatch.setattr(files, "_fill", half_written)
    else:
        monkeypatch.setattr(
            files,
            "_fill",
            lambda path, content: (strike(), genuine["write"](path, content)),
        )
    with pytest.raises(Killed):
        sweep(output, chunk_points=8)
    monkeypatch.undo()
    sweep(output)
    assert output.read_bytes() == (tmp_path / "whole.nc").read_bytes()
    assert not list((tmp_path / "a.run").glob("**/.*.tmp"))


def test_a_full_disk_is_a_clear_error_and_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    output = tmp_path / "a.nc"
    genuine = files._fill
    shards = iter(range(100))

    def full(path: Path, content: Sequence[bytes]) -> None:
        if path.parent.name == "shards" and next(shards) == 2:
            path.write_bytes(b"".join(content)[:100])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        genuine(path, content)

    monkeypatch.setattr(files, "_fill", full)
    with pytest.raises(StorageError, match="No space left on device") as caught:
        sweep(output, chunk_points=5)
    assert caught.value.exit_code == 2
    stored = list((tmp_path / "a.run" / "shards").iterdir())
    assert sorted(path.name for path in stored) == ["000000.h5", "000001.h5"]
    monkeypatch.undo()
    assert sweep(output).ran == 20


@pytest.mark.parametrize("executor", ["deadly_once", "breaking_off"])
def test_a_worker_that_dies_once_costs_nothing(
    tmp_path: Path, count_file: Path, executor: str
) -> None:
    sweep(tmp_path / "a.nc")
    summary = sweep(
        tmp_path / "b.nc",
        executor=f"sweep_fakes:{executor}",
        workers=2,
        in_process_below=0.0,
        chunk_points=4,
    )
    assert count_file.exists()
    assert summary.complete
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


@pytest.mark.parametrize(
    ("text", "points"), [(sweep_fakes.BELT, 4), (sweep_fakes.CHAIN, 4), (sweep_fakes.CHAIN, 14)]
)
def test_a_point_that_kills_its_worker_twice_is_one_failed_point(
    tmp_path: Path, text: str, points: int
) -> None:
    changes = {"workers": 2, "in_process_below": 0.0, "chunk_points": points}
    summary = sweep(tmp_path / "b.nc", text, executor="sweep_fakes:deadly", **changes)
    assert summary.counts["failed"] == 2
    dataset = read_datasets(tmp_path / "b.nc")[""]
    assert (dataset["status"].sel(N=3.0, v=1.0) == 2).all()
    assert (dataset["reason"].sel(N=3.0, v=1.0) == 2).all()
    sweep(tmp_path / "b.nc", text, **changes)
    sweep(tmp_path / "a.nc", text)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


@pytest.mark.campaign
def test_a_death_within_the_limit_is_no_matter_of_time(tmp_path: Path) -> None:
    summary = sweep(tmp_path / "a.nc", executor="sweep_fakes:deadly", time_limit=30.0)
    assert summary.counts["failed"] == 2
    assert "died twice" in summary.errors[0][0]


def test_a_wall_clock_limit_fails_the_point_only_until_resume(tmp_path: Path) -> None:
    summary = sweep(
        tmp_path / "a.nc", executor="sweep_fakes:endless", time_limit=0.5, chunk_points=10
    )
    assert summary.counts["failed"] == 2
    assert "longer than 0.5 s" in summary.errors[0][0]
    assert sweep(tmp_path / "a.nc").complete
    sweep(tmp_path / "b.nc")
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_a_task_goes_on_with_several_chains(tmp_path: Path) -> None:
    sweep(tmp_path / "a.nc", sweep_fakes.CHAIN, chunk_points=16)
    assert len(list((tmp_path / "a.run" / "shards").iterdir())) == 2  # 2 chains of 8, 16 starts


def test_a_live_run_locks_its_directory(tmp_path: Path) -> None:
    sweep(tmp_path / "a.nc")
    folder = tmp_path / "a.run"
    assert holder(folder) is None
    with hold(folder):
        assert holder(folder) == os.getpid()
        with pytest.raises(LockedError, match=str(os.getpid())):
            sweep(tmp_path / "a.nc")
    (folder / "lock").write_text("999999999")
    assert sweep(tmp_path / "a.nc").ran == 0


def test_outputs_that_cannot_be_written_are_refused_before_anything_runs(
    tmp_path: Path, count_file: Path
) -> None:
    (tmp_path / "notes.nc").write_text("my notes")
    (tmp_path / "folder.nc").mkdir()
    for output, error in (
        (tmp_path / "folder.nc", UsageError),
        (tmp_path / "notes.nc", UsageError),
        (tmp_path / "notes.nc" / "a.nc", StorageError),
    ):
        with pytest.raises(error) as caught:
            sweep(output, executor="sweep_fakes:counted")
        assert caught.value.exit_code == 2
    assert (tmp_path / "notes.nc").read_text() == "my notes"
    assert not runs(count_file)


def test_the_run_directory_tells_what_it_belongs_to(tmp_path: Path) -> None:
    case = sweep_fakes.case(sweep_fakes.BELT, "model.parameters.k=2.0")
    run_case(case, tmp_path / "a.nc", policy(), Silent())
    folder = tmp_path / "a.run"
    assert json.loads((folder / "identity.json").read_text())["model"] == "belt-1dof"
    assert (folder / "case.toml").read_text().startswith("# --set model.parameters.k=2.0\n")
    assert "30 points run" in (folder / "run.log").read_text()


def test_several_analyses_become_groups(tmp_path: Path) -> None:
    text = sweep_fakes.BELT + '[[analysis]]\nkind = "response"\nname = "again"\nt_max = 10\n'
    sweep(tmp_path / "a.nc", text)
    groups = read_datasets(tmp_path / "a.nc")
    assert list(groups) == ["response", "again"]
    assert groups["response"]["L_s"].equals(groups["again"]["L_s"])


def test_tasks_grow_with_what_is_measured() -> None:
    pace = Pace()
    assert pace.count(10_000, 2, HERE) == 1
    pace.learn(1, 0.9, 100)  # loads code
    assert pace.remaining(10_000) is None
    counts = []
    for _ in range(8):
        counts.append(pace.count(100_000, 2, HERE))
        pace.learn(counts[-1], 1e-3 * counts[-1], 100 * counts[-1])
    assert counts == sorted(counts)
    assert counts[0] == 1
    assert counts[-1] == 500
    assert pace.remaining(10_000) == pytest.approx(10.0)
    assert pace.count(16, 2, HERE) == 2


def test_long_runs_have_longer_tasks_up_to_a_bound() -> None:
    paces = [Pace(1e-3, last_count=10**9, tasks=9, spent=s) for s in (0.0, 20.0, 250.0, 1e4)]
    assert [pace.count(10**9, 2, HERE) for pace in paces] == [500, 500, 5000, 20_000]


def test_tasks_with_large_results_are_short() -> None:
    pace = Pace(seconds_per_point=1e-3, last_count=10**9, tasks=9)
    pace.learn(10, 1e-2, 10 * 2**20)
    assert pace.count(10**9, 2, HERE) == LARGEST_CHUNK // 2**20


def test_what_is_not_kept_in_memory_is_read_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    sweep(tmp_path / "a.nc", chunk_points=4)
    monkeypatch.setattr(journal, "KEPT", 3000)
    sweep(tmp_path / "b.nc", chunk_points=4)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()


def test_a_line_tells_time_rate_and_what_is_left() -> None:
    now = [0.0]
    lines: list[str] = []
    progress = Lines(lines.append, "2 of 3, a.toml: ", lambda: now[0])
    progress.begin(100, 10)
    for seconds, points in ((100.0, 50), (300.0, 10)):  # the rest is slower
        now[0] += seconds
        progress.advance(points, 1)
        progress.tell()
    progress.slow(299.0, "v=1.0,initial=far")
    now[0] += 700.0  # nothing happens
    progress.tell()
    progress.end()
    assert lines == [
        "2 of 3, a.toml: 100 points, 10 already stored, 90 to run",
        "2 of 3, a.toml: 60 of 100 points done, 1 failed; "
        "100 s elapsed, 0.5 points/s, some 80 s to go",
        "2 of 3, a.toml: 70 of 100 points done, 2 failed; "
        "6.7 min elapsed, 0.033 points/s of late, some 15 min to go",
        "2 of 3, a.toml: 70 of 100 points done, 2 failed; "
        "18 min elapsed, 0.01 points/s of late, some 50 min to go; "
        "slowest 5 min at v=1.0,initial=far",
    ]


def test_a_run_that_waits_for_its_first_point_says_what_bounds_one() -> None:
    course = Course(1, [0.0], [0])
    assert course.pace(90.0) == "90 s elapsed, being compiled or prepared"
    course.turn("response", 0)
    assert course.pace(90.0) == "90 s elapsed"
    assert course.pace(240.0).startswith("4 min elapsed: t_max, or --time-limit, bounds")


@pytest.mark.parametrize(("fresh", "how"), [(False, ""), (True, " without --fresh")])
def test_a_run_that_was_stopped_says_which_command_goes_on(fresh: bool, how: str) -> None:
    """With --fresh the same would throw away what it has kept."""
    told = Summary(Path("a.nc"), {"ok": 2, "pending": 3}, 2, 1.0, fresh=fresh).lines()
    assert told[-1] == f"  what is finished is kept; the same command{how} goes on from here"
    none = Summary(Path("a.nc"), {"ok": 0, "pending": 5}, 0, 1.0, fresh=fresh).lines()
    assert not any("kept" in line for line in none)


def test_a_rate_of_the_first_points_says_what_it_is_worth() -> None:
    """Counts are numpy's."""
    course = Course(1000, [0.0, 10.0], [0, np.int64(50)])
    assert course.pace(10.0) == "10 s elapsed, 5 points/s"  # the rest may be quite another
    course.note(20.0, np.int64(50))
    assert course.pace(20.0) == "20 s elapsed, 5 points/s, some 3 min to go"
    assert course.pace(29.0) == "29 s elapsed, 5 points/s, some 2.9 min to go"  # none is due yet
    assert course.pace(40.0) == "40 s elapsed, 2.5 points/s, some 6 min to go"
    course = Course(101, [0.0, 20.0, 30.0], [0, 90, 100])
    assert course.pace(40.0) == "40 s elapsed, 3.3 points/s"  # the last should be there by now
    course = Course(3170, [0.0, 60.0, 120.0], [0, 2000, 3000])
    assert course.pace(121.0).endswith("17 points/s of late, some 9.2 s to go")
    assert course.pace(127.0).endswith(
        "17 points/s of late"
    )  # none came for longer than would be left
    few = Course(1000, [0.0, 90.0], [0, 45])
    alike = "90 s elapsed, 0.5 points/s, some 32 min to go, were the others alike"
    assert few.pace(90.0) == alike
    again = Course(1000, [0.0, 10.0], [400, 405])  # what was stored says nothing of this run
    assert again.pace(10.0) == "10 s elapsed, 0.5 points/s"
    again.note(90.0, 40)
    assert again.pace(90.0).endswith("some 18 min to go, were the others alike")


def test_a_rate_is_that_of_its_analysis() -> None:
    """Eigenvalues, a thousand a second, say nothing of the motions after them."""
    course = Course(1200, [0.0], [0])
    course.turn("eigenvalues", 200)
    course.note(0.5, 500)
    assert course.pace(30.0).startswith("30 s elapsed, 17 points/s, some 30 s to go in eigenvalues")
    course.note(31.0, 500)
    assert course.pace(31.0) == "31 s elapsed, 32 points/s"  # that analysis is done
    course.turn("response", 0)
    assert course.pace(61.0) == "61 s elapsed"
    course.note(71.0, 50)
    told = "71 s elapsed, 1.2 points/s of late, some 2 min to go"
    assert course.pace(71.0) == told
    course.turn("response", 0, grows=True)  # a map that is being refined
    assert course.pace(71.0) == f"{told} with the points that are known so far"


def test_what_a_run_compiles_before_its_first_point_is_no_part_of_its_pace() -> None:
    lines: list[str] = []
    now = [0.0]
    progress = Lines(lines.append, "", lambda: now[0])
    progress.begin(100, 0)
    now[0] = 90.0
    progress.tell()
    progress.turn("response", 0, False)
    now[0] = 110.0
    progress.advance(20, 0)
    progress.tell()
    progress.end()
    assert lines[1:] == [
        "0 of 100 points done, 0 failed; 90 s elapsed, being compiled or prepared",
        "20 of 100 points done, 0 failed; 110 s elapsed, 1 points/s of late, some 80 s to go",
    ]


def test_a_log_says_which_analysis_came_how_far(tmp_path: Path) -> None:
    log = (
        "fiv 0: fiv run a.toml; 0 of 30 points done",
        "fixed: begins, 0 of 30 points done",
        "fixed: 20 points in 0.1 s, 0 failed, 20 of 30 points done; slowest 0 s at a=1,initial=b",
        "point 3: no: 1 of 2 points",
        "driven: 5 points in 9 s, 1 failed, 25 of 30 points done; slowest 1 s at a=1",
    )
    stamp = "2026-01-01T00:00:{:02d}.000+00:00"
    lines = (f"{stamp.format(10 * number)} {line}\n" for number, line in enumerate(log))
    (tmp_path / "run.log").write_text("".join(lines))
    (told,) = runs_in(tmp_path)
    assert (told.course.name, told.course.since, told.course.counts) == (
        "driven",
        2,
        [0, 0, 20, 25],
    )
    assert told.course.rate(40.0) == pytest.approx(5 / 20)


def test_the_log_of_a_run_that_was_ended_tells_its_whole_time(tmp_path: Path) -> None:
    """Two points in "4.2 s, 2.9 points/s" of a run of 7.2 s, most of which was compilation."""
    log = {
        0: "fiv 0: fiv run a.toml; 0 of 9 points done",
        3: "response: begins, 0 of 9 points done",
        5: "response: 2 points in 2 s, 0 failed, 2 of 9 points done; slowest 1 s at a=1",
        8: "interrupted: 2 points run",
    }
    stamp = "2026-01-01T00:00:{:02d}.000+00:00"
    (tmp_path / "run.log").write_text(
        "".join(f"{stamp.format(second)} {text}\n" for second, text in log.items())
    )
    (told,) = runs_in(tmp_path)
    begin = told.course.times[0]
    assert told.last - begin == 8.0
    words = told.course.pace(told.last, told.last)
    assert (
        words
        == "8 s elapsed, 3 s of them before its first point began, 0.4 points/s, some 18 s to go"
    )
    assert told.course.pace(begin + 5.0).startswith("5 s elapsed, 1 points/s of late")


def test_lines_come_whether_anything_happens_or_not(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(progress_of, "INTERVAL", 0.01)
    told = threading.Semaphore(0)
    progress = Lines(lambda text: told.release())
    progress.begin(100, 10)
    assert all(told.acquire(timeout=10.0) for _ in range(3))
    progress.end()


def test_the_command_for_a_point_alone_says_each_thing_once() -> None:
    given = ("model.parameters.c=0.2", "model.parameters.k=2.0")
    overrides = ("grid.N.num=3", "grid.v=[2.0]", *given)
    plan = make_plan(sweep_fakes.case(sweep_fakes.BELT, *overrides))
    command = reproduction(plan, plan.analyses[0], 2)
    words = shlex.split(command, comments=True)
    assert words == [
        *("fiv", "run", "fake.toml", "--set", given[0], "--set", given[1]),
        *("--set", "grid.N=[3.0]", "--set", "grid.v=[2.0]"),
    ]
    (again,) = make_plan(sweep_fakes.case(sweep_fakes.BELT, *words[4::2])).analyses
    assert [axis.values for dim in again.layout.dims for axis in dim.axes] == [(3.0,), (2.0,)]


class Coming:
    """Workers that bring so many `answers` before the run is ended by a signal."""

    size, answers = 2, 0

    def __init__(self, *_: object) -> None:
        self.tasks: list[Task] = []

    def submit(self, task: Task) -> int:
        """Take it."""
        self.tasks.append(task)
        return len(self.tasks)

    def completed(self, seconds: float) -> list[tuple[int, Result]]:
        """An answer, if one is left."""
        if not self.answers:
            raise ending.Ended("interrupted")
        self.answers -= 1
        return [(1, run_task(self.tasks[0]))]

    def lost(self) -> list[Any]:
        """None died."""
        return []

    def close(self) -> None:
        """There is nothing to end."""


@pytest.mark.parametrize("answers", [0, 1])
def test_a_run_that_is_ended_before_its_workers_brought_a_point_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, answers: int
) -> None:
    """Two points of 8001, after eleven seconds, looked as if the others had been thrown away."""
    sweep(tmp_path / "a.nc", max_points=2)
    monkeypatch.setattr(Coming, "answers", answers)
    monkeypatch.setattr(pool, "WorkerPool", Coming)
    waiting = "" if answers else "; its workers had brought no point yet"
    told = f"a.nc holds what is done, and is marked partial{waiting}"
    with pytest.raises(ending.Ended) as ended:
        sweep(tmp_path / "a.nc", workers=2, in_process_below=0.0)
    assert str(ended.value).endswith(told)
