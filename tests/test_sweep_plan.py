"""Laws of the planner: points, keys, chains, starts."""

from __future__ import annotations

from math import nextafter

import numpy as np
import pytest
import sweep_fakes
from hypothesis import given, settings
from hypothesis import strategies as st

from fiv_cli.sweep.plan import AnalysisPlan, make_plan
from fiv_cli.sweep.queue import spread
from fiv_cli.sweep.requests import (
    point_key,
    request_at,
    resolve_start,
)

HEAD = 'schema = 1\n[model]\nname = "belt-1dof"\n'
SLOPE = '[friction]\nlaw = "linear-slope"\n[[analysis]]\nkind = "response"\n'
RESPONSE = '[[analysis]]\nkind = "response"\n'


def plan_of(text: str) -> AnalysisPlan:
    """The plan of the first analysis of a case."""
    return make_plan(sweep_fakes.case(text)).analyses[0]


def grid(**axes: list[float]) -> str:
    """A case with numeric axes."""
    lines = "".join(f"{name} = {values}\n" for name, values in axes.items())
    return f"{HEAD}[grid]\n{lines}{RESPONSE}"


def test_one_unit_in_the_last_place_makes_another_point() -> None:
    keys = plan_of(grid(k=[1.0, nextafter(1.0, 2.0)])).keys()
    assert keys[0].tobytes() != keys[1].tobytes()


def test_a_negative_zero_is_a_zero() -> None:
    def key(zero: float) -> bytes:
        return bytes(plan_of(grid(alpha_0=[zero]).replace(RESPONSE, SLOPE)).keys()[0].tobytes())

    assert key(-0.0) == key(0.0)


@given(size=st.integers(1, 4000), share=st.floats(0.05, 1.0))
@settings(deadline=None)
def test_points_are_taken_from_all_over_the_grid(size: int, share: float) -> None:
    """Each beginning of a run has about as many of each quarter; neighbours stay together."""
    order = spread(np.arange(size) + 7)
    assert sorted(order) == [*range(7, size + 7)]
    first = order[: int(share * size)] - 7
    counts = np.histogram(first, np.linspace(0.0, size, 5))[0]
    assert np.abs(counts - first.size / 4).max() <= 3 * max(1, min(16, size // 64)) + 1
    assert spread(np.arange(6400))[:16].tolist() == [*range(16)]


numbers = st.lists(
    st.floats(0.1, 50.0, allow_nan=False).map(lambda x: round(x, 3)),
    min_size=1,
    max_size=5,
    unique=True,
)


@given(first=numbers, second=numbers)
@settings(max_examples=30, deadline=None)
def test_points_follow_the_dims_in_c_order(first: list[float], second: list[float]) -> None:
    plan = plan_of(grid(k=first, m=second))
    assert plan.layout.shape == (len(first), len(second), 1)
    expected = [(k, m) for k in first for m in second]
    assert [plan.point(i)[0] for i in range(plan.size)] == expected


@given(values=numbers, more=numbers)
@settings(max_examples=30, deadline=None)
def test_a_key_belongs_to_the_point_and_not_to_its_position(
    values: list[float], more: list[float]
) -> None:
    def keys_by_value(axis: list[float]) -> dict[float, bytes]:
        keys = plan_of(grid(k=axis)).keys()
        return {value: keys[i].tobytes() for i, value in enumerate(axis)}

    union = sorted(set(values) | set(more))
    short, long = keys_by_value(values), keys_by_value(union)
    assert all(long[value] == short[value] for value in values)
    assert len(set(long.values())) == len(union)


@given(values=numbers, direction=st.sampled_from(["up", "down"]))
@settings(max_examples=30, deadline=None)
def test_chains_cover_each_point_once_in_the_order_of_the_axis(
    values: list[float], direction: str
) -> None:
    text = f"""{HEAD}[grid]
m = [1.0, 2.0]
k = {values}
[[initial]]
label = "far"
kind = "state"
[[initial]]
label = "branch"
kind = "continue"
along = "k"
direction = "{direction}"
from = "far"
{RESPONSE}"""
    plan = plan_of(text)
    (chains,) = plan.chain_sets()
    covered = [*plan.single_positions(), *chains.positions.ravel()]
    assert sorted(covered) == list(range(plan.size))
    for chain in chains.positions:
        followed = [plan.point(int(position))[0][1] for position in chain]
        assert followed == sorted(values, reverse=direction == "down")


def test_a_chain_keeps_its_keys_when_it_grows_at_its_far_end_only() -> None:
    def chain_keys(*values: float) -> list[bytes]:
        axis = ", ".join(map(str, values))
        plan = plan_of(sweep_fakes.CHAIN.replace("{ start = 1, stop = 8, num = 8 }", f"[{axis}]"))
        keys = plan.keys()
        (chains,) = plan.chain_sets()
        return [keys[position].tobytes() for position in chains.positions[0]]

    short = chain_keys(1.0, 2.0, 3.0)
    assert chain_keys(1.0, 2.0, 3.0, 4.0)[:3] == short
    assert not set(chain_keys(0.5, 1.0, 2.0, 3.0)) & set(short)


def test_a_chain_that_begins_at_the_end_of_another_has_other_keys_where_that_grew() -> None:
    def keys(text: str) -> tuple[set[bytes], set[bytes]]:
        plan = plan_of(text)
        (chains,) = plan.chain_sets()
        up, down = np.hsplit(plan.keys()[chains.positions], 2)
        return set(map(bytes, up.reshape(-1, 32))), set(map(bytes, down.reshape(-1, 32)))

    up, down = keys(sweep_fakes.LOOP)
    longer = keys(sweep_fakes.LOOP.replace("stop = 8, num = 8", "stop = 9, num = 9"))
    assert longer[0] > up
    assert not longer[1] & down


def test_a_plan_says_what_the_case_leaves_to_the_model_and_its_law() -> None:
    """The default on this model, not that of the law; nothing that an axis or the case gives.

    Of the model those that decide what it does are named, the others counted; `defaults` has all.
    """
    text = sweep_fakes.BELT.replace('"belt-1dof"', '"belt-1dof"\nparameters = { k = 2.0 }')
    plan = make_plan(sweep_fakes.case(text))
    (line,) = [line for line in plan.describe() if "by default" in line]
    named = "u0 = 0, omega = 1, mu_s = 0.4, mu_k = 0.23"
    assert line == f"  by default, in SI: {named}, 2 more: fiv models belt-1dof"
    by_name = {"m": 1.0, "c": 0.0, "u0": 0.0, "omega": 1.0, "mu_s": 0.4, "mu_k": 0.23}
    assert plan.defaults() == by_name
    falling = make_plan(sweep_fakes.case(f'{text}[friction]\nlaw = "exponential"\n'))
    (line,) = [line for line in falling.describe() if "by default, " in line]
    assert "alpha = 1, mu_0 = mu_s, " in line and falling.defaults()["mu_0"] == "mu_s"


def test_a_plan_says_which_options_of_the_model_are_left() -> None:
    """What happens at re-contact decides how large motions are, and was named nowhere."""
    text = (
        'schema = 1\n[model]\nname = "flutter-2dof"\noptions = { states = "all" }\n'
        '[grid]\nmu_k = [1.0, 2.0]\n[[analysis]]\nkind = "response"\n'
    )
    told = make_plan(sweep_fakes.case(text)).describe()
    assert '  options by default: impact = "plastic"' in told
    chosen = make_plan(sweep_fakes.case(text.replace("= { states", '= { impact = "none", states')))
    assert not [line for line in chosen.describe() if "options by default" in line]


def test_a_plan_says_law_by_law_what_is_left_and_where_the_laws_defaults_differ() -> None:
    def told(friction: str) -> list[str]:
        laws = '[grid]\nfriction = ["stribeck", "lugre", "coulomb"]\n'
        text = f"{HEAD}[friction]\n{friction}\n{laws}{RESPONSE}"
        return make_plan(sweep_fakes.case(text)).describe()[2:5]

    left, of_model, differ = told("stribeck = { v_s = 0.1 }\nlugre = { v_s = 0.1 }")
    assert " mu_k = 0.23, stribeck.delta = 1, lugre.delta = 2, sigma_0 = " in left
    assert "v_s" not in left
    assert of_model == "  mu_s, mu_k: the default of belt-1dof, not of the law"
    assert differ.startswith("  the laws' defaults of delta differ (stribeck.delta = 1, lugre.del")
    left, _, analysis = told("delta = 2.0\nstribeck = { v_s = 0.1 }")
    assert "lugre.v_s = " in left and "delta" not in left and "stribeck.v_s" not in left
    assert analysis.startswith("  response: 3 points")


def test_keys_made_together_are_those_of_the_points() -> None:
    """With axes of numbers and of laws, points on their own and chains."""
    plan = plan_of(sweep_fakes.LOOP.replace("v = [", 'friction = ["coulomb", "stribeck"]\nv = ['))
    keys, entries = plan.keys(), plan.template.entries
    (chains,) = plan.chain_sets()
    for position in plan.single_positions():
        values, index = plan.point(int(position))
        assert keys[position].tobytes() == point_key(plan.template, values, entries[index])
    for chain in chains.positions:
        previous = b""
        for position in chain:
            values, index = plan.point(int(position))
            previous = point_key(plan.template, values, entries[index], previous)
            assert keys[position].tobytes() == previous


def test_random_starts_are_those_of_the_point_wherever_it_lies() -> None:
    def starts(axis: str, more: str = "") -> dict[tuple[float, str], dict[str, float]]:
        plan = plan_of(
            f"""{HEAD}[grid]
k = {axis}
[[initial]]
label = "far"
kind = "random"
count = 3
seed = 7
box = {{ x = [-1.0, 1.0], x_dot = [0.0, 2.0] }}
{RESPONSE}{more}"""
        )
        found = {}
        for position in range(plan.size):
            values, index = plan.point(position)
            entry = plan.entry(index)
            assert entry is not None
            start = resolve_start(plan.template, values, entry)
            found[values[0], start.label] = dict(start.values)
        return found

    few, many = starts("[1.0, 2.0]"), starts("[0.5, 1.0, 1.5, 2.0]")
    assert {label for _, label in few} == {"far-000", "far-001", "far-002"}
    assert all(many[point] == start for point, start in few.items())
    assert len({str(start) for start in many.values()}) == len(many)
    assert all(-1 <= s["x"] <= 1 and 0 <= s["x_dot"] <= 2 for s in many.values())
    assert few == starts("[1.0, 2.0]", "t_max = 77.0\n[solver]\nrtol = 1e-6\n")


def test_a_start_takes_parameters_and_axes() -> None:
    plan = plan_of(
        f"""{HEAD}[grid]
v = [0.5, 3.0]
"initial.x" = [-1.0, 1.0]
[[initial]]
label = "belt"
kind = "state"
state = {{ x = 9.0, x_dot = "v" }}
{RESPONSE}"""
    )
    entry = plan.entry(0)
    assert entry is not None
    start = resolve_start(plan.template, (3.0, -1.0), entry)
    assert (start.kind, dict(start.values)) == ("state", {"x": -1.0, "x_dot": 3.0})
    assert plan.layout.dim_names == ("v", "initial_x", "initial")


def test_axes_of_the_start_are_no_dims_of_an_analysis_without_starts() -> None:
    plan = make_plan(
        sweep_fakes.case(
            f'{HEAD}[grid]\nv = [0.5, 3.0]\n"initial.x" = [-1.0, 1.0]\n{RESPONSE}'
            '[[analysis]]\nkind = "eigenvalues"\n'
        )
    )
    assert [analysis.layout.dim_names for analysis in plan.analyses] == [
        ("v", "initial_x", "initial"),
        ("v",),
    ]


def test_zipped_axes_share_a_dim() -> None:
    plan = plan_of(
        f"{HEAD}[grid]\nk = [1.0, 1.0, 2.0]\nm = [3.0, 4.0, 5.0]\n"
        f'[sweep]\nzip = [["k", "m"]]\n{RESPONSE}'
    )
    assert plan.layout.dim_names == ("k_m", "initial")
    assert [plan.point(i)[0] for i in range(3)] == [(1.0, 3.0), (1.0, 4.0), (2.0, 5.0)]


@given(kinetic=numbers, static=numbers)
@settings(max_examples=30, deadline=None)
def test_points_with_mu_k_above_mu_s_are_counted(kinetic: list[float], static: list[float]) -> None:
    plan = plan_of(grid(mu_k=kinetic, m=[1.0, 2.0], mu_s=static))
    points = (plan.point(i)[0] for i in range(plan.size))
    found = sum(plan.unmet(values) is not None for values in points)
    assert plan.excluded().total() == found == 2 * sum(k > s for k in kinetic for s in static)


def test_a_law_sees_its_own_parameters_only() -> None:
    plan = plan_of(
        f'{HEAD}[grid]\nfriction = ["coulomb", "hyperbolic"]\nk = [1.0, 2.0]\n{RESPONSE}'
    )
    coulomb = request_at(plan.template, ("coulomb", 2.0), None)
    hyperbolic = request_at(plan.template, ("hyperbolic", 2.0), None)
    names = [request.setup.law.name for request in (coulomb, hyperbolic)]
    assert names == ["coulomb", "hyperbolic"]
    assert "mu_s" in coulomb.parameters and "mu_s" not in hyperbolic.parameters
    assert hyperbolic.parameters["k"] == 2.0
    assert {request.setup.law.name for request in plan.systems()} == {"coulomb", "hyperbolic"}


def test_a_million_points_are_planned_without_listing_them() -> None:
    plan = plan_of(
        f"{HEAD}[grid]\nk = {{ start = 1, stop = 1000, num = 1000 }}\n"
        f"m = {{ start = 1, stop = 1000, num = 1000 }}\n{RESPONSE}"
    )
    assert plan.size == 1_000_000
    assert plan.point(999_999)[0] == (1000.0, 1000.0)
    assert len(list(plan.systems())) == 1


def test_a_plan_says_whether_every_start_is_a_given_state() -> None:
    given = sweep_fakes.CHAIN.split('[[initial]]\nlabel = "up"')[0] + RESPONSE
    start = next(plan_of(given).systems()).start
    assert start is not None and (start.kind, start.values) == ("state", {"x": 1.0})
    assert next(plan_of(sweep_fakes.CHAIN).systems()).start is None


def test_the_description_names_points_chains_and_what_is_left_out() -> None:
    text = sweep_fakes.CHAIN.replace("v = [0.5, 1.0]", "mu_k = [0.1, 0.9]")
    lines = make_plan(sweep_fakes.case(text)).describe()
    assert any("32 points (mu_k 2 x N 8 x initial 2)" in line for line in lines)
    assert any("2 chains of 8 points along N up" in line for line in lines)
    assert any("16 points where mu_k is above mu_s" in line for line in lines)


@pytest.mark.parametrize("text", [sweep_fakes.BELT, sweep_fakes.CHAIN])
def test_keys_are_distinct(text: str) -> None:
    plan = plan_of(text)
    assert len(np.unique(plan.keys(), axis=0)) == plan.size


@pytest.mark.parametrize(
    ("friction", "told"),
    [('law = "stribeck"', 1), ('law = "stribeck"\nmu_s = 0.5', 0), ('law = "coulomb"', 0)],
)
def test_a_law_that_falls_with_speed_only_by_its_name_is_told(friction: str, told: int) -> None:
    text = f'schema = 1\n[model]\nname = "flutter-2dof"\n[friction]\n{friction}\n{RESPONSE}'
    lines = make_plan(sweep_fakes.case(text)).describe()
    assert sum("friction does not fall with speed" in line for line in lines) == told


def test_a_zipped_axis_in_no_order_is_told_by_its_least_and_greatest() -> None:
    grid = "[grid]\nv = [0.5, 3.0, 0.1, 1.0, 2.0]\nN = [1.0, 2.0, 3.0, 4.0, 5.0]\n"
    text = f'schema = 1\n[model]\nname = "belt-1dof"\n{grid}[sweep]\nzip = [["v", "N"]]\n'
    told = "\n".join(make_plan(sweep_fakes.case(text + RESPONSE)).describe())
    assert "v = 0.1 to 3.0 (5 values)" in told and "N = 1.0 ... 5.0 (5 values)" in told


@pytest.mark.parametrize(("kinds", "told"), [(["response"], 1), (["response", "history"], 0)])
def test_a_figure_that_only_a_motion_has_is_told(kinds: list[str], told: int) -> None:
    keys = {"history": "t_end = 1.0"}
    analyses = "".join(f'[[analysis]]\nkind = "{one}"\n{keys.get(one, "")}\n' for one in kinds)
    figure = '[[figure]]\nname = "portrait"\nkind = "phase"\n'
    text = f'schema = 1\n[model]\nname = "belt-1dof"\n{analyses}{figure}'
    lines = make_plan(sweep_fakes.case(text)).describe()
    assert sum("figure portrait: of a motion" in line for line in lines) == told


@pytest.mark.parametrize(
    ("friction", "told"),
    [
        ('law = "stribeck"\nmu_s = 0.4', 1),
        ('law = "stribeck"\nmu_s = 0.9', 0),
        ('law = "stribeck"', 0),  # it follows mu_k
        ('law = "coulomb"\nmu_s = 0.4', 0),  # of steady sliding it has no part
    ],
)
def test_a_law_that_rises_within_the_bracket_is_told(friction: str, told: int) -> None:
    critical = '[[analysis]]\nkind = "critical"\nparameter = "mu_k"\nbracket = [0.1, 0.9]\n'
    text = f'schema = 1\n[model]\nname = "flutter-2dof"\n[friction]\n{friction}\n{critical}'
    lines = make_plan(sweep_fakes.case(text)).describe()
    assert sum("mu_k = 0.9 is above mu_s = 0.4" in line for line in lines) == told


@pytest.mark.parametrize(("zipped", "told"), [('zip = [["mu_k", "mu_s"]]', 0), ("", 1)])
def test_values_that_never_meet_are_not_compared(zipped: str, told: int) -> None:
    """Where mu_s is 1.3 mu_k throughout, friction rises nowhere."""
    text = 'schema = 1\n[model]\nname = "flutter-2dof"\n[friction]\nlaw = "stribeck"\n'
    text += f"[grid]\nmu_k = [0.2, 0.4]\nmu_s = [0.26, 0.52]\n[sweep]\n{zipped}\n"
    lines = make_plan(sweep_fakes.case(text + '[[analysis]]\nkind = "eigenvalues"\n')).describe()
    assert sum("mu_k = 0.4 is above mu_s = 0.26" in line for line in lines) == told


@pytest.mark.parametrize(("kinetic", "told"), [([0.4, 0.2], 0), ([0.2, 0.4], 1)])
def test_values_of_a_law_that_advances_with_them_are_its_own(
    kinetic: list[float], told: int
) -> None:
    """What coulomb takes says nothing of stribeck."""
    text = (
        'schema = 1\n[model]\nname = "flutter-2dof"\n[grid]\nfriction = ["coulomb", "stribeck"]\n'
    )
    text += f"mu_k = {kinetic}\nmu_s = [0.3, 0.3]\n[sweep]\nzip = [['friction', 'mu_k', 'mu_s']]\n"
    lines = make_plan(sweep_fakes.case(text + '[[analysis]]\nkind = "eigenvalues"\n')).describe()
    assert sum("mu_k = 0.4 is above mu_s = 0.3: under stribeck" in line for line in lines) == told
