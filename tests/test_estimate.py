"""What a run will cost: the range holds it, whichever points cost most."""

from __future__ import annotations

import multiprocessing
import os
import re
import signal
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import islice
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from small_cases import ENDLESS, PIN

from fiv_cli import api
from fiv_cli.case.case import Refinement
from fiv_cli.case.load import parse_case
from fiv_cli.cli.main import run as fiv
from fiv_cli.sweep.borders import draw
from fiv_cli.sweep.estimate import PIECES, _crew, _parallel, _spread, estimate, foreseen
from fiv_cli.sweep.journal import Journal
from fiv_cli.sweep.map_estimate import Drawing
from fiv_cli.sweep.plan import make_plan
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.probe import Probe, Tried
from fiv_cli.sweep.progress import Silent
from fiv_cli.sweep.refine import Maps
from fiv_cli.sweep.run import run_case
from fiv_cli.sweep.worker import ChainState, Result, Segment, Task, run_task


@pytest.mark.parametrize(
    ("chained", "limit"), [(False, np.inf), (True, np.inf), (False, 0.5), (True, 5.0)]
)
def test_an_estimate_holds_the_time_where_few_points_cost_nearly_all(
    monkeypatch: pytest.MonkeyPatch, chained: bool, limit: float
) -> None:
    """Of a million points of which one in 25 takes a hundred times as long, in one corner.

    What takes longer than a limit is given up, and then known to take twice its time at most.
    """
    table: dict[str, Any] = {
        "schema": 1,
        "model": {"name": "belt-1dof"},
        "analysis": [{"kind": "response"}],
    }
    table["grid"] = {axis: {"start": 1.0, "stop": 2.0, "num": 1000} for axis in ("v", "N")}
    table["initial"] = [{"label": "rest", "kind": "state"}]
    if chained:
        followed = {"label": "up", "kind": "continue", "along": "v", "direction": "up"}
        table["initial"].append({**followed, "from": "rest"})
    names = [name for name, _ in make_plan(api.load(table)).analyses[0].template.axes]

    def costs(segments: tuple[Segment, ...]) -> Iterator[float]:
        for values in (values for segment in segments for values in segment.values):
            at = dict(zip(names, values, strict=True))
            yield 1.0 if at["v"] < 1.2 and at["N"] > 1.8 else 0.01

    def tried(_: object, __: object, segments: tuple[Segment, ...], share: float = 1.0) -> Tried:
        found: Any = SimpleNamespace(
            states={0: ChainState(False, {}, "periodic")}, failures=Counter
        )
        seconds, nbytes = sum(costs(segments)), 100 * len(segments)
        if seconds > limit:
            return Tried(None, limit, 2.0 * seconds, nbytes)
        return Tried(found, seconds, seconds, nbytes)

    monkeypatch.setattr("fiv_cli.sweep.estimate._tried", tried)
    stopped = SimpleNamespace(monotonic=lambda: 0.0)  # not ended by the clock of a busy machine
    monkeypatch.setattr("fiv_cli.sweep.estimate.time", stopped)
    monkeypatch.setattr("fiv_cli.sweep.estimate.OF_TIMING", 0.0)  # what a point takes is given
    (found,) = estimate(api.load(table), 1, lambda _: None)
    low, high = found.seconds
    assert low < (1 + chained) * 1e6 * (0.04 + 0.96 * 0.01) < high
    assert high < 2.0 * low or found.given_up
    assert bool(found.given_up) == (limit < np.inf)
    assert found.sampled < 0.02 * found.points[1]


def test_points_that_are_given_up_together_are_not_taken_for_dear_ones(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Without damping a point is ten times as cheap as it is elsewhere, and it comes first."""
    table: dict[str, Any] = {"schema": 1, "model": {"name": "flutter-2dof"}}
    table["grid"] = {"c2": {"start": 0.0, "stop": 1.5, "num": 31}, "c1": [0.0, 0.05, 0.2]}
    asked = {"kind": "critical", "parameter": "mu_k", "bracket": [0.0, 50.0]}

    def tried(_: object, __: object, segments: tuple[Segment, ...], share: float = 1.0) -> Tried:
        seconds = sum(0.2 if any(one.values[0]) else 0.02 for one in segments)
        result: Any = None if seconds > 2.5 else SimpleNamespace(states={}, failures=Counter)
        return Tried(result, min(seconds, 2.5), np.inf if result is None else seconds, 100)

    monkeypatch.setattr("fiv_cli.sweep.estimate._tried", tried)
    stopped = SimpleNamespace(monotonic=lambda: 0.0)  # not ended by the clock of a busy machine
    monkeypatch.setattr("fiv_cli.sweep.estimate.time", stopped)
    (found,) = estimate(api.load(table | {"analysis": [asked]}), 1, lambda _: None)
    assert found.given_up == 0 and found.seconds[0] < 93 * 0.2 < found.seconds[1] < 60.0


def test_a_point_that_does_not_end_is_given_up_and_those_after_it_are_run(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """In compiled code, which heeds nothing: each of the regions of a grid is tried."""
    monkeypatch.setattr("fiv_cli.sweep.estimate.PATIENCE", 4.0)
    (found,) = estimate(parse_case(ENDLESS, "endless.toml"), 1, lambda _: None)
    assert found.sampled > 1 and found.given_up  # some of them end after a second
    assert found.points == (4, 4) and found.limit == 4.0 / PIECES
    assert found.seconds[0] < 4 * 3600.0 < found.seconds[1]
    assert "given up after 0.5 s" in found.line()


def endless() -> Task:
    """A point that does not end."""
    analysis = make_plan(parse_case(ENDLESS, "endless.toml")).analyses[0]
    values, start = analysis.point(0)
    return Task(analysis.template, analysis.layout.variables, (Segment((values,), start),))


def test_what_is_given_up_takes_at_most_what_its_steps_and_its_limit_allow() -> None:
    task = endless()
    twice = replace(task, segments=2 * task.segments)
    with Probe(0.5) as unlimited, Probe(0.5, most=30.0) as limited:
        given_up = unlimited.run(task)
        assert given_up.result is None and given_up.most > 3600.0
        assert 0.0 < given_up.least <= 0.5
        assert limited.run(twice, share=0.5).most == 2 * 30.0


SHORT: dict[str, Any] = {
    "schema": 1,
    "model": {"name": "belt-1dof"},
    "analysis": [{"kind": "history", "t_end": 30.0}],
}
LONG = SHORT | {"solver": {"max_steps": 10**15, "max_events": 10**15}}
LONG["analysis"] = [{"kind": "history", "t_end": 1e11}]


def test_of_few_points_the_time_of_their_motions_tells_how_long_they_take(tmp_path: Path) -> None:
    """One that is done at once is not even tried."""
    short, long = (Journal(tmp_path, make_plan(api.load(table))) for table in (SHORT, LONG))
    assert foreseen(short, Policy()) == foreseen(long, Policy(time_limit=60.0)) == []
    assert [one.seconds[1] > 3600.0 for one in foreseen(long, Policy())] == [True]


def test_who_runs_a_case_from_python_and_hears_of_it_hears_that_it_takes_long(
    tmp_path: Path,
) -> None:
    class Enough(Exception):
        pass

    class Told(Silent):
        def note(self, text: str) -> None:
            if "may take more than an hour" in text:
                raise Enough

    with pytest.raises(Enough):
        api.run(api.load(LONG), tmp_path / "a.nc", progress=Told())


def part_of_few_steps(task: Task) -> Task:
    """One that ends at once."""
    solver = replace(task.template.solver, max_steps=10)
    return replace(task, template=replace(task.template, solver=solver))


def test_a_process_that_tries_points_ends_with_what_it_is_for() -> None:
    with Probe(0.1) as probe:
        probe.run(endless())
        probe.run(part_of_few_steps(endless()))
        assert multiprocessing.active_children()
    assert not multiprocessing.active_children()


def test_a_process_that_others_end_or_keep_waiting_is_begun_once_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is not taken for a point that takes too long: one in seconds told "at least" for a run."""
    monkeypatch.setattr("fiv_cli.sweep.probe.run_task", partial(ended_first, tmp_path / "met"))
    with Probe(5.0) as probe:
        assert probe.run(part_of_few_steps(endless())).result is not None
    assert (tmp_path / "met").exists()


def test_points_that_take_less_than_a_tick_of_the_clock_take_some_time(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Of none it was told that they take at least 0 s, and so may take more than an hour."""
    monkeypatch.setattr("fiv_cli.sweep.probe.time.process_time", lambda: 0.0)
    with Probe(5.0) as probe:
        assert 0.0 < probe.run(part_of_few_steps(endless())).most < 5.0


def ended_first(met: Path, task: Task) -> Result:
    """Run a task; the first process that is asked to is ended as by the alarm."""
    if not met.exists():
        met.touch()
        os.kill(os.getpid(), signal.SIGALRM)
    return run_task(task)


@pytest.mark.parametrize(
    ("load", "told"), [(0.7, ""), (4.2, ", 4.7 times that beside what runs here now")]
)
def test_an_estimate_tells_that_others_use_the_machine(
    monkeypatch: pytest.MonkeyPatch, load: float, told: str
) -> None:
    """By what there was to do before the sample was run."""
    monkeypatch.setattr(os, "cpu_count", lambda: 2)
    monkeypatch.setattr(os, "getloadavg", lambda: (2 * load, 0.0, 0.0))
    table = {"schema": 1, "model": {"name": "belt-1dof"}, "analysis": [{"kind": "eigenvalues"}]}
    (found,) = estimate(api.load(table), 1, lambda _: None)
    monkeypatch.setattr(os, "getloadavg", lambda: (99.0, 0.0, 0.0))
    assert f", cores being free{told}; " in found.line()


@pytest.mark.parametrize("load", [0.0, 0.1, 50.0])
def test_that_others_use_the_machine_changes_no_number(
    monkeypatch: pytest.MonkeyPatch, load: float
) -> None:
    monkeypatch.setattr(os, "getloadavg", lambda: (load, 0.0, 0.0))
    (one,), (analysis,) = (
        make_plan(api.load(LONG | {"grid": {"v": speeds}})).analyses
        for speeds in ([1.0], [1.0, 2.0, 3.0])
    )
    assert _parallel(analysis, _crew(3, 2)) == 2
    assert _parallel(analysis, _crew(3, np.inf)) == 3
    assert _parallel(one, _crew(3, 2)) == 1  # no two share a point


def test_an_estimate_tells_of_points_that_failed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    case = tmp_path / "a.toml"
    case.write_text(
        'schema = 1\n[model]\nname = "belt-1dof"\n[grid]\nv = [0.0, 0.5, 1.0]\n'
        '[[analysis]]\nkind = "eigenvalues"\n'
    )
    assert fiv(["check", str(case), "--estimate"]) == 0
    told = capsys.readouterr().out
    assert "    of 3 points 1 failed: no_drive: the drive of a contact stands still" in told
    plane = case.read_text().replace("v = [", "c = [0.1, 0.2, 0.3]\nv = [")
    case.write_text(plane + '[sweep]\nrefine = { of = "stable", levels = 1 }\n')
    assert fiv(["check", str(case), "--estimate"]) == 0
    assert " failed: no_drive: the drive of a contact stands still" in capsys.readouterr().out


def test_a_sample_is_spread_over_every_axis_and_reaches_every_point() -> None:
    sizes = (4, 3, 50)
    places = np.array(list(_spread(sizes)))
    assert len(places) == 600 == len({tuple(place) for place in places.tolist()})
    first = np.array(list(islice(_spread((4, 3, 10**6)), 120)))
    for axis, bins in ((0, 4), (1, 3), (2, 10)):
        shares = np.bincount(first[:, axis] * bins // (4, 3, 10**6)[axis], minlength=bins) / 120
        assert np.abs(shares * bins - 1.0).max() < 0.25


class Disc(list[int]):
    """Positions in a square, as the block of what is computed there: inside a disc, or outside."""

    @property
    def values(self) -> dict[str, np.ndarray]:
        x, y = np.divmod(np.array(self), 257) / np.float64(256)
        return {"attractor": ((x - 0.4) ** 2 + (y - 0.5) ** 2 < 0.09).astype(np.int32)}


@pytest.mark.parametrize(("seconds", "spread"), [(200, 20.0), (300, 2.0), (1000, 1.2), (1e9, 1.0)])
def test_a_map_grows_as_its_borders_do(
    monkeypatch: pytest.MonkeyPatch, seconds: float, spread: float
) -> None:
    """Each point takes a second; how many there will be is foreseen from those of few levels."""
    square = np.arange(257**2).reshape(257, 257)
    maps = Maps(Refinement(5, "attractor", ("v", "N"), 0, 0), square[None], {"v": 9, "N": 9}, -1)
    picture = draw(
        np.array(maps.classes_of(Disc(square.ravel()))).reshape(257, 257),
        np.ones((257, 257), bool),
        5,
    )
    true, clock = int(picture.wanted.sum()), 0.0

    def run(positions: Sequence[int]) -> Tried:
        nonlocal clock
        clock += len(positions)
        result: Any = SimpleNamespace(block=Disc(positions), failures=Counter)
        return Tried(result, float(len(positions)), float(len(positions)), len(positions))

    monkeypatch.setattr("fiv_cli.sweep.map_estimate.time.monotonic", lambda: clock)
    nothing = np.zeros(square.shape, np.int32), np.zeros(square.shape, bool)
    drawing = Drawing(maps, square, *nothing, run, at_once=10)
    drawing.until(seconds)
    (low, high), (least, most) = drawing.cost()
    assert 0.9 * low <= true <= 1.1 * high and high <= spread * low
    assert (least, most) == pytest.approx((low, high))


def test_what_is_stored_is_credited(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("pin.toml").write_text(PIN)
    case, said = api.load("pin.toml"), list[str]()
    for more, stored in ((1, 1), (1, 2)):
        run_case(case, Path("runs/pin.nc"), Policy(workers=1, max_points=more), Silent())
        found = [(one.points, one.stored) for one in estimate(case, 1, said.append)]
        assert found == [((1, 1), stored)][: 2 - stored]
    assert said[-1] == "every point of equilibrium is stored: nothing is to be run"


@pytest.mark.parametrize("points", [250_000, 1_000_000])
def test_one_number_is_told_of_the_memory_of_a_large_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], points: int
) -> None:
    """That of a million points lies in files: it needs no more than these do."""
    case = tmp_path / "pin.toml"
    grid = f"N0 = {{ start = 1, stop = 2, num = {points // 2} }}"
    case.write_text(PIN.replace("[grid]", f"[grid]\n{grid}"))
    assert fiv(["check", str(case)]) == 0
    assert "how long depends on what moves" in capsys.readouterr().out
    assert fiv(["check", str(case), "--estimate", "--workers", "1"]) == 0
    (told,) = re.findall(r"(\S+) MB of memory", capsys.readouterr().out)
    assert 200 < float(told) < 700


class Counted:
    """How often it was sent."""

    sent = 0

    def __reduce__(self) -> tuple[type[Counted], tuple[()]]:
        Counted.sent += 1
        return Counted, ()


def test_what_points_share_is_sent_once_whatever_their_number() -> None:
    """Of 40,000 starts it took ten times as long as a point, and counted."""
    task = part_of_few_steps(endless())
    settings = {**task.template.settings, "counted": Counted()}
    task = replace(task, template=replace(task.template, settings=settings))
    with Probe(5.0) as probe:
        results = [probe.run(task).result for _ in range(3)]
        assert all(result is not None for result in results)
        assert Counted.sent == 1
        probe.run(part_of_few_steps(task))
        assert Counted.sent == 2
