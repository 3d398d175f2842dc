"""The motion of one point of a sweep: which start it has, and what it is called."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sweep_fakes

from fiv_cli import api
from fiv_cli.analyses.base import Request
from fiv_cli.errors import UsageError
from fiv_cli.flags import STABLE
from fiv_cli.sweep.motion import find_point, run_motion
from fiv_cli.sweep.policy import Policy


@pytest.fixture
def seen() -> Iterator[list[Request]]:
    """Requests for a motion that reach the physics, for which the stand-in answers."""
    sweep_fakes.MOTIONS.clear()
    yield sweep_fakes.MOTIONS
    sweep_fakes.MOTIONS.clear()


POLICY = Policy(executor="sweep_fakes:motion", preparer="sweep_fakes:prepare")


def run(text: str, at: dict[str, str], **settings: float) -> Any:
    """Run a point again."""
    point = find_point(sweep_fakes.case(text), at)
    return run_motion(point, settings, lambda text: None, POLICY)


def test_the_point_keeps_its_parameters_start_and_place(seen: list[Request]) -> None:
    dataset, outcome = run(sweep_fakes.BELT, {"N": "3", "v": "2.0", "initial": "far"}, t_end=7.0)
    (request,) = seen
    assert outcome.status == "ok"
    assert (request.analysis, request.settings["t_end"]) == ("history", 7.0)
    assert (request.parameters["N"], request.parameters["v"]) == (3.0, 2.0)
    assert request.start is not None
    assert dict(request.start.values) == {"x_dot": 2.0}
    assert dict(dataset.sizes)["time"] == 3
    assert dataset["N"].values.tolist() == [3.0]
    assert dataset["initial"].values.tolist() == ["far"]


def test_without_an_end_the_budget_of_the_sweep_is_taken(seen: list[Request]) -> None:
    run(sweep_fakes.BELT + "t_max = 55.0\n", {"N": "3", "v": "2.0", "initial": "far"})
    assert seen[0].settings["t_end"] == 55.0


def test_a_continued_start_is_followed_to_the_point(seen: list[Request]) -> None:
    run(sweep_fakes.CHAIN, {"N": "3", "v": "1.0", "initial": "up"})
    start = seen[0].start
    assert start is not None and start.carried is not None
    first = np.sin(1.7 + 1.0) + 0.3
    assert start.kind == "continue"
    assert start.carried["x"] == pytest.approx(np.sin(2 * 1.7 + 1.0) + 0.1 * first, rel=1e-15)


def test_a_continued_start_is_followed_through_the_steps_between_points(
    seen: list[Request], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FIV_TEST_END", "8.0")
    point = find_point(sweep_fakes.case(sweep_fakes.CHAIN), {"N": "3", "v": "1.0", "initial": "up"})
    run_motion(point, {}, lambda text: None, replace(POLICY, executor="sweep_fakes:slipping"))
    start = seen[0].start
    assert start is not None and start.carried is not None
    assert 2.7 <= start.carried["N"] < 3.0


def test_a_chain_that_begins_where_another_ended_is_followed_through_both(
    seen: list[Request],
) -> None:
    run(sweep_fakes.LOOP, {"N": "7", "v": "1.0", "initial": "down"})
    x = 3.0
    for N in [*range(1, 9), 8]:
        x = np.sin(N * 1.7 + 1.0) + 0.1 * x
    assert seen[0].start is not None and seen[0].start.carried is not None
    assert seen[0].start.carried["x"] == pytest.approx(x, rel=1e-15)


def test_the_first_point_of_a_branch_has_the_start_of_the_chain(seen: list[Request]) -> None:
    run(sweep_fakes.CHAIN, {"N": "1", "v": "1.0", "initial": "up"})
    start = seen[0].start
    assert start is not None
    assert (start.kind, dict(start.values)) == ("state", {"x": 1.0})


def test_a_branch_that_ended_before_the_point(seen: list[Request]) -> None:
    with pytest.raises(UsageError, match="ends before this point"):
        run(sweep_fakes.CHAIN, {"N": "8", "v": "1.0", "initial": "up"})


def test_a_point_that_is_not_computed() -> None:
    text = sweep_fakes.BELT.replace("v = [0.5, 1.0, 2.0]", "mu_k = [0.1, 0.9]")
    with pytest.raises(UsageError, match="mu_k_above_mu_s"):
        find_point(sweep_fakes.case(text), {"N": "3", "mu_k": "0.9", "initial": "far"})


def test_a_number_as_it_is_printed_names_a_point_if_only_one_is_printed_so() -> None:
    text = sweep_fakes.BELT.replace("v = [0.5, 1.0, 2.0]", "v = [0.6666666667, 0.6666712, 1.8]")
    case = sweep_fakes.case(text)

    def found(v: str) -> float:
        point = find_point(case, {"N": "3", "v": v, "initial": "far"})
        return float(point.place["v"])

    assert [found("0.666667"), found("0.66667120"), found("1.80")] == [0.6666666667, 0.6666712, 1.8]
    with pytest.raises(UsageError, match=r"--at v=0.6666666667 or --at v=0.6666712$"):
        found("0.66667")
    for none in ("2", "0.66668", "nan"):  # 2 is 1.8 rounded, which nothing prints
        with pytest.raises(UsageError, match="off the grid") as refused:
            found(none)
        assert str(refused.value).endswith(f"add --set 'grid.v=[{none}]'")


def test_a_point_may_be_named_with_units() -> None:
    case = sweep_fakes.case(sweep_fakes.BELT)
    point = find_point(case, {"N": "3e-3 kN", "v": '"100 cm/s"', "initial": "far"})
    assert (point.place["N"], point.place["v"]) == (3.0, 1.0)


def test_what_is_wrong_along_several_axes_is_told_at_once() -> None:
    case = sweep_fakes.case(sweep_fakes.BELT)
    with pytest.raises(UsageError) as refused:
        find_point(case, {"N": "3.5", "v": "0.7", "initial": "far"})
    set_both = "--set 'grid.N=[3.5]'", "--set 'grid.v=[0.7]'"
    assert all(text in str(refused.value) for text in set_both)


def test_zipped_axes_are_named_by_what_makes_them_unique() -> None:
    text = sweep_fakes.BELT.replace(
        "N = { start = 1, stop = 5, num = 5 }\nv = [0.5, 1.0, 2.0]",
        'k = [1.0, 1.0, 2.0]\nm = [3.0, 4.0, 5.0]\n[sweep]\nzip = [["k", "m"]]',
    )
    case = sweep_fakes.case(text)
    assert find_point(case, {"m": "4", "initial": "far"}).place == {
        "k": 1.0,
        "m": 4.0,
        "initial": "far",
    }
    with pytest.raises(UsageError, match="several points"):
        find_point(case, {"k": "1", "initial": "far"})
    with pytest.raises(UsageError, match="no point"):
        find_point(case, {"k": "2", "m": "4", "initial": "far"})


BELT = {
    "schema": 1,
    "model": {"name": "belt-1dof"},
    "grid": {"v": [1.0], "c": [0.0, 2.0]},
    "initial": [{"label": "far", "kind": "equilibrium", "offset": {"x": 3.0}}],
    "analysis": [{"kind": "response"}],
}


def test_a_settled_motion_repeats_itself_after_each_of_its_periods() -> None:
    case = api.load(BELT, overrides={"grid.c": [0.0]})
    (period,) = api.run(case, workers=1)["period"].values.ravel()
    motion = api.history(case, periods=3, settled=True).squeeze()
    assert float(motion["time"][-1]) == pytest.approx(3 * period, rel=1e-12)
    path = np.stack([motion["x"], motion["x_dot"]])
    assert np.ptp(path[0]) > 1.0
    for number in (1, 2, 3):
        np.testing.assert_allclose(path[:, 1000 * number], path[:, 0], atol=1e-8)
    finer = api.history(case, periods=3, settled=True, sample=0.0123)["time"].values
    steps = np.diff(finer)  # the last no shorter: a spectrum needs whole periods
    assert finer[-1] == pytest.approx(3 * period, rel=1e-12)
    assert np.ptp(steps) < 1e-9 and 0.0122 < steps.mean() <= 0.0123
    assert motion.attrs["point"] == "v=1.0, c=0.0, initial=far, settled"
    assert motion.attrs["steady_state"] == "periodic"


def test_what_has_no_period_is_told_and_may_be_recorded_all_the_same() -> None:
    """With damping 2 N s/m the belt slides steadily; without `settled` the motion still decays."""
    case = api.load(BELT, overrides={"grid.c": [2.0]})
    with pytest.raises(UsageError, match="no period: its class is equilibrium"):
        api.history(case, periods=3, settled=True)
    short = {**BELT, "analysis": [{"kind": "response", "t_max": 5.0}]}
    with pytest.raises(UsageError, match=r"is undecided \(time_budget: .*raise t_max"):
        api.history(api.load(short, overrides={"grid.c": [0.0]}), periods=3)
    still, begun = (api.history(case, t_end=1.0, settled=settled) for settled in (True, False))
    assert np.ptp(still["x"].values) < 1e-3 * np.ptp(begun["x"].values)
    with pytest.raises(UsageError, match="both say where"):
        api.history(case, periods=3, t_end=1.0)


def test_in_a_case_of_a_cycle_alone_the_settled_motion_is_on_it_though_it_is_unstable() -> None:
    """Between steady sliding and stick-slip: motions beside it leave it, to either."""
    tables = {
        "schema": 1,
        "model": {"name": "belt-1dof", "parameters": {"c": 0.3, "v": 2.0}},
        "friction": {"law": "stribeck", "mu_s": 0.4, "mu_k": 0.23, "v_s": 1.0, "delta": 1.0},
        "initial": [{"label": "near", "kind": "equilibrium", "offset": {"x": 1.3}}],
        "analysis": [{"kind": "cycle", "parameter": "v", "bracket": [1.9, 2.1]}],
    }
    case = api.load(tables)
    alone = api.load({**tables, "analysis": [{"kind": "cycle"}]})
    found = api.run(alone, workers=1).squeeze()
    assert found["stable"] == STABLE.codes["unstable"]
    motion = api.history(case, periods=1, settled=True).squeeze()
    assert motion.attrs["steady_state"] == "unstable cycle"
    assert float(motion["time"][-1]) == pytest.approx(found["cycle_period"].item(), rel=1e-9)
    path = np.stack([motion["x"], motion["x_dot"]])
    np.testing.assert_allclose(path[:, -1], path[:, 0], atol=1e-6)
    assert np.ptp(path[0]) == pytest.approx(2.0 * found["x_amplitude"].item(), rel=1e-4)
