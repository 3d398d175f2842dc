"""What a system is made of: names or objects, defaults, and what makes two systems differ."""

from __future__ import annotations

from dataclasses import replace

import pytest

from fiv_cli.analyses.rest.averaging import averaged_system
from fiv_cli.codegen.generate import text_key
from fiv_cli.codegen.setup import Setup, default_parameters, taylor_order
from fiv_cli.dynamics.system import build_system
from fiv_cli.friction import get_law
from fiv_cli.models import get_model
from fiv_cli.schedule import make_schedule

BELT = Setup.of("belt-1dof", "stribeck")


def test_names_and_objects_mean_the_same() -> None:
    same = Setup.of(get_model("belt-1dof"), get_law("stribeck"))
    assert (same.key, text_key(same)) == (BELT.key, text_key(BELT))
    assert build_system(same) is build_system(BELT)
    assert Setup.of("belt-1dof").law is get_law(get_model("belt-1dof").default_law)
    assert get_law("tanh of coulomb") is get_law("tanh of coulomb")


def test_what_is_left_out_is_as_the_model_has_it() -> None:
    changed = Setup.of("belt-5dof", "coulomb", {"geometry": "linear"}, rtol=1e-6)
    assert changed.options == get_model("belt-5dof").default_options() | {"geometry": "linear"}
    assert changed.order == taylor_order(1e-6)
    assert BELT.structural == {"delta": default_parameters(BELT.model, BELT.law)["delta"]}


def test_options_have_no_order() -> None:
    given = {"impact": "plastic", "geometry": "linear"}
    first, second = (
        Setup.of("belt-5dof", "coulomb", dict(pairs))
        for pairs in (given.items(), reversed(given.items()))
    )
    assert (first.key, text_key(first)) == (second.key, text_key(second))


@pytest.mark.parametrize(
    "other",
    [
        Setup.of("belt-1dof", "coulomb"),
        Setup.of("belt-1dof", "tanh of stribeck"),
        Setup.of("belt-1dof", "stribeck", parameters={"delta": 7.0}),
        Setup.of("belt-1dof", "stribeck", rtol=1e-13),
        Setup.of("belt-1dof", "stribeck", schedule=make_schedule({"v": [(0.0, 1.0), (2.0, 3.0)]})),
    ],
    ids=["law", "regularised", "structural", "order", "schedule"],
)
def test_what_makes_another_system(other: Setup) -> None:
    assert other.key != BELT.key
    assert text_key(other) != text_key(BELT)


def test_two_models_of_one_name_are_two_systems() -> None:
    namesake = replace(BELT.model, title="another")
    assert replace(BELT, model=namesake).key != BELT.key


def test_a_schedule_of_other_values_shares_the_code() -> None:
    slow, fast = (
        replace(BELT, schedule=make_schedule({"v": [(0.0, 1.0), (end, 2.0)]})) for end in (9.0, 1.0)
    )
    assert slow.key != fast.key
    assert text_key(slow) == text_key(fast)


def test_followers_take_the_value_of_their_leader() -> None:
    disc, law = get_model("excited-disc"), get_law("exponential")
    (follower,) = [p for p in disc.adopted(law) if p.default_from is not None]
    assert follower.default_from is not None
    changed = default_parameters(disc, law, **{follower.default_from: 0.77})
    assert changed[follower.name] == 0.77
    assert default_parameters(disc, law, **{follower.name: 0.5})[follower.name] == 0.5


def test_an_averaged_system_is_made_once_for_each_way_of_slipping() -> None:
    system = build_system(Setup.of("excited-2dof", "coulomb"))
    one_way, reversing = (averaged_system(system, reverses) for reverses in (False, True))
    assert one_way is averaged_system(system, False)
    assert one_way.setup.law is not reversing.setup.law
