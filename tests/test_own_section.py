"""A case that names no section: the motion chooses one that it has, and the dataset says which."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest

from fiv_cli import api
from fiv_cli.analyses.base import Outcome
from fiv_cli.case.identity import fingerprint
from fiv_cli.flags import advice
from fiv_cli.friction import laws_of
from fiv_cli.models import all_models

STICKS = {"event": "slip->stick"}
STIFF_WALL = {"k1": 50.0, "D": 0.02}
STIFF = {"F": 800.0, "k_nl": 1e7, "k4": 5e6, "k5": 5e6, "k6": 5e6, "mu_s": 3.0, "mu_k": 2.5}
SLOW = {"N": 0.01, "N2": 20.0, "v": 0.1, "D": 0.3}  # its period, 132 s, is that of no mode
SHAKEN = {"v": 5.0, "u0": 0.5, "omega": 1.6, "c": 0.1}

# model, law, start, options, parameters, state observed, section that the motion has
CHOICES: list[Any] = [
    ("belt-1dof", "coulomb", {"x": 10.0}, {}, {}, "x", STICKS),
    ("belt-2mass", "coulomb", {"x2": 8.0}, {}, STIFF_WALL, "x2", STICKS | {"contact": 2}),
    ("belt-5dof", "coulomb", {}, {"states": "slip"}, STIFF, "x1", "x1_dot"),
    ("belt-1dof", "coulomb", {"x": 0.01}, {}, SHAKEN, "x", "x_dot"),
    ("belt-1dof", "tanh of linear-slope", {"x": 1.0}, {}, {}, "x_dot", "x_dot"),
    ("belt-2mass", "stribeck", {}, {}, SLOW, "x2", STICKS | {"contact": 2}),
]


def bits(outcome: Outcome) -> Mapping[str, bytes]:
    """Everything that a dataset keeps, but for what tells of the choice."""
    stored = {**outcome.values, **outcome.ragged, "reason": outcome.reason}
    chosen = ("section_kind", "section_contact")
    return {n: np.asarray(v).tobytes() for n, v in stored.items() if n not in chosen}


@pytest.mark.parametrize(("model", "law", "start", "options", "changes", "observe", "own"), CHOICES)
def test_the_motion_is_told_what_a_case_that_names_its_section_is_told(
    model: str, law: str, start: Any, options: Any, changes: Any, observe: str, own: Any
) -> None:
    def response(**settings: Any) -> Outcome:
        asked = {"observe": observe, "t_max": 2000.0, **settings}
        return api.analyse(model, law, "response", start, asked, options=options, **changes)

    named = {"zero": own, "direction": "up"} if isinstance(own, str) else own
    found = response()
    assert found.values["attractor"] == "periodic" and len(found.ragged["section_value"])
    assert bits(found) == bits(response(section=named))
    kind = "turning_point" if isinstance(own, str) else "slip_to_stick"
    contact = None if isinstance(own, str) else own.get("contact", 1)
    assert (found.values["section_kind"], found.values.get("section_contact")) == (kind, contact)


def test_where_nothing_goes_on_there_is_no_section() -> None:
    found = api.analyse("belt-1dof", "coulomb", "response", {"x": 2.5}, c=0.1)
    assert found.values["attractor"] == "equilibrium" and "section_kind" not in found.values


def test_a_slide_that_has_not_settled_is_no_torus() -> None:
    """Forced, hardly damped and linear, it is periodic in the end, whatever section is asked."""

    def slide(**settings: Any) -> Outcome:
        forced = {"v": 5.0, "u0": 0.5, "omega": 1.618, "c": 1e-4}
        asked = {"t_max": 1000.0, **settings}
        return api.analyse("belt-1dof", "coulomb", "response", {"x": 2.5}, asked, **forced)

    named, found = slide(section={"zero": "x_dot", "direction": "up"}), slide()
    assert named.values["attractor"] == "undecided"
    assert (found.values["attractor"], found.reason) == ("undecided", "slide_not_decided")


def belt(**settings: Any) -> dict[str, Any]:
    """A case of the simplest belt."""
    analysis = {"kind": "response", **settings}
    return {"schema": 1, "model": {"name": "belt-1dof"}, "analysis": [analysis]}


def test_a_section_that_the_motion_chooses_is_another_case() -> None:
    asked, named = (
        fingerprint(api.load(belt(section={"event": e}))) for e in ("any", "slip->stick")
    )
    assert asked == fingerprint(api.load(belt())) != named


@pytest.mark.parametrize("model", [m for m in all_models().values() if m.contacts])
def test_what_an_undecided_motion_is_advised_passes_check(model: Any) -> None:
    case = belt() | {"model": {"name": model.name}}
    tanh = next((law.removeprefix("tanh of ") for law in laws_of(model) if "tanh" in law), None)
    if tanh:
        case["friction"] = {"law": "tanh", "of": tanh}
    api.load(case)
    assert '{ zero = "x_dot" } for a displacement x' in advice("no_section_points")
    for state in model.states(model.default_options()):
        case["analysis"] = [{"kind": "response", "section": {"zero": f"{state.name}_dot"}}]
        api.load(case)


@pytest.mark.parametrize("choice", [CHOICES[0], CHOICES[1], CHOICES[3]])
def test_a_cycle_is_reported_at_a_section_that_it_has(choice: Any) -> None:
    model, law, start, options, changes, observe, own = choice

    def cycle(**settings: Any) -> Outcome:
        asked = {"observe": observe, "t_max": 200.0, "transient": 100.0, **settings}
        return api.analyse(model, law, "cycle", start, asked, options=options, **changes)

    named = {"zero": own, "direction": "up"} if isinstance(own, str) else own
    found = cycle()
    assert found.values["multiplicity"] >= 1 and bits(found) == bits(cycle(section=named))
    kind = "turning_point" if isinstance(own, str) else "slip_to_stick"
    assert found.values["section_kind"] == kind


def test_a_chain_of_cycles_keeps_the_section_of_its_first() -> None:
    """Along it nothing else is looked for: a cycle of the second mass alone."""
    up = {"label": "up", "kind": "continue", "along": "v", "from": "far"}
    case = {
        "schema": 1, "friction": {"law": "coulomb"},
        "model": {"name": "belt-2mass", "parameters": STIFF_WALL},
        "grid": {"v": [1.0, 1.01, 1.02]},
        "initial": [{"label": "far", "kind": "state", "state": {"x2": 8.0}}, up],
        "analysis": [{"kind": "cycle", "observe": "x2", "t_max": 200.0, "transient": 100.0}],
    }  # fmt: skip
    found = api.run(api.load(case), workers=1).sel(initial="up")
    assert found["section_contact"].values.tolist() == [2, 2, 2]
    assert (found["multiplicity"] >= 1).all() and (found["residual"] < 1e-9).all()
