"""Claims: the verdict follows from hits, misses and open points, and says what was found."""

import itertools
import json
import math
import operator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import synthetic_datasets as data
import xarray as xr
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from synthetic_datasets import claim, tried

from fiv_cli import api
from fiv_cli.case.kinds import CLAIMS
from fiv_cli.cli.claims import Entry, case_files, command, lines
from fiv_cli.cli.main import run as fiv
from fiv_cli.errors import CaseError, UsageError
from fiv_cli.reading import select
from fiv_cli.reading.claims import (
    CONFIRMED,
    CONTRADICTED,
    HANDFUL,
    UNDETERMINED,
    evaluate,
    tally,
)
from fiv_cli.reading.datasets import is_class

MU_K = np.arange(1, 11) / 10


def sweep(classes, L_s=None, status="ok", rows=None, **given):
    """A response along mu_k = 0.1, 0.2, ..."""
    L_s = np.arange(len(classes), dtype=float) if L_s is None else L_s
    along = data.axes(mu_k=MU_K[: len(classes)])
    return data.response(classes, L_s, along, status, rows, **given)


THREE = ["periodic", "periodic", "equilibrium"]


@pytest.mark.parametrize(
    ("expect", "holds", "verdict"),
    [
        ("periodic", "all", CONTRADICTED),
        ("periodic", "any", CONFIRMED),
        ("periodic", 2 / 3, CONFIRMED),
        ("periodic", 0.7, CONTRADICTED),
        ("chaotic", "any", CONTRADICTED),
        ("not chaotic", "all", CONFIRMED),
        ("not periodic", "all", CONTRADICTED),
    ],
)
def test_classes_are_counted(expect, holds, verdict):
    assert tried(sweep(THREE), "attractor", expect, holds=holds).verdict == verdict


def test_a_finding_counts_classes_and_names_the_misses():
    verdict = tried(sweep(THREE), "attractor", "periodic")
    assert (verdict.hits, verdict.points, verdict.open) == (2, 3, 0)
    assert "2 of 3 points" in verdict.found
    assert "periodic 2, equilibrium 1" in verdict.found
    assert "not at mu_k = 0.3" in verdict.found


def test_points_that_have_no_such_value_are_told_apart_from_wrong_ones():
    between = {"between": [1, 2]}
    verdict = tried(sweep(THREE, L_s=[1.0, 2.0, np.nan]), "L_s", between)
    assert (verdict.verdict, verdict.hits, verdict.points) == (CONTRADICTED, 2, 3)
    assert "1 have none (equilibrium 1): narrow `at`" in verdict.found
    assert "have none" not in tried(sweep(THREE, L_s=[1.0, 2.0, 3.0]), "L_s", between).found


def test_many_misses_are_counted_not_listed():
    found = tried(sweep(["chaotic"] * 10), "attractor", "periodic").found
    assert found.count("mu_k =") == 3
    assert "and 7 more" in found


@pytest.mark.parametrize(
    ("kind", "status"),
    [
        *[("undecided", status) for status in ("ok", "budget")],
        *[("not_computed", status) for status in ("failed", "not_reached", "pending")],
        ("not_computed", "not_computed"),
    ],
)
def test_a_point_without_answer_leaves_the_claim_undetermined(kind, status):
    dataset = sweep(["periodic", kind], status=["ok", status])
    verdict = tried(dataset, "attractor", "periodic")
    assert verdict.verdict == UNDETERMINED
    assert verdict.open == 1
    assert "1 not decided or not computed" in verdict.found
    assert status in ("ok", "not_computed") or f"({status} 1)" in verdict.found


def test_a_finding_tells_the_one_that_is_as_expected():
    wanted = {"value": 2.0, "tolerance": 0.1}
    told = [tried(sweep(THREE, [1.0, 2.0, 3.0]), "L_s", wanted, holds=h) for h in ("any", "all")]
    assert "found 1 to 3 rad2, as expected: 2 rad2" in told[0].found
    assert "as expected" not in told[1].found


@pytest.mark.parametrize(
    ("classes", "wanted", "verdict", "points"),
    [
        (THREE, "periodic", CONFIRMED, 2),
        (THREE, ["periodic", "equilibrium"], CONTRADICTED, 3),
        (["periodic", "undecided", "equilibrium"], "periodic", UNDETERMINED, 2),
        (THREE, "chaotic", UNDETERMINED, 0),
    ],
)
@pytest.mark.parametrize("variable", ["L_s", "section_value"])
def test_a_class_narrows_a_claim_to_the_values_beside_it(
    variable, classes, wanted, verdict, points
):
    dataset = sweep(classes, [1.0, 2.0, 9.0], rows=[[1.0], [2.0], [9.0]])
    found = tried(dataset, variable, {"less_than": 5.0}, at={"attractor": wanted})
    assert (found.verdict, found.points) == (verdict, points)
    assert ("no value has attractor" in found.found) == (points == 0)


def test_a_class_of_its_own_dims_narrows_a_claim_to_those_of_its_values():
    dataset = data.crossings()
    of_roots = tried(
        dataset, "critical_value", {"greater_than": 1.55}, at={"crossing_kind": "root"}
    )
    assert (of_roots.verdict, of_roots.points) == (CONTRADICTED, 4)
    at = {"crossing_kind": "root", "R": ". >= 10"}
    assert tried(dataset, "critical_value", {"greater_than": 1.55}, at=at).verdict == CONFIRMED


def test_open_points_do_not_save_a_claim_that_others_contradict():
    dataset = sweep(["periodic", "undecided", "equilibrium"])
    assert tried(dataset, "attractor", "periodic").verdict == CONTRADICTED


def test_open_points_do_not_spoil_a_claim_that_others_confirm():
    dataset = sweep(["periodic", "undecided", "equilibrium"])
    assert tried(dataset, "attractor", "periodic", holds="any").verdict == CONFIRMED
    assert tried(dataset, "attractor", "periodic", holds=0.3).verdict == CONFIRMED


def test_undecided_can_itself_be_claimed():
    dataset = sweep(["undecided", "periodic"], status=["budget", "ok"])
    assert tried(dataset, "attractor", "undecided", {"mu_k": 0.1}).verdict == CONFIRMED
    assert tried(dataset, "attractor", "not undecided", {"mu_k": 0.1}).verdict == CONTRADICTED


def test_status_is_known_everywhere():
    dataset = sweep(["periodic", "not_computed"], status=["ok", "not_reached"])
    assert tried(dataset, "status", "not_reached", {"mu_k": 0.2}).verdict == CONFIRMED
    assert tried(dataset, "status", "ok").verdict == CONTRADICTED


@given(
    st.lists(st.sampled_from(["periodic", "equilibrium", "undecided"]), min_size=1, max_size=10),
    st.sampled_from(["all", "any", 0.25, 0.5, 0.9]),
)
def test_the_verdict_is_what_every_completion_of_the_open_points_agrees_on(classes, holds):
    """Confirmed (contradicted) exactly if it stays so however the open points turn out."""

    def outcome(completed):
        needed = {"all": 1.0, "any": 0.01}.get(holds, holds)
        share = sum(c == "periodic" for c in completed) / len(completed)
        return share >= needed - 1e-9

    best = [c.replace("undecided", "periodic") for c in classes]
    worst = [c.replace("undecided", "equilibrium") for c in classes]
    expected = {(True, True): CONFIRMED, (False, False): CONTRADICTED}.get(
        (outcome(best), outcome(worst)), UNDETERMINED
    )
    assert tried(sweep(classes), "attractor", "periodic", holds=holds).verdict == expected


def test_conditions_select_points():
    dataset = sweep(["equilibrium"] * 3 + ["periodic"] * 4 + ["chaotic"] * 3)
    verdict = tried(dataset, "attractor", "periodic", {"mu_k": "0.4 <= . < 0.8"})
    assert (verdict.verdict, verdict.points) == (CONFIRMED, 4)


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("0.3 <= . < 0.5", 2),
        ("0.3 < . <= 0.5", 2),
        (". >= 0.9", 2),
        (". < 0.3", 2),
        ("0.2 < .", 8),
        (". == 0.7", 1),
        (". != 0.7", 9),
    ],
)
def test_bounds_of_conditions_are_exact_although_axes_are_binary(text, count):
    axis = xr.DataArray(0.1 * np.arange(1, 11), dims="mu_k", name="mu_k")
    assert select.matching(axis, text, nearest=False).sum() == count


@pytest.mark.parametrize("text", [". > 1", ". <= 1", ". == 1", ". != 1"])
def test_no_condition_holds_of_what_is_not_known(text):
    assert not select.condition(text)(np.array([np.nan])).any()


@pytest.mark.parametrize("nearest", [True, False])
def test_of_axes_that_advance_together_every_place_of_a_value_is_meant(nearest):
    """And places where several values stand together; where they never do, it is an error."""
    c1, c2 = (("both", values) for values in ([0.0, 0.05, 0.05, 0.0], [0.0, 0.05, 0.0, 0.05]))
    dataset = xr.Dataset({"L_s": ("both", np.arange(4.0))}, {"c1": c1, "c2": c2})
    places = lambda **at: select.subset(dataset, at, nearest=nearest)["L_s"].values.tolist()  # noqa: E731
    assert places(c2=0.0) == places(c2=[0.0]) == [0.0, 2.0]
    assert places(c1=0.05, c2=0.0) == [2.0]
    assert places(c1=[0.05, 0.0], c2=0.05) == [1.0, 3.0]
    apart = dataset.isel(both=slice(2))
    told = r"c1, c2 = 0\.05, 0: never together in this dataset\nc1, c2: 0\.0, 0\.0; 0\.05, 0\.05"
    with pytest.raises(select.SelectionError, match=told):
        select.subset(apart, {"c1": 0.05, "c2": 0}, nearest=nearest)


@given(st.floats(0.05, 1.05), st.floats(0.05, 1.05))
def test_conditions_agree_with_comparison(low, high):
    axis = xr.DataArray(MU_K, dims="mu_k", name="mu_k")
    expected = operator.and_(low <= MU_K, high > MU_K)
    text = f"{low!r} <= . < {high!r}"
    if np.isclose(MU_K, low).any() or np.isclose(MU_K, high).any():
        return
    if expected.any():
        assert (select.matching(axis, text, nearest=False) == expected).all()
    else:
        with pytest.raises(select.SelectionError):
            select.matching(axis, text, nearest=False)


@pytest.mark.parametrize(
    ("at", "words"),
    [
        ({"mu_k": 0.15}, "mu_k = 0.15: not in this dataset"),
        ({"mu_k": "2 < . < 3"}, "not in this dataset"),
        ({"N0": 30.0}, "N0: no axis"),
        ({"initial": "far"}, "initial: no axis"),
    ],
)
def test_what_is_not_in_the_dataset_is_undetermined(at, words):
    verdict = tried(sweep(THREE), "attractor", "periodic", at)
    assert verdict.verdict == UNDETERMINED
    assert words in verdict.found
    assert "\n" not in verdict.found


def test_unknown_variables_classes_and_analyses_are_undetermined():
    assert "no variable" in tried(sweep(THREE), "speed", "periodic").found
    assert "no class of attractor" in tried(sweep(THREE), "attractor", "wobbly").found
    assert "no analysis" in tried(sweep(THREE), "attractor", "periodic", analysis="b").found
    assert tried(sweep(THREE), "L_s", "periodic").verdict == UNDETERMINED


def test_starts_are_selected_by_label_and_random_ones_by_their_stem():
    labels = ["near", "far-000", "far-001"]
    classes = np.array([["equilibrium", "periodic", "periodic"]])
    dataset = data.response(classes, np.zeros((1, 3)), data.axes(mu_k=[0.3], initial=labels))
    assert tried(dataset, "attractor", "periodic", {"initial": "far"}).points == 2
    assert tried(dataset, "attractor", "periodic", {"initial": "far"}).verdict == CONFIRMED
    assert tried(dataset, "attractor", "equilibrium", {"initial": "near"}).verdict == CONFIRMED
    assert "initial = far-000" in tried(dataset, "attractor", "equilibrium").found


@pytest.mark.parametrize(("tolerance", "verdict"), [(0.5, CONFIRMED), (0.49, CONTRADICTED)])
def test_a_value_lies_within_its_tolerance(tolerance, verdict):
    dataset = sweep(["periodic"] * 2, L_s=[2.0, 3.0])
    expect = {"value": 2.5, "tolerance": tolerance}
    assert tried(dataset, "L_s", expect).verdict == verdict


def test_values_say_their_range_and_unit():
    dataset = sweep(["periodic"] * 2, L_s=[2.0, 3.0])
    assert "found 2 to 3 rad2" in tried(dataset, "L_s", {"value": 2.5, "tolerance": 1}).found


def test_a_computed_point_without_the_value_is_a_miss():
    dataset = sweep(["periodic", "equilibrium"], L_s=[2.0, np.nan])
    assert tried(dataset, "L_s", {"value": 2.0, "tolerance": 0}).verdict == CONTRADICTED


def test_padding_along_own_dims_is_no_point():
    solutions = (("mu_k", "solution"), np.array([[1.0, np.nan], [1.0, 1.0]]), {"units": "N"})
    dataset = sweep(["periodic"] * 2, F_N=solutions)
    verdict = tried(dataset, "F_N", {"value": 1.0, "tolerance": 0})
    assert (verdict.verdict, verdict.points) == (CONFIRMED, 3)


def test_of_several_values_at_a_point_the_finding_says_how_to_take_one():
    along, values = ("mu_k", "crossing"), np.array([[5.0, np.nan], [5.0, 36.0]])
    places, errors = (along, values, {"units": "rad s-1"}), (along, values / 1e4)
    dataset = sweep(["periodic"] * 2, boundary=places, boundary_error=errors)
    asked = {"value": 5.0, "tolerance": 0.1}
    verdict = tried(dataset, "boundary", asked)
    assert verdict.verdict == CONTRADICTED
    assert "found 5.00000 ± 0.00050 to 36.0000 ± 0.0036 rad s-1" in verdict.found
    assert verdict.found.endswith("at = { crossing = 0 } takes the first")
    assert tried(dataset, "boundary", asked, {"crossing": 0}).verdict == CONFIRMED
    assert "crossing" not in tried(dataset.isel(mu_k=[0]), "boundary", {"less_than": 4}).found
    counted = dataset.assign(n_crossings=("mu_k", np.array([1, 2]), {"units": "1"}))
    verdict = tried(counted, "boundary", "increasing", {"crossing": 1})
    assert verdict.verdict == UNDETERMINED
    assert verdict.found.endswith("1 of 2 have no crossing 1 (n_crossings)")


def flags(reasons):
    return data.flags(("mu_k",), reasons, ("none", "time_budget"))


def boundary(values, errors):
    """Changes that may be off, of a sweep along mu_k; inf: how far is not known."""
    named = {"units": "N"}
    errors = np.where(np.isinf(errors), np.nan, errors)
    found = {"boundary": ("mu_k", np.array(values), named)}
    return sweep(["periodic"] * len(values), **found, boundary_error=("mu_k", errors, named))


LEAST, MEAN, SPREAD = ({"what": what, "over": ["mu_k"]} for what in ("least", "mean", "spread"))
SHARE, ENTRIES = ({**LEAST, "what": what, "of": ". > 2"} for what in ("share", "entries"))


@settings(max_examples=30)
@given(
    st.tuples(*[st.tuples(st.integers(1, 4), st.sampled_from([0, 1]))] * 2),
    st.sampled_from([{"less_than": 2.5}, {"between": [2, 3]}, "increasing"]),
    st.sampled_from([None, LEAST, MEAN, SPREAD, SHARE, ENTRIES]),
)
def test_of_values_that_may_be_off_a_verdict_holds_wherever_they_lie(pairs, expect, take):
    """It is what all values within the errors agree on; a take may know less."""
    take = None if expect == "increasing" else take
    values, errors = zip(*pairs, strict=True)
    told = tried(boundary(values, errors), "boundary", expect, take=take).verdict
    may_be = itertools.product(*(np.linspace(v - e, v + e, 4 * e + 1) for v, e in pairs))
    exact = {tried(boundary(v, [0, 0]), "boundary", expect, take=take).verdict for v in may_be}
    assert {told} == exact or told == UNDETERMINED
    assert take or {told} == exact or len(exact) > 1


@pytest.mark.parametrize(
    ("what", "errors", "verdict"),
    [
        ("least", [0.01, 5.0], CONFIRMED),
        ("least", [0.01, 9.5], UNDETERMINED),
        ("greatest", [8.5, 0.01], CONFIRMED),
    ],
)
def test_what_is_least_may_be_off_by_its_own_error(what, errors, verdict):
    """Or by that of another that may be less."""
    expect = {"value": {"least": 1.0, "greatest": 10.0}[what], "tolerance": 0.02}
    found = boundary([1.0, 10.0], errors)
    assert tried(found, "boundary", expect, take={**LEAST, "what": what}).verdict == verdict


def test_a_place_along_one_axis_is_held_against_the_values_of_another():
    """L_s has its peak where Omega is N0, but for the last N0, whose peak is at the first Omega."""
    speeds = preloads = np.array([1.0, 2.0, 3.0, 4.0])
    size = -np.abs(speeds[:, None] - preloads)
    size[0, -1] = 1.0
    axes = data.axes(Omega=speeds, N0=preloads)
    points = data.response(np.full((4, 4), "periodic", object), size, axes)
    peak = {"what": "peak", "over": ["Omega"]}
    equal = {"value": "N0", "tolerance": 1e-9}
    told = data.tried(points, "L_s", equal, take=peak)
    assert (told.verdict, told.hits, told.points) == (CONTRADICTED, 3, 4)
    assert "not at N0 = 4" in told.found


def test_what_is_not_known_well_enough_says_what_lessens_the_error():
    told = '{"b": {"settings": {"%s": 1}}}'
    near = boundary([5.9], [0.2]).assign_attrs(analyses_json=told % "width")
    found = tried(near, "boundary", {"less_than": 6}).found
    assert "found 5.90 ± 0.20 N, 1 not known well enough: the error reaches past" in found
    assert found.endswith("a smaller `width` of the analysis 'b' lessens it")
    wide = near.assign(n_undecided=3, boundary_width=("mu_k", [0.4]))
    of_runs = '{"b": {"settings": {"width": 0.01, "bracket": [4, 8]}}}'
    found = tried(wide.assign_attrs(analyses_json=of_runs), "boundary", {"less_than": 6}).found
    assert found.endswith(
        "where an equilibrium loses its stability, an analysis `critical` finds it, and where a "
        "cycle ends, `cycle` with `parameter`; "
        "runs beside it are undecided: a larger `t_max`, else a smaller `solver.rtol` of the "
        "analysis 'b' lessens it"
    )
    why = data.flags(("mu_k",), ["cycle_not_confirmed"], ["none", "cycle_not_confirmed"])
    unsure = wide.assign(undecided_reason=why).assign_attrs(analyses_json=of_runs)
    found = tried(unsure, "boundary", {"less_than": 6}).found
    assert "undecided (cycle_not_confirmed): a smaller `solver.rtol`" in found
    critical = near.assign_attrs(analyses_json=told % "system")
    assert "no setting" in tried(critical, "boundary", {"less_than": 6}).found
    assert (
        "5.9 ± unknown N" in tried(boundary([5.9], [math.inf]), "boundary", {"less_than": 6}).found
    )


def test_a_bound_by_another_case_may_be_off_too():
    below = {"less_than": "upper:boundary"}
    for error, verdict in ((0.05, CONFIRMED), (0.2, UNDETERMINED), (math.inf, UNDETERMINED)):
        upper = {"": boundary([6.0], [error])}
        known = boundary([5.9], [0.01])
        assert tried(known, "boundary", below, other=lambda case, u=upper: u).verdict == verdict


def test_of_undecided_points_alone_the_finding_says_what_takes_their_numbers():
    reasons = flags(["time_budget", "none"])
    dataset = sweep(["undecided", "not_computed"], status=["ok", "pending"], reason=reasons)
    found = tried(dataset, "L_s", {"less_than": 4}).found
    assert "2 not decided or not computed (time_budget 1, pending 1)" in found
    assert 'fiv show says what helps; undecided = "counts"' in found


def test_integers_that_were_not_computed_are_no_numbers():
    counts = (("mu_k",), np.array([2, -2147483647], np.int32), {"units": "1"})
    dataset = sweep(["periodic", "equilibrium"], multiplicity=counts)
    verdict = tried(dataset, "multiplicity", {"value": 2, "tolerance": 0})
    assert verdict.verdict == CONTRADICTED
    assert "found 2," in verdict.found


@pytest.mark.parametrize(
    ("expect", "verdict"),
    [
        ({"between": [1, 4]}, CONFIRMED),
        ({"between": [1.1, 4]}, CONTRADICTED),
        ({"between": [1, 3.9]}, CONTRADICTED),
        ({"less_than": 4.1}, CONFIRMED),
        ({"less_than": 4}, CONTRADICTED),
        ({"greater_than": 0.9}, CONFIRMED),
        ({"greater_than": 1}, CONTRADICTED),
    ],
)
def test_bounds_of_between_are_included_and_the_others_are_not(expect, verdict):
    assert tried(sweep(["periodic"] * 3, L_s=[2.0, 1.0, 4.0]), "L_s", expect).verdict == verdict


PERIODIC = ["equilibrium"] * 3 + ["periodic"] * 4 + ["equilibrium"] * 3


def where(what, of="periodic"):
    return {"what": what, "of": of, "over": ["mu_k"]}


@pytest.mark.parametrize(
    ("take", "value"),
    [
        (where("first"), 0.4),
        (where("last"), 0.7),
        (where("first", "not periodic"), 0.1),
        (where("last", "not periodic"), 1.0),
    ],
)
def test_where_a_class_begins_and_ends_along_the_axis(take, value):
    """Between there and the next value of the axis, or beyond its end."""
    onward = 0.1 if take["what"] == "last" else -0.1
    at_end = value in (0.1, 1.0)
    beyond = "greater_than" if onward > 0.0 else "less_than"
    within = sorted((value, value + onward))
    for expect, verdict in (
        ({beyond: value - 0.01 * onward}, CONFIRMED),
        ({"between": within}, UNDETERMINED if at_end else CONFIRMED),
        ({"value": value, "tolerance": 0.01}, UNDETERMINED),
        ({"value": value + 0.5 * onward, "tolerance": 0.01}, UNDETERMINED),
        ({"value": value - 0.5 * onward, "tolerance": 0.01}, CONTRADICTED),
    ):
        found = tried(sweep(PERIODIC), "attractor", expect, take=take)
        assert (found.verdict, expect) == (verdict, expect)
        between = "1 may lie anywhere up to the value of the axis before it" in found.found
        steps = "mu_k goes in steps of 0.1: a `boundary` finds what lies between" in found.found
        assert (between, steps) == (verdict == UNDETERMINED, verdict != CONFIRMED)
        assert f"found {value:g}" + " (an end of the axis)" * at_end in found.found


def test_a_place_that_there_is_not_is_no_border():
    expect, take = {"value": 0.5, "tolerance": 0.1}, where("last", "diverged")
    found = tried(sweep(PERIODIC), "attractor", expect, take=take)
    assert found.verdict == CONTRADICTED and "boundary" not in found.found


@pytest.mark.parametrize(
    ("place", "verdict"), [(1, UNDETERMINED), (3, UNDETERMINED), (4, CONFIRMED), (9, CONFIRMED)]
)
def test_an_undecided_point_matters_only_where_it_could_come_first(place, verdict):
    """Periodic from 0.4 to 0.7: from there on it cannot matter, before or there it can."""
    classes = [*PERIODIC]
    classes[place] = "undecided"
    expect = {"between": [0.3, 0.4]}
    assert tried(sweep(classes), "attractor", expect, take=where("first")).verdict == verdict


@pytest.mark.parametrize(
    ("labels", "error"),
    [("many", 0.25), ("listed", None), ("many listed", None)],
)
def test_a_share_of_random_starts_has_a_standard_error(labels, error):
    """Of 4 starts, p = 1/2; of starts that were chosen there is none."""
    named = [f"{(labels.split() * 4)[i]}-{i:03d}" for i in range(4)]
    classes = ["periodic", "equilibrium"] * 2
    dataset = data.response(classes, np.zeros(4), data.axes(initial=named))
    take = {"what": "share", "of": "periodic", "over": ["initial"]}
    said = claim("attractor", {"between": [0.4, 0.6]}, take=take)
    verdict = evaluate(said, {"": dataset}, lambda case: None, {"many"})
    assert verdict.verdict == CONFIRMED
    assert verdict.standard_error == error
    assert ("standard error 0.25" in verdict.found) == (error is not None)
    assert ("more starts tell" in verdict.found) == (error is not None)
    some = replace(said, expect=claim("attractor", {"greater_than": 0.0}, take=take).expect)
    one = data.response([*classes[:1], *["equilibrium"] * 3], np.zeros(4), data.axes(initial=named))
    assert "more starts tell" not in evaluate(some, {"": one}, lambda _: None, {"many"}).found
    sure = replace(said, expect=claim("attractor", {"less_than": 1.5}, take=take).expect)
    assert "more starts tell" not in evaluate(sure, {"": dataset}, lambda _: None, {"many"}).found


@pytest.mark.parametrize(
    ("said", "named"),
    [
        ("period", "against period: 2"),
        (
            {"variable": "period", "at": {"initial": "b"}},
            'against { variable = "period", at = { initial = "b" } }: 2',
        ),
    ],
)
def test_what_is_compared_with_is_told_whole(said, named):
    dataset = data.response(["periodic"] * 2, [2.0, 2.0], data.axes(initial=["a", "b"]))
    dataset["period"] = dataset["L_s"].copy()
    assert named in tried(dataset, "L_s", {"value": said, "tolerance": 0.1}).found


@pytest.mark.parametrize("told", [CLAIMS, command.help])
def test_what_is_said_of_open_points_is_the_rule(told):
    """A share that may be open, without a claim that is undetermined."""
    words = " ".join(told.split())
    assert f"no more than {HANDFUL * 100:g} % of those it is tried on" in words
    assert "the rest decides, whatever they might hold" in words


def test_what_occurs_nowhere_begins_nowhere():
    expect = {"value": 0.4, "tolerance": 0.01}
    never, perhaps = (sweep([*["equilibrium"] * 3, last]) for last in ("chaotic", "undecided"))
    found = tried(never, "attractor", expect, take=where("first"))
    assert (found.verdict, found.hits) == (CONTRADICTED, 0)
    assert tried(perhaps, "attractor", expect, take=where("first")).verdict == UNDETERMINED


def test_section_values_are_claimed_row_by_row():
    rows = [[1.0, 2.0], [], [3.0]]
    dataset = sweep(["periodic", "equilibrium", "undecided"], rows=rows)
    known = tried(dataset, "section_value", {"value": 1.5, "tolerance": 0.5}, {"mu_k": ". < 0.3"})
    assert (known.verdict, known.points) == (CONFIRMED, 2)
    every = tried(dataset, "section_value", {"value": 1.5, "tolerance": 0.5})
    assert (every.verdict, every.points, every.open) == (UNDETERMINED, 3, 1)


def test_what_was_measured_of_undecided_points_counts_where_a_claim_says_so():
    dataset = sweep(["periodic", "undecided"], L_s=[1.0, 2.0])
    said = claim("L_s", {"between": [0.5, 2.5]})
    counted = replace(said, undecided_counts=True)
    verdicts = [evaluate(one, {"": dataset}, lambda case: None) for one in (said, counted)]
    assert [(v.verdict, v.hits) for v in verdicts] == [(UNDETERMINED, 1), (CONFIRMED, 2)]
    classes = replace(claim("attractor", "periodic"), undecided_counts=True)
    assert evaluate(classes, {"": dataset}, lambda case: None).verdict == UNDETERMINED


def test_no_values_at_all_is_undetermined():
    dataset = sweep(["equilibrium"], rows=[[]])
    expect = {"value": 1.5, "tolerance": 0.5}
    assert tried(dataset, "section_value", expect).verdict == UNDETERMINED


@pytest.mark.parametrize(
    ("L_s", "expect", "verdict"),
    [
        ([1, 2, 4, 8], "increasing", CONFIRMED),
        ([1, 2, 4, 8], "decreasing", CONTRADICTED),
        ([8, 4, 2, 1], "decreasing", CONFIRMED),
        ([1, 2, 2, 8], "increasing", CONTRADICTED),
    ],
)
def test_trends_are_judged_step_by_step(L_s, expect, verdict):
    assert tried(sweep(["periodic"] * 4, L_s=L_s), "L_s", expect).verdict == verdict


def test_a_trend_names_its_wrong_steps_and_may_hold_for_a_share_of_them():
    dataset = sweep(["periodic"] * 4, L_s=[1, 2, 1.5, 8])
    verdict = tried(dataset, "L_s", "increasing")
    assert "2 of 3 steps" in verdict.found
    assert "not at mu_k = 0.2 to 0.3" in verdict.found
    assert tried(dataset, "L_s", "increasing", holds=0.6).verdict == CONFIRMED


def test_a_trend_of_shares_tells_of_wrong_steps_that_their_errors_may_hide():
    """A step up by less than two standard errors, and one of none, were told as any other."""
    named = [f"many-{i:03d}" for i in range(8)]
    counts = [8, 5, 6, 0, 0]
    classes = [["periodic"] * n + ["equilibrium"] * (8 - n) for n in counts]
    axes = data.axes(mu_k=np.arange(5.0), initial=named)
    dataset = data.response(np.array(classes, object), np.zeros((5, 8)), axes)
    take = {"what": "share", "of": "periodic", "over": ["initial"]}
    said = claim("attractor", "decreasing", take=take)
    verdict = evaluate(said, {"": dataset}, lambda case: None, {"many"})
    assert verdict.verdict == CONTRADICTED
    assert "1 the other way by less than two of these, 1 of none" in verdict.found


def test_steps_to_and_from_an_open_point_are_open():
    dataset = sweep(["periodic", "undecided", "periodic", "periodic"], L_s=[1, 9, 3, 4])
    verdict = tried(dataset, "L_s", "increasing")
    assert (verdict.verdict, verdict.hits, verdict.open) == (UNDETERMINED, 1, 2)


def test_a_trend_needs_one_axis():
    dataset = data.stability_map()
    narrowed = {"N0": 50.0, "initial": "exists", "Omega": ". < 5"}
    assert "one numeric axis" in tried(dataset, "L_s", "increasing").found
    assert tried(dataset, "L_s", "increasing", narrowed).verdict == CONFIRMED
    ragged = sweep(["periodic"] * 3, rows=[[1.0], [2.0], [3.0]])
    assert "not one value per point" in tried(ragged, "section_value", "increasing").found


def test_less_than_compares_with_the_same_points_of_another_case():
    lower, upper = sweep(["periodic"] * 3, L_s=[1, 2, 3]), sweep(["periodic"] * 3, L_s=[2, 3, 4])
    stored = {"upper": {"": upper}, "lower": {"": lower}}.get
    below = {"less_than": "upper:L_s"}
    assert tried(lower, "L_s", below, other=stored).verdict == CONFIRMED
    assert tried(upper, "L_s", {"less_than": "lower:L_s"}, other=stored).verdict == CONTRADICTED


def test_less_than_leaves_points_that_the_other_case_lacks_open():
    this = sweep(["periodic"] * 3, L_s=[1, 2, 3])
    shorter = sweep(["periodic"] * 2, L_s=[2, 3])
    undecided = sweep(["periodic", "periodic", "undecided"], L_s=[2, 3, 4])
    for other in (shorter, undecided):
        verdict = tried(this, "L_s", {"less_than": "b:L_s"}, other=lambda c, o=other: {"": o})
        assert (verdict.verdict, verdict.open) == (UNDETERMINED, 1)
        assert "(1 in what it is compared with)" in verdict.found


def test_less_than_matches_axes_by_value_and_single_starts_by_default():
    this = sweep(["periodic"] * 3, L_s=[1, 2, 3])
    grid = data.axes(mu_k=MU_K[2::-1] * (1 + 1e-15), initial=["rest"])
    other = data.response([["periodic"]] * 3, [[4], [3], [2]], grid)
    verdict = tried(this, "L_s", {"less_than": "b:L_s"}, other=lambda case: {"": other})
    assert verdict.verdict == CONFIRMED


def test_less_than_refuses_an_axis_of_the_other_case_only():
    this, other = sweep(["periodic"] * 3), data.stability_map()
    verdict = tried(this, "L_s", {"less_than": "b:L_s"}, other=lambda case: {"": other})
    assert verdict.verdict == UNDETERMINED
    assert "narrow it to one in its `at`" in verdict.found


def own(**said):
    """What stands elsewhere in the same case."""
    return {"variable": "L_s", **said}


@pytest.mark.parametrize(
    ("at", "expect", "verdict"),
    [
        ({"mu_k": 0.3}, {"less_than": own(at={"mu_k": 0.1})}, CONTRADICTED),
        ({"mu_k": 0.3}, {"greater_than": own(at={"mu_k": 0.1}, times=2.9)}, CONFIRMED),
        ({"mu_k": 0.3}, {"greater_than": own(at={"mu_k": 0.1}, times=3)}, CONTRADICTED),
        ({"mu_k": [0.2, 0.3]}, {"greater_than": own(at={"mu_k": 0.1})}, CONFIRMED),
        ({"mu_k": 0.3}, {"greater_than": own(at={"mu_k": 0.4})}, UNDETERMINED),
        ({"mu_k": 0.3}, {"greater_than": own(at={"mu_k": [0.1, 0.2]})}, UNDETERMINED),
        ({}, {"value": own(variable="other", analysis="b"), "tolerance": "10 %"}, CONFIRMED),
        ({}, {"value": own(variable="other"), "tolerance": "9 %"}, CONTRADICTED),
        ({}, {"value": own(variable="other"), "tolerance": 0.1}, CONTRADICTED),
        ({}, {"value": own(variable="other"), "tolerance": 0.31}, CONFIRMED),
    ],
)
def test_a_case_compares_its_slices_and_its_analyses(at, expect, verdict):
    """L_s is 1, 2, 3 and undecided; another analysis has a tenth more of it."""
    classes = ["periodic"] * 3 + ["undecided"]
    this = sweep(classes, L_s=[1, 2, 3, 4])
    that = sweep(classes, L_s=[1.1, 2.2, 3.3, 4.4]).rename(L_s="other")
    at = at or {"mu_k": ". < 0.35"}
    found = evaluate(claim("L_s", expect, at), {"a": this, "b": that}, None)
    assert found.verdict == verdict, found


def test_of_axes_that_advance_together_either_says_where():
    along = {**data.axes(mu_k=[0.1, 0.2]), "N0": ("mu_k", [10.0, 20.0])}
    dataset = data.response(["periodic"] * 2, [1, 2], {"mu_k": along["mu_k"]})
    dataset = dataset.assign_coords(N0=along["N0"])
    above = {"greater_than": own(at={"N0": 10.0}, times=1.9)}
    assert tried(dataset, "L_s", above, {"mu_k": 0.2}).verdict == CONFIRMED


def test_the_same_is_taken_of_both_sides():
    greatest = {"what": "greatest", "over": ["Omega"]}
    grid = data.axes(mu_k=[0.1, 0.2], Omega=[1.0, 2.0])
    dataset = data.response([["periodic"] * 2] * 2, [[1, 2], [0, 3]], grid)
    for times, verdict in ((1.6, CONFIRMED), (1.5, CONTRADICTED)):
        below = {"less_than": own(at={"mu_k": 0.1}, take=greatest, times=times)}
        assert tried(dataset, "L_s", below, {"mu_k": 0.2}, take=greatest).verdict == verdict


def test_the_first_analysis_with_the_variable_is_meant():
    analyses = {"a": data.eigenvalues(), "b": sweep(THREE)}
    spec = claim("attractor", "equilibrium", {"mu_k": 0.3})
    assert evaluate(spec, analyses, None).verdict == CONFIRMED


def test_a_claim_may_name_the_only_analysis():
    """A file of one analysis does not say its name; its attributes do."""
    dataset = sweep(THREE).assign_attrs(analyses_json='{"response": {}}')
    verdict = tried(dataset, "attractor", "equilibrium", {"mu_k": 0.3}, analysis="response")
    assert verdict.verdict == CONFIRMED


def test_tally_counts_every_verdict():
    assert tally([CONFIRMED, "not run", CONFIRMED]) == "2 confirmed, 1 not run"
    assert tally([]) == "no claims"


CASE = """
schema = 1
title = "Stick-slip"

[model]
name = "belt-1dof"

[grid]
mu_k = [0.1, 0.2, 0.3]

[[analysis]]
kind = "response"

[[claim]]
source = "3.1.1"
text = "the mass sticks and slips"
variable = "attractor"
expect = "periodic"
"""


@pytest.fixture
def workplace(tmp_path, monkeypatch):
    """A folder with a case; `store` writes its dataset."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "stick.toml").write_text(CASE)
    (tmp_path / "runs").mkdir()
    return tmp_path


def store(classes, case="stick.toml", overrides=()):
    from fiv_cli.case.identity import default_output, fingerprint
    from fiv_cli.case.load import load_case

    loaded = load_case(case, overrides)
    told = {"kind": "response", "settings": {}}
    analyses = json.dumps({spec.name: told for spec in loaded.analyses})
    found = {"fingerprint": fingerprint(loaded), "analyses_json": analyses}
    dataset = sweep(classes).assign_attrs(found)
    dataset.to_netcdf(default_output(loaded))


def run(*arguments):
    return CliRunner().invoke(command, [str(argument) for argument in arguments])


def test_a_case_that_was_not_run_names_its_command(workplace):
    result = run("stick.toml")
    assert result.exit_code == 0
    assert "not run" in result.output
    assert "fiv run stick.toml" in result.output


def test_a_dataset_of_the_case_under_another_name_is_named(workplace):
    store(["periodic"] * 3)
    (workplace / "runs" / "stick.nc").rename(workplace / "runs" / "mine.nc")
    command = "fiv claims stick.toml -o runs/mine.nc"
    assert f"runs/mine.nc is of this case: {command}" in run("stick.toml").output
    store(["periodic"] * 3, overrides=["model.parameters.N=12.0"])
    changed = workplace / "runs" / "stick.nc"
    next(path for path in (workplace / "runs").glob("stick*.nc")).rename(changed)
    assert command in run("stick.toml").output


def test_a_motion_or_another_grid_is_not_offered_as_the_dataset_of_a_case(workplace):
    """Only what would be accepted; what was run with --set says so."""
    store(["periodic"] * 3)
    runs, usual = workplace / "runs", "runs/stick.nc is of this case"
    sweep_of = xr.load_dataset(runs / "stick.nc")
    sweep_of.assign_attrs(point="mu_k=0.2").to_netcdf(runs / "motion.nc")
    told = run("stick.toml", "-o", "runs/motion.nc").output
    assert "runs/motion.nc holds the motion at mu_k=0.2, and no sweep; " + usual in told
    sweep_of.isel(mu_k=[0]).to_netcdf(runs / "few.nc")
    assert usual in run("stick.toml", "-o", "runs/none.nc").output
    (runs / "stick.nc").unlink()
    assert "is of this case" not in run("stick.toml").output
    store(["periodic"] * 3, overrides=["model.parameters.N=12.0"])
    (other,) = runs.glob("stick-*.nc")
    changed = xr.load_dataset(other).assign_attrs(overrides="model.parameters.N=12.0")
    changed.to_netcdf(runs / "heavy.nc")
    told = run("stick.toml", "-o", "runs/heavy.nc").output
    command = "fiv claims stick.toml --set model.parameters.N=12.0 -o runs/heavy.nc"
    assert f"another version of the case; it is of: {command}" in told


def test_a_case_with_another_analysis_since_is_run_again_and_not_anew(workplace):
    store(["equilibrium"] * 3)
    (workplace / "stick.toml").write_text(CASE + '[[analysis]]\nkind = "equilibrium"\n')
    told = run("stick.toml").output
    assert "before an analysis was added; compute it with: fiv run stick.toml\n" in told


def test_a_changed_case_is_held_against_its_own_dataset(workplace):
    change = ("--set", "model.parameters.c=0.1")
    store(["equilibrium"] * 3)
    assert "fiv run stick.toml --set model.parameters.c=0.1" in run("stick.toml", *change).output
    store(["periodic"] * 3, overrides=change[1:])
    assert "1 confirmed" in run("stick.toml", *change).output
    assert "1 contradicted" in run("stick.toml").output


def test_the_ledger_tells_source_text_verdict_and_finding(workplace):
    store(["periodic"] * 3)
    result = run(workplace)
    assert "confirmed    3.1.1: the mass sticks and slips" in result.output
    assert "3 of 3 points" in result.output
    assert result.output.endswith("1 confirmed\n")


def test_a_case_may_claim_where_a_class_occurs(workplace):
    take = 'take = { what = "first", of = "periodic", over = "mu_k" }'
    expect = f"expect = {{ between = [0.1, 0.2] }}\n{take}"
    (workplace / "stick.toml").write_text(CASE.replace('expect = "periodic"', expect))
    store(["equilibrium", "periodic", "periodic"])
    assert "confirmed" in run("stick.toml").output


def test_what_is_taken_of_another_case_is_taken_over_its_own_axes(workplace, capsys):
    damped = CASE.replace('"belt-1dof"', '"belt-1dof"\nparameters = { c = 0.1 }')
    plain, claim = damped.split("[[claim]]")
    start = '[[initial]]\nlabel = "at"\nkind = "state"\n'
    lattice = plain.replace("0.3]\n", f'0.3]\n"initial.x" = [0.0, 1.0]\n\n{start}')
    (workplace / "lattice.toml").write_text(lattice)
    share = 'take = { what = "share", of = "periodic", over = "%s" }'
    there = f'{{ case = "lattice", {share % "initial.x"} }}'
    claim = claim.replace('"periodic"', f"{{ value = {there}, tolerance = 1e-9 }}")
    (workplace / "stick.toml").write_text(f"{plain}[[claim]]{claim}{share % 'initial'}\n")
    for case in ("lattice.toml", "stick.toml"):
        assert fiv(["run", case, "-q"]) == 0
    assert fiv(["check", "stick.toml"]) == 0
    shares = [
        is_class(api.read(f"runs/{case}.nc")["attractor"], ("periodic",)).mean(over)
        for case, over in (("stick", ["initial"]), ("lattice", ["initial", "initial_x"]))
    ]
    alike = int((abs(shares[0] - shares[1]) < 1e-9).sum())
    assert 0 < alike < 3 and f"{alike} of 3 points" in run("stick.toml").output


def test_the_ledger_as_json(workplace):
    store(["periodic"] * 3)
    document = json.loads(run("stick.toml", "--json").output)
    assert document["schema"] == 1
    assert document["claims"][0]["verdict"] == CONFIRMED


@pytest.mark.parametrize(
    ("classes", "code"), [(["periodic"] * 3, 0), (["undecided"] * 3, 0), (["equilibrium"] * 3, 5)]
)
def test_strict_fails_on_a_contradiction(workplace, classes, code):
    store(classes)
    assert exit_code(run("stick.toml", "--strict")) == code
    assert exit_code(run("stick.toml")) == 0


def test_strict_fails_on_what_was_not_run(workplace):
    assert exit_code(run("stick.toml", "--strict")) == 5


def test_strict_lets_a_contradiction_pass_that_a_note_explains(workplace):
    (workplace / "stick.toml").write_text(CASE + 'note = "the literal law"\n')
    store(["equilibrium"] * 3)
    result = run("stick.toml", "--strict")
    assert exit_code(result) == 0
    assert "note: the literal law" in result.output


def test_a_dataset_of_another_version_of_the_case_counts_for_nothing(workplace):
    store(["periodic"] * 3)
    (workplace / "stick.toml").write_text(CASE.replace('"belt-1dof"', '"pin-on-disc"'))
    result = run("stick.toml")
    assert "not run" in result.output
    assert "another version" in result.output


def test_claims_are_held_against_the_dataset_that_a_run_was_told_to_write(workplace):
    store(["periodic"] * 3)
    (workplace / "runs" / "stick.nc").rename(workplace / "mine.nc")
    assert "fiv claims stick.toml -o mine.nc" in run("stick.toml", "-o", "other.nc").output
    assert "fiv run stick.toml -o runs/a.nc" in run("stick.toml", "-o", "runs/a.nc").output
    result = run("stick.toml", "-o", "mine.nc", "--strict")
    assert exit_code(result) == 0
    assert "not run" not in result.output
    assert exit_code(run("stick.toml", "stick.toml", "-o", "mine.nc")) == 2


def test_a_dataset_of_another_grid_counts_for_nothing(workplace):
    store(["periodic"] * 3)
    (workplace / "stick.toml").write_text(CASE.replace("0.3]", "0.3, 0.4]"))
    result = run("stick.toml")
    assert "not run" in result.output
    assert "another grid" in result.output


def test_an_analysis_without_starts_has_not_the_axes_of_these(tmp_path, monkeypatch):
    """A lattice of starts beside the equilibria of the case is no other grid."""
    monkeypatch.chdir(tmp_path)
    kinds = "".join(f'[[analysis]]\nkind = "{kind}"\n' for kind in ("response", "equilibrium"))
    lattice = '[grid]\n"initial.x" = [0.0, 1.0]\n[[initial]]\nkind = "state"\n'
    told = '[[claim]]\nsource = "a"\ntext = "b"\nvariable = "attractor"\nexpect = "periodic"\n'
    case = f'schema = 1\n[model]\nname = "belt-1dof"\n{lattice}{kinds}{told}'
    Path("lattice.toml").write_text(case)
    assert fiv(["run", "lattice.toml", "--workers", "1", "-q"]) == 0
    assert "1 confirmed" in run("lattice.toml").output
    Path("lattice.toml").write_text(case.replace("[0.0, 1.0]", "[0.0, 2.0]"))
    assert "another grid" in run("lattice.toml").output


def exit_code(result):
    """The code that the exception carries to the shell."""
    return getattr(result.exception, "exit_code", result.exit_code)


def test_folders_stand_for_the_cases_in_them(tmp_path):
    for folder in ("ch3", "runs/b.run"):
        (tmp_path / folder).mkdir(parents=True)
    for name in ("b.toml", "ch3/a.toml", "notes.md", "runs/b.run/case.toml"):
        (tmp_path / name).write_text("schema = 1")
    (tmp_path / "tolerances.toml").write_text("L_s = 1e-9")
    (tmp_path / "broken.toml").write_text("schema = ")
    assert [p.name for p in case_files([tmp_path])] == ["b.toml", "broken.toml", "a.toml"]
    with pytest.raises(UsageError, match="no such file"):
        case_files([tmp_path / "missing"])
    with pytest.raises(UsageError, match="no case files"):
        empty = tmp_path / "empty"
        empty.mkdir()
        case_files([empty])


def test_a_case_that_is_no_toml_is_told_where(tmp_path):
    (tmp_path / "twice.toml").write_text("schema = 1\n[grid]\nv = [1]\n[grid]\n")
    with pytest.raises(CaseError, match="invalid TOML"):
        CliRunner().invoke(command, [str(tmp_path / "twice.toml")], catch_exceptions=False)


def test_the_ledger_groups_by_case():
    entries = [Entry(c, "3.1", "x", CONFIRMED, "found", "") for c in ("a", "b", "a")]
    printed = lines(entries)
    assert printed[0] == "a"
    assert printed.count("a") == printed.count("b") == 1


def test_from_python_the_verdicts_are_those_of_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("belt.toml").write_text(
        'schema = 1\nmodel.name = "belt-1dof"\ngrid.v = [0.5, 3.0]\n'
        'analysis = [{kind = "response"}]\n'
        '[[claim]]\nsource = "a"\ntext = "b"\nvariable = "attractor"\nexpect = "periodic"\n'
        '[[claim]]\nsource = "a"\ntext = "c"\nvariable = "period"\nexpect = { less_than = 100 }\n'
    )
    case = api.load("belt.toml")
    assert {verdict.verdict for verdict in api.claims(case)} == {"not run"}
    found = api.run(case, output="runs/belt.nc", workers=1)
    ledger = json.loads(run("belt.toml", "--json").stdout)["claims"]
    told = [(entry["verdict"], entry["found"]) for entry in ledger]
    for source in (None, found, "runs/belt.nc"):
        assert [(v.verdict, v.found) for v in api.claims(case, source)] == told
