"""Where an answer changes along a line: every change, to its width, and nothing guessed."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from math import atan2, exp, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fiv_cli import api
from fiv_cli.analyses.attractor.bisection import (
    MOST_LOOKS,
    Change,
    Edge,
    Found,
    Look,
    confirmed_within,
    followed,
    hysteresis,
    scanned,
)
from fiv_cli.analyses.attractor.scan import answered, going_on
from fiv_cli.analyses.base import Outcome, Question, SolverSettings, Start, Varied
from fiv_cli.api import analyse, claims, run
from fiv_cli.case.load import parse_case
from fiv_cli.data.netcdf import read_datasets
from fiv_cli.errors import CaseError
from fiv_cli.flags import RANGE_END
from fiv_cli.reading.scans import BEYOND
from fiv_cli.reading.summary import lines, summarise
from fiv_cli.sweep.plan import make_plan
from fiv_cli.sweep.policy import Policy
from fiv_cli.sweep.progress import Silent
from fiv_cli.sweep.run import run_case

WIDTH = 1e-6


def steps(*places: float) -> Callable[[float, Look | None], Look]:
    """Looks whose answer alternates at each of the places."""

    def look(value: float, origin: Look | None) -> Look:
        count = sum(value > place for place in places)
        return Look(value, count % 2 == 1, f"{count}")

    return look


def holds(change: Change, place: float) -> bool:
    """Whether a change encloses a place between two decided looks."""
    return change.decided and change.low.value <= place <= change.high.value


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(0.01, 0.99), max_size=4, unique=True))
def test_every_change_that_the_scan_can_tell_is_found(places: list[float]) -> None:
    values = np.linspace(0.0, 1.0, 12).tolist()
    found = scanned(values, steps(*places), WIDTH)
    counts = np.histogram(places, values)[0]
    odd = [i for i, count in enumerate(counts) if count % 2]
    assert len(found.changes) == len(odd)
    for change, cell in zip(found.changes, odd, strict=True):
        assert any(holds(change, place) for place in places)
        assert values[cell] <= change.low.value < change.high.value <= values[cell + 1]
        assert change.width <= WIDTH
        assert change.low.label != change.high.label


def test_the_classes_are_those_on_the_two_sides() -> None:
    (change,) = scanned([0.0, 0.5, 1.0], steps(0.3), WIDTH).changes
    assert (change.low.label, change.high.label) == ("0", "1")
    assert (change.low.answer, change.high.answer) == (False, True)
    assert change.middle == pytest.approx(0.3, abs=WIDTH)


def half_open(begin: float, end: float) -> Callable[[float, Look | None], Look]:
    """No below `begin`, open up to `end`, yes above."""

    def look(value: float, origin: Look | None) -> Look:
        inside = begin <= value <= end
        return Look(value, None if inside else value > end, "undecided" if inside else "decided")

    return look


@pytest.mark.parametrize(("begin", "end"), [(0.41, 0.44), (0.2, 0.8), (0.499, 0.501)])
def test_a_change_is_as_wide_as_what_is_undecided_in_it(begin: float, end: float) -> None:
    found = scanned(np.linspace(0.0, 1.0, 9).tolist(), half_open(begin, end), WIDTH)
    (change,) = found.changes
    assert change.decided
    assert begin - WIDTH <= change.low.value < begin
    assert end < change.high.value <= end + WIDTH


def test_what_is_open_at_an_end_is_listed_with_its_whole_width_and_no_answer() -> None:
    found = scanned([0.0, 0.25, 0.5, 0.75, 1.0], half_open(0.6, 2.0), WIDTH)
    (change,) = found.changes
    assert not change.decided
    assert (change.low.value, change.high.value) == (0.5, 0.75)
    assert (change.low.answer, change.high.answer) == (False, None)


def test_an_open_look_between_equal_answers_is_listed_on_both_sides() -> None:
    def look(value: float, origin: Look | None) -> Look:
        return Look(value, None if value == 0.5 else True, "")

    found = scanned([0.0, 0.25, 0.5, 0.75, 1.0], look, WIDTH)
    ends = [(change.low.value, change.high.value, change.decided) for change in found.changes]
    assert ends == [(0.25, 0.5, False), (0.5, 0.75, False)]


def bistable(low: float, high: float, reach: float = 10.0) -> Callable[..., Look]:
    """An upper branch down to `low` and a lower one up to `high`.

    A step longer than `reach` falls off the upper branch, wherever it ends.
    """

    def look(value: float, origin: Look | None) -> Look:
        upper = value > high
        if origin is not None and origin.carry == "upper" and value > low:
            upper |= abs(value - origin.value) <= reach
        return Look(value, upper, "", "upper" if upper else "lower")

    return look


def there_and_back(look: Callable[..., Look], count: int) -> tuple[Found, Found]:
    """Both ways along (0, 1)."""
    values = np.linspace(0.0, 1.0, count).tolist()
    up = followed(values, look, WIDTH)
    return up, followed(values[::-1], look, WIDTH, up.looks[-1])


@pytest.mark.parametrize("reach", [10.0, 0.05])
def test_a_bistable_range_has_its_two_ends_whatever_the_steps(reach: float) -> None:
    up, back = there_and_back(bistable(0.31, 0.74, reach), 9)
    (loss,), (return_,) = up.changes, back.changes
    assert loss.middle == pytest.approx(0.74, abs=WIDTH)
    assert return_.middle == pytest.approx(0.31, abs=WIDTH)
    assert return_.width <= WIDTH
    (found,) = hysteresis(up, back, (0.0, 1.0))
    assert found.low == Edge(return_.middle, "change", return_.width)
    assert found.high == Edge(loss.middle, "change", loss.width)


@pytest.mark.parametrize(("begin", "end"), [(0.40, 0.72), (0.70, 0.735), (0.735, 0.74)])
def test_a_branch_is_followed_through_looks_that_are_open(begin: float, end: float) -> None:
    """They hand their state on; no step over them is as short as the branch needs."""
    bare = bistable(-1.0, 2.0, 0.03)

    def look(value: float, origin: Look | None) -> Look:
        found = bare(value, origin if origin is not None else Look(value, True, "", "upper"))
        lost = found.carry == "lower" or value > 0.741
        found = Look(value, not lost, "", "lower" if lost else "upper")
        is_open = begin < value < end
        return Look(value, None, "undecided", found.carry) if is_open else found

    found = followed(np.linspace(0.0, 1.0, 41).tolist(), look, WIDTH)
    decided = [change for change in found.changes if change.decided]
    (change,) = decided
    assert holds(change, 0.741)
    assert change.width == pytest.approx(WIDTH)


def test_without_hysteresis_there_is_no_range() -> None:
    up, back = there_and_back(bistable(0.5, 0.5), 6)
    assert len(up.changes) == len(back.changes) == 1
    assert hysteresis(up, back, (0.0, 1.0)) == []


def test_a_range_that_reaches_the_bracket_ends_there() -> None:
    (found,) = hysteresis(*there_and_back(bistable(-1.0, 0.4), 6), (0.0, 1.0))
    assert (found.low.value, found.low.kind) == (0.0, "bracket")
    assert (found.high.value, found.high.kind) == (pytest.approx(0.4, abs=WIDTH), "change")


@pytest.mark.parametrize(
    ("blank", "ranges"),
    [
        (0.0, [(0.2, "undecided", 0.7, "change")]),
        (0.4, [(0.1, "change", 0.2, "undecided"), (0.6, "undecided", 0.7, "change")]),
        (1.0, [(0.1, "change", 0.7, "change")]),
    ],
)
def test_what_is_undecided_blanks_no_more_than_its_own_steps(
    blank: float, ranges: list[tuple[float, str, float, str]]
) -> None:
    plain = bistable(0.1, 0.7)

    def look(value: float, origin: Look | None) -> Look:
        found = plain(value, origin)
        return found if value != blank else Look(value, None, "", found.carry)

    found = hysteresis(*there_and_back(look, 6), (0.0, 1.0))
    ends = [(one.low.value, one.low.kind, one.high.value, one.high.kind) for one in found]
    assert [(low, high) for _, low, _, high in ends] == [(low, high) for _, low, _, high in ranges]
    for one, expected in zip(ends, ranges, strict=True):
        assert one[::2] == pytest.approx(expected[::2], abs=WIDTH)


@pytest.mark.parametrize("most", [0.8, 0.3, 0.05, 0.01])
@pytest.mark.parametrize("end", [0.3131, 0.74])
def test_an_end_lies_in_its_bracket_however_short_the_steps_before_it_must_be(
    most: float, end: float
) -> None:
    """A step holds if it is shorter than a share of what is left, at a fold and at a grazing."""

    def look(value: float, origin: Look | None) -> Look:
        holds = origin is None or value - origin.value <= most * (end - origin.value)
        return Look(value, holds and (origin is None or bool(origin.answer)), "", "x")

    (change,) = followed(np.linspace(0.0, 1.0, 9).tolist(), look, 1e-3).changes
    assert holds(change, end)
    assert change.width <= (1.001e-3 if most > 0.1 else 0.15)


def test_a_branch_that_bears_no_step_is_left_at_the_width_reached() -> None:
    looks = 0

    def look(value: float, origin: Look | None) -> Look:
        nonlocal looks
        looks += 1
        near = origin is None or abs(value - origin.value) <= 2e-6
        return Look(value, near and (origin is None or bool(origin.answer)), "", "x")

    found = followed([0.0, 1.0], look, 1e-6)
    assert looks <= MOST_LOOKS + 2
    assert found.changes[0].decided


def test_an_open_look_on_a_branch_that_goes_on_stays_open() -> None:
    def look(value: float, origin: Look | None) -> Look:
        if value == 0.5:
            return Look(value, None, "", "x")
        fell = origin is not None and abs(value - origin.value) > 0.3
        return Look(value, not fell, "", "x")

    found = followed([0.0, 0.25, 0.5, 1.0], look, 1e-3)
    assert [one.answer for one in found.looks] == [True, True, None, True]
    assert [change.decided for change in found.changes] == [False, False]


def test_nothing_is_looked_at_behind_a_run_that_leaves_nothing() -> None:
    def look(value: float, origin: Look | None) -> Look:
        return Look(value, True, "", None if value >= 0.5 else "x")

    assert [one.value for one in followed([0.0, 0.5, 1.0], look, WIDTH).looks] == [0.0, 0.5]


OFFSET = Outcome(values={"attractor": "periodic", "u_min": 7.0, "u_max": 8.0})
ABOVE = Question("stick_fraction", "", True, 0.0)
BELTS = Outcome(values={"attractor": "periodic", "stick_fraction": np.array([0.0, 0.3])})


@pytest.mark.parametrize(
    ("question", "outcome", "answer"),
    [
        (Question(name="periodic"), Outcome(values={"attractor": "periodic"}), True),
        (Question(name="periodic"), Outcome(values={"attractor": "diverged"}), False),
        (Question(name="periodic", negated=True), Outcome(values={"attractor": "chaotic"}), True),
        (Question(name="periodic"), Outcome(values={"attractor": "undecided"}), None),
        (Question(name="undecided"), Outcome(values={"attractor": "undecided"}), True),
        (
            Question(name="contact_lost", negated=True, counts=True),
            Outcome(values={"attractor": "undecided"}),
            True,
        ),
        (
            Question(name="contact_lost", negated=True, counts=True),
            Outcome("budget", "too_many_events", {"attractor": "undecided"}),
            None,
        ),
        (Question(name="periodic"), Outcome("failed", "no_equilibrium"), None),
        (Question(name="periodic"), Outcome("not_computed", "mu_k_above_mu_s"), None),
        (Question("L_s", below=1.0), Outcome(values={"attractor": "periodic", "L_s": 0.5}), True),
        (Question("L_s", below=1.0), Outcome(values={"attractor": "periodic", "L_s": 2.0}), False),
        (Question("L_s", below=1.0), Outcome(values={"attractor": "undecided", "L_s": 0.5}), None),
        (Question("period", below=1.0), Outcome(values={"attractor": "equilibrium"}), None),
        (Question("u_max", below=1.0), Outcome(values={"attractor": "diverged"}), False),
        (Question("L_s", below=1.0), Outcome(values={"attractor": "diverged"}), False),
        (Question("u_min", below=1.0), Outcome(values={"attractor": "diverged"}), None),
        (ABOVE, Outcome(values={"attractor": "equilibrium", "stick_fraction": 0.0}), False),
        (ABOVE, Outcome(values={"attractor": "periodic", "stick_fraction": 0.2}), True),
        (ABOVE, Outcome(values={"attractor": "periodic"}), None),
        (replace(ABOVE, contact=1), BELTS, False),
        (replace(ABOVE, contact=2), BELTS, True),
        (replace(ABOVE, contact=2), Outcome(values={"attractor": "periodic"}), None),
        (Question("L_s", "", True, 1.0), Outcome(values={"attractor": "diverged"}), True),
        (Question("u_amplitude", below=1.0), OFFSET, True),
        (Question("u_amplitude", below=0.4), OFFSET, False),
        (Question("v_amplitude", below=1.0), OFFSET, None),
    ],
)
def test_answers(question: Question, outcome: Outcome, answer: bool | None) -> None:
    assert answered(question, outcome) is answer


TWO_CONTACTS = {"schema": 1, "model": {"name": "belt-2mass"}}


@pytest.mark.parametrize(("contact", "least", "most"), [(1, 3.0, 3.25), (2, 4.25, 4.5)])
def test_where_one_of_several_contacts_no_longer_sticks(
    contact: int, least: float, most: float
) -> None:
    """Between the two speeds of a sweep at which it last does, and first does not."""
    speeds = {"grid": {"v": [least, most]}, "analysis": [{"kind": "response"}]}
    swept = run(api.load(TWO_CONTACTS | speeds), workers=1)["stick_fraction"]
    assert (swept.isel(contact=contact - 1).values.ravel() > 0.0).tolist() == [True, False]
    of = {"variable": "stick_fraction", "contact": contact, "expect": {"greater_than": 0.0}}
    asked = {"kind": "boundary", "parameter": "v", "bracket": [2.5, 6.0], "of": of, "width": 1e-3}
    found = run(api.load(TWO_CONTACTS | {"analysis": [asked]}), workers=1)
    (place,) = found["boundary"].values.ravel()
    assert least < place < most


@pytest.mark.parametrize(
    ("of", "place", "allowed"),
    [
        ({"variable": "stick_fraction"}, "variable", "contact = 1, or another up to 2"),
        ({"variable": "stick_fraction", "contact": 3}, "contact", "1 to 2"),
        ({"variable": "L_s", "contact": 1}, "contact", "no contact, or of stick_fraction"),
        ({"contact": 1, "expect": "periodic"}, "contact", "no contact"),
        ({"variable": "stik_fraction", "contact": 1}, "variable", "L_s"),
    ],
)
def test_a_number_of_each_contact_is_that_of_one(
    of: dict[str, object], place: str, allowed: str
) -> None:
    asked = {"kind": "boundary", "parameter": "v", "bracket": [2.5, 6.0]}
    asked["of"] = {"expect": {"greater_than": 0.0}} | of
    with pytest.raises(CaseError) as caught:
        api.load(TWO_CONTACTS | {"analysis": [asked]})
    (problem,) = caught.value.problems
    assert problem.path == f"analysis.0.of.{place}" and problem.allowed.startswith(allowed)


@pytest.mark.parametrize("kind", ["equilibrium", "state"])
def test_what_is_followed_goes_on_from_its_state_and_is_not_moved_again(kind: str) -> None:
    on = going_on(Start("near", kind, {"x": 1e-4}), {"attractor": "equilibrium", "state": [1.0]})
    assert on == Start("near", "continue", {}, {"attractor": "followed", "state": [1.0]})


@pytest.mark.parametrize("offset", [1e-3, 0.3])
def test_an_equilibrium_is_followed_down_to_where_it_loses_its_stability(offset: float) -> None:
    """However far off the first run begins: c = -N mu'(v) at v = log(3.4)."""
    settings = {
        "parameter": Varied("v"), "bracket": (1.1, 1.9), "of": Question(name="equilibrium"),
        "scan": 5, "width": 1e-4, "follow": "down", "lyapunov": "never",
    }  # fmt: skip
    start = Start("near", "equilibrium", {"x": offset})
    law = {"mu_s": 0.4, "mu_k": 0.23, "v_s": 1.0, "delta": 1.0}
    found = analyse(
        "belt-1dof", "stribeck", "boundary", start, settings, m=1.0, k=1.0, c=0.5, N=10.0, **law
    ).values
    (end,), (error,) = found["boundary"], found["boundary_error"]
    assert abs(end - np.log(3.4)) < error < 0.01


def test_a_start_that_names_a_parameter_follows_it() -> None:
    start = Start("drive", "state", {"x_dot": 1.0, "x": 3.0}, named={"x_dot": "v"})
    assert start.at({"v": 2.5}).values == {"x_dot": 2.5, "x": 3.0}


PIN = """
schema = 1
[model]
name = "pin-on-disc"
[[initial]]
label = "drive"
kind = "state"
state = { phi_dot = "Omega" }
[[analysis]]
name = "reached"
kind = "boundary"
parameter = "Omega"
bracket = [4.0, 10.0]
of = { expect = "periodic" }
scan = 4
width = 1e-3
lyapunov = "never"
[[analysis]]
name = "exists"
kind = "boundary"
parameter = "Omega"
bracket = [6.0, 18.0]
of = { variable = "attractor", expect = "periodic" }
scan = 5
width = 1e-3
follow = "both"
lyapunov = "never"
"""

CLAIM = """
[[claim]]
source = "a measurement"
text = "where stick-slip is lost"
variable = "boundary"
expect = { value = 6.0, tolerance = 0.1 }
"""
AT_SPEED = f"{CLAIM}at = {{ Omega = 6.0 }}\n"


def test_a_border_is_told_with_its_error_and_with_what_it_is_no_border_of() -> None:
    """Of a start its answer changes there; a branch that is followed ends there; of several values
    a claim takes one, and where there is none it has the reason, which `show` tells as it is here.
    """
    one = PIN.partition('[[analysis]]\nname = "exists"')[0] + CLAIM
    told, found = shown_and_claimed(one)
    value, error = re.search(r"  boundary +(6\.8\d+) ± (0\.\d+) rad s-1\n", told).groups()
    assert len(value) == len(error) and f"{value} ± {error} rad s-1" in found
    assert BEYOND in told
    assert BEYOND not in shown_and_claimed(one.replace("scan = 4", 'scan = 4\nfollow = "up"'))[0]
    told, found = shown_and_claimed(one.replace("[4.0, 10.0]", "[5.0, 6.0]"))
    assert "the answer to `of` is the same wherever" in told and "critical" not in told
    assert "nothing to try it on: no_crossing" in found


def test_a_border_of_what_is_undecided_in_its_time_is_told_to_be_of_that_time() -> None:
    one = PIN.partition('[[analysis]]\nname = "exists"')[0] + CLAIM
    told = "where t_max = 3 s puts it; more time moves it further than its error says"
    short = one.replace("scan = 4", "scan = 4\nt_max = 3.0")
    assert told not in shown_and_claimed(short)[0]
    counts = re.sub(r"of = \{(.*?)\}", r'of = {\1, undecided = "counts" }', short)
    assert counts != short
    assert ("undecided" in shown_and_claimed(counts)[0]) and told in shown_and_claimed(counts)[0]


def shown_and_claimed(text: str) -> tuple[str, str]:
    """What `show` prints of a case of one analysis, and what its claim finds."""
    case = parse_case(text, "pin.toml", ())
    dataset = run(case, workers=1)
    wide = dataset.assign(boundary_width=100.0 * dataset["boundary_width"])
    fine, coarse = (
        "more than was asked for" in str(summarise({"": one})) for one in (dataset, wide)
    )
    assert coarse == bool((dataset["n_crossings"] > 0).any())
    assert not fine or bool((dataset["n_undecided"] > 0).any())
    return "\n".join(lines(summarise({"": dataset}))), claims(case, dataset)[0].found


def test_stick_slip_of_the_pin_is_reached_less_far_than_it_exists(tmp_path: Path) -> None:
    """From phi_dot = Omega stick-slip is lost near 6.84 rad/s; followed, it lives to 14.82922.

    The latter is where the orbit grazes, by Newton's method on the return map (analysis cycle).
    """
    summary = run_case(
        parse_case(PIN, "pin.toml", ()), tmp_path / "a.nc", Policy(workers=1), Silent()
    )
    assert summary.complete
    reached, exists = (read_datasets(tmp_path / "a.nc")[name] for name in ("reached", "exists"))
    assert reached["boundary"].attrs["long_name"] == "Omega at the border of periodic"
    (low,) = reached["boundary"].values.ravel()
    (high,) = exists["boundary"].values.ravel()
    assert low == pytest.approx(6.838, abs=0.005)
    assert (reached["boundary_width"] <= 0.006).all()
    assert abs(high - 14.82922) <= exists["boundary_error"].item() <= 2.0 * 0.012
    assert (reached["boundary_error"] <= 0.006).all()
    assert reached["boundary"].attrs["units"] == "rad s-1"
    assert reached["scan"].values.tolist() == [4.0, 6.0, 8.0, 10.0]
    assert reached["class_below"].values.ravel().tolist() == [1]
    assert reached["class_above"].values.ravel().tolist() == [0]
    assert exists["bistable_low"].item() == 6.0
    assert exists["bistable_high"].item() == high
    assert np.isnan(exists["bistable_low_width"].item())
    assert exists["bistable_low_error"].item() == 0.0  # the bracket's edge
    assert exists["bistable_high_error"].item() == exists["boundary_error"].item()
    kinds = [RANGE_END.codes[kind] for kind in ("bracket", "change")]
    assert [exists[f"bistable_{side}_kind"].item() for side in ("low", "high")] == kinds


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (('{ expect = "periodic" }', '{ expect = "periodical" }'), "did you mean 'periodic'"),
        (("bracket = [4.0, 10.0]", "bracket = [10.0, 4.0]"), "is not below"),
        (('{ expect = "periodic" }', '{ variable = "L_z", expect = { less_than = 1 } }'), "L_s"),
        (('{ expect = "periodic"', '{ variable = "L_s", expect = "periodic"'), "holds no class"),
        (('of = { expect = "periodic" }', ""), "is missing"),
        (('{ expect = "periodic" }', "{ greater_than = 1 }"), "write expect = { greater_than = N"),
        (("scan = 4", "scan = 1"), "1 is out of range"),
        (("[[initial]]", "[grid]\nOmega = [1, 2]\n[[initial]]"), "is an axis of the grid"),
        (('"Omega"\nbracket', '"initial.phi"\nbracket'), '[grid] "initial.phi" = {'),
        (("schema = 1", f"schema = 1\n{AT_SPEED}"), "'reached' varies it, and finds values"),
        (("schema = 1", f"schema = 1\n{AT_SPEED}"), "allowed: initial, crossing\n"),
    ],
)  # fmt: skip
def test_what_is_refused(change: tuple[str, str], message: str) -> None:
    text = PIN.replace(*change, 1)
    assert text != PIN
    with pytest.raises(CaseError) as caught:
        parse_case(text, "pin.toml", ())
    assert message in str(caught.value)


def test_a_number_is_asked_for_above_a_bound_as_below_it() -> None:
    asked = '{ variable = "stick_fraction", expect = { greater_than = 0.0 } }'
    of_amplitude = asked.replace("stick_fraction", "phi_amplitude")
    assert parse_case(PIN.replace('{ expect = "periodic" }', of_amplitude), "pin.toml", ())
    text = PIN.replace('{ expect = "periodic" }', asked)
    assert parse_case(text, "pin.toml", ()).analyses[0].settings["of"] == ABOVE
    with pytest.raises(CaseError) as caught:
        parse_case(text.replace("{ greater_than = 0.0 }", "{ between = [0, 1] }"), "pin.toml", ())
    assert str(caught.value).count('"not CLASS"') == 1  # what may stand is said once


def test_the_plan_says_what_is_looked_at() -> None:
    lines = make_plan(parse_case(PIN, "pin.toml", ())).describe()
    assert (
        "    Omega is varied from 4.0 to 10.0 rad s-1: 4 values, "
        "each change bisected to 0.006 rad s-1"
    ) in lines


def test_a_default_outside_the_bracket_does_not_matter() -> None:
    """mu_k = 0.23 is above mu_s = 0.2, but no run of this case has it."""
    text = (
        PIN.split("[[analysis]]")[0]
        + """
[friction]
mu_s = 0.2
[[analysis]]
kind = "boundary"
parameter = "mu_k"
bracket = [LOW, 0.3]
of = { expect = "periodic" }
"""
    )
    assert parse_case(text.replace("LOW", "0.1"), "pin.toml", ()).analyses
    with pytest.raises(CaseError, match=r"mu_k = 0.25, mu_s = 0.2: mu_k is above mu_s"):
        parse_case(text.replace("LOW", "0.25"), "pin.toml", ())


def test_a_start_that_continues_along_the_grid_is_refused() -> None:
    text = PIN.replace("[[initial]]", "[grid]\nN0 = [20, 30]\n[[initial]]", 1).replace(
        "[[analysis]]",
        '[[initial]]\nlabel = "up"\nkind = "continue"\nalong = "N0"\nfrom = "drive"\n[[analysis]]',
        1,
    )
    with pytest.raises(CaseError, match="neighbour's end"):
        parse_case(text, "pin.toml", ())


# --- how far a change may be off -----------------------------------------------------------------
@pytest.mark.parametrize("shift", [0.0, 1e-9, -1e-9, 3e-5, -0.2])
def test_closer_looks_find_a_change_within_what_is_said(shift: float) -> None:
    (change,) = scanned([0.0, 0.5, 1.0], steps(0.3), WIDTH).changes
    error = confirmed_within(change, steps(0.3 + shift), None, (0.0, 1.0))
    assert abs(change.middle - (0.3 + shift)) <= error
    assert error <= max(4.0 * (abs(shift) + change.width), WIDTH)


def test_what_closer_looks_do_not_find_has_no_bound() -> None:
    (change,) = scanned([0.0, 0.5, 1.0], steps(0.3), WIDTH).changes
    assert np.isnan(confirmed_within(change, steps(), None, (0.0, 1.0)))
    (wide,) = scanned([0.0, 0.25, 0.5, 0.75, 1.0], half_open(0.6, 2.0), WIDTH).changes
    assert np.isnan(confirmed_within(wide, steps(0.6), None, (0.0, 1.0)))


UNIT = {"m": 1.0, "k": 1.0, "N": 1.0}
BELT = UNIT | {"c": 0.1, "mu_s": 1.0, "mu_k": 0.5}
RELEASE, RETURN = {"event": "stick->slip"}, {"zero": "x_dot"}
ENDS = {
    "grazing": ("belt-1dof", "stribeck", "v", (1.2, 3.0), RELEASE, BELT | {"v_s": 0.5}),
    "grazing, steeper": ("belt-1dof", "exponential", "v", (0.5, 6.0), RELEASE, BELT),
    "fold": ("belt-1dof", "tanh of stribeck", "v", (1.2, 3.0), RETURN, BELT | {"v_s": 0.5}),
    "Hopf": ("belt-1dof", "cubic", "v", (0.3, 1.0), RETURN, UNIT | {"c": 0.05}),
    "landing missed": ("pin-on-disc", "coulomb", "Omega", (5.0, 22.0), RELEASE, {"N0": 30.0}),
}


@pytest.mark.parametrize("name", ENDS)
def test_a_branch_is_said_to_end_where_newtons_method_finds_its_end(name: str) -> None:
    """In whatever steps: carried on at its release a motion bears only short ones.

    And however coarse runs are: those of 1e-5 end a branch up to 2.3 times as far off as the width.
    """
    model, law, varied, (low, high), section, parameters = ENDS[name]
    velocity = "phi_dot" if model == "pin-on-disc" else "x_dot"
    point = partial(analyse, model, law, start={velocity: low}, **parameters, **{varied: low})
    asked = {"parameter": varied, "bracket": (0.5 * low, high), "t_max": 300.0}
    truth = point("cycle", settings=asked).values["cycle_highest"]
    for width, scan, rtol in [(1e-2, 5, 1e-9), (1e-2, 11, 1e-9), (1e-4, 11, 1e-9), (1e-5, 5, 1e-5)]:
        asked = {
            "parameter": varied, "bracket": (low, high), "of": {"expect": "periodic"},
            "scan": scan, "width": width, "follow": "up", "section": section, "lyapunov": "never",
        }  # fmt: skip
        found = point("boundary", settings=asked, solver=SolverSettings(rtol=rtol)).values
        (boundary,), (error,) = found["boundary"], found["boundary_error"]
        assert abs(boundary - truth) <= error <= 1e-2 * (high - low)


DAMPING = 0.005


def fastest_slide(x: float) -> float:
    """Greatest velocity of the damped Coulomb belt that slides from rest at `x`, in closed form.

    A belt that moves faster is never caught up with; on a slower one stick-slip begins.
    """
    frequency = sqrt(1.0 - DAMPING**2 / 4)
    when = atan2(2 * frequency, DAMPING) / frequency
    amplitude = (2.3 - x) / frequency
    return amplitude * exp(-DAMPING * when / 2) * sin(frequency * when)


@pytest.mark.parametrize(
    "solver",
    [SolverSettings(rtol=rtol) for rtol in (1e-5, 1e-7, 1e-9, 1e-11, 1e-13)]
    + [SolverSettings("rk4", step=step) for step in (0.1, 0.02)],
    ids=lambda solver: f"{solver.method} {solver.rtol} {solver.step}",
)
@pytest.mark.parametrize("width", [1e-4, 1e-13])
@pytest.mark.parametrize("x", [-2.7, -2.55])
def test_the_error_of_a_boundary_is_bounded(solver: SolverSettings, width: float, x: float) -> None:
    """However closely it is bisected; and by no more than a few times what the runs are worth."""
    settings = {
        "parameter": Varied("v"), "bracket": (4.5, 5.0), "of": Question(name="periodic"),
        "scan": 3, "width": width, "follow": "none", "lyapunov": "never",
    }  # fmt: skip
    found = analyse(
        "belt-1dof", "coulomb", "boundary", {"x": x}, settings, solver, c=DAMPING
    ).values
    (boundary,), (error,) = found["boundary"], found["boundary_error"]
    assert abs(boundary - fastest_slide(x)) <= error
    worth = 50.0 * max(solver.rtol, 1e-13) if solver.method == "taylor" else solver.step**2
    assert error <= worth + width
