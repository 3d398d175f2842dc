"""A mistake in a case is told once: what only follows from it is not."""

from __future__ import annotations

import pytest

from fiv_cli.case.load import parse_case
from fiv_cli.errors import CaseError, Problem

PIN = """\
schema = 1
[model]
name = "pin-on-disc"
[friction]
mu_s = 0.9
mu_k = 0.6
[grid]
Omega = { start = 0.5, stop = 4.5, step = 1.0 }
N0 = [10.0, 20.0]
c1 = [0.1, 0.2]
c2 = [0.1, 0.2]
[sweep]
zip = [["c1", "c2"]]
[[initial]]
label = "far"
kind = "state"
state = { phi_dot = "Omega" }
[[analysis]]
kind = "response"
section = { event = "stick->slip" }
t_max = 60.0
[[analysis]]
kind = "boundary"
parameter = "k1"
bracket = [10.0, 1000.0]
scan = 3
of = { variable = "attractor", expect = "not equilibrium" }
[[figure]]
kind = "map"
analysis = "response"
x = "Omega"
y = "N0"
select = { initial = "far" }
take = { what = "share", of = "not equilibrium", over = ["Omega"] }
[[figure]]
kind = "curve"
analysis = "boundary"
x = "N0"
[[claim]]
source = "7.3"
text = "sticks and slips"
variable = "attractor"
analysis = "response"
at = { Omega = 2.5, initial = "far" }
expect = "not equilibrium"
[[claim]]
source = "7.3"
text = "slides"
variable = "attractor"
analysis = "response"
at = { Omega = ". > 4", initial = "far" }
expect = "equilibrium"
"""

LAW = """\
schema = 1
[model]
name = "belt-1dof"
[friction]
law = "stribeck"
mu_s = 0.9
mu_k = 0.6
[friction.stribeck]
delta = 2
[grid]
v_s = [0.1, 0.2]
[sweep]
refine = { levels = 1, along = ["v_s"] }
[[analysis]]
kind = "response"
[[claim]]
source = "3.1.1"
text = "periodic"
variable = "attractor"
at = { v_s = 0.1 }
expect = "periodic"
"""

DISC = """\
schema = 1
[model]
name = "disc-rigid-contact"
options = { modes = [[0, 0], [0, 1], [0, 2]] }
[[initial]]
label = "far"
kind = "state"
state = { C_0_2 = 1e-3 }
[[analysis]]
kind = "response"
section = { zero = "C_0_2_dot" }
observe = "C_0_2"
[[analysis]]
kind = "history"
t_end = 1.0
points = [[0.1, 0.0]]
[[figure]]
kind = "phase"
[[figure]]
kind = "history"
variable = "w"
"""

FORCED = """\
schema = 1
[model]
name = "belt-1dof"
parameters = { u0 = 0.5, omega = 1.0 }
[[analysis]]
kind = "response"
section = { phase = 0.0 }
"""


def problems(text: str) -> tuple[Problem, ...]:
    with pytest.raises(CaseError) as caught:
        parse_case(text, "case.toml")
    return caught.value.problems


@pytest.mark.parametrize("text", [PIN, LAW, DISC, FORCED])
def test_the_cases_are_sound(text: str) -> None:
    assert parse_case(text, "case.toml").analyses


@pytest.mark.parametrize(
    ("text", "right", "wrong", "path"),
    [
        (PIN, "\nOmega =", "\nOmgea =", "grid.Omgea"),
        (PIN, "\nOmega =", "\nspeed =", "grid.speed"),
        (PIN, "\nN0 =", "\nNO =", "grid.NO"),
        (PIN, "\nc1 =", "\ncc1 =", "grid.cc1"),
        (PIN, '"response"\nsection', '"respnse"\nsection', "analysis.0.kind"),
        (PIN, 'kind = "response"', 'kind = "motion"', "analysis.0.kind"),
        (PIN, 'kind = "boundary"', 'kind = "bounday"', "analysis.1.kind"),
        (LAW, '"stribeck"', '"stribek"', "friction.law"),
        (LAW, '"stribeck"', '"dry"', "friction.law"),
        (PIN, '"pin-on-disc"', '"pin-on-disk"', "model.name"),
        (PIN, "mu_s = 0.9", "mus = 0.9", "friction.mus"),
        (PIN, "mu_s = 0.9", 'mu_s = "0.9 N"', "friction.mu_s"),
        (PIN, "[grid]", "[gird]", "gird"),
        (PIN, "[[initial]]", "[[intial]]", "intial"),
        (PIN, "[model]", "[modle]", "modle"),
        (PIN, "[[analysis]]", "[[analyis]]", "analyis"),
        (PIN, 'kind = "state"', 'kind = "stat"', "initial.0.kind"),
        (PIN, 'label = "far"', "label = 1", "initial.0.label"),
        (DISC, "modes = [[0, 0], [0, 1]", "modes = [[0, 0], [0, 0.5]", "model.options.modes"),
        (DISC, "modes =", "mods =", "model.options.mods"),
        (PIN, "{ start = 0.5", "{ strat = 0.5", "grid.Omega.strat"),
        (PIN, "zip =", "zp =", "sweep.zp"),
        (PIN, '[["c1", "c2"]]', '[["c1", "cc2"]]', "sweep.zip.0"),
        (PIN, "c1 = [0.1, 0.2]", 'c1 = [0.1, "0.2 m"]', "grid.c1.1"),
        (PIN, 'event = "stick->slip"', 'event = "stick-slip"', "analysis.0.section.event"),
        (PIN, 'name = "pin', 'nane = "pin', "model.nane"),
        (PIN, 'event = "stick', 'evnt = "stick', "analysis.0.section.evnt"),
        (PIN, "parameter =", "paramter =", "analysis.1.paramter"),
        (PIN, "of = {", "off = {", "analysis.1.off"),
        (PIN, 'kind = "boundary"', 'knd = "boundary"', "analysis.1.knd"),
        (PIN, 'kind = "boundary"', 'nane = "boundary"\nkind = "boundary"', "analysis.1.nane"),
        (PIN, '"pin-on-disc"', '"disc"', "model.name"),
        (PIN, 'over = ["Omega"]', 'ovr = ["Omega"]', "figure.0.take.ovr"),
        (PIN, 'label = "far"', 'lable = "far"', "initial.0.lable"),
        (LAW, 'law = "stribeck"', 'law = "tahn"\nof = "stribeck"', "friction.law"),
        (PIN, "schema = 1", "scema = 1", "scema"),
        (PIN, 'analysis = "response"\nx', 'analysis = "reponse"\nx', "figure.0.analysis"),
        (LAW, 'law = "stribeck"', 'lw = "stribeck"', "friction.lw"),
        (DISC, "points = ", "ponts = ", "analysis.1.ponts"),
        (FORCED, '"belt-1dof"', '"belt-dof"', "model.name"),
        (FORCED, "u0 =", "uo =", "model.parameters.uo"),
        (FORCED, "parameters = { u0 = 0.5,", "parameters = { u0 = true,", "model.parameters.u0"),
    ],
)
def test_each_mistake_is_told_once(text: str, right: str, wrong: str, path: str) -> None:
    assert right in text
    (problem,) = problems(text.replace(right, wrong))
    assert problem.path == path
    assert problem.line is not None


def test_a_second_mistake_is_told_beside_the_first() -> None:
    text = PIN.replace("\nOmega =", "\nOmgea =").replace('at = { Omega = ". > 4"', "at = { Om = 4")
    assert {problem.path for problem in problems(text)} == {"grid.Omgea", "claim.1.at.Om"}


def test_a_name_that_is_wrong_in_several_places_is_one_problem() -> None:
    with pytest.raises(CaseError) as caught:
        parse_case(PIN.replace('"far"\nkind', '"fra"\nkind'), "a")
    assert {problem.path for problem in caught.value.problems} == {
        "figure.0.select.initial",
        "claim.0.at.initial",
        "claim.1.at.initial",
    }
    text = str(caught.value)
    assert text.startswith("a: 1 problem;")
    assert "likewise: claim.0.at.initial (line 44), claim.1.at.initial (line 51)" in text
    assert text.count("there is no start 'far'") == 1


def test_a_misspelt_axis_and_its_users_are_one_problem() -> None:
    text = PIN.replace("\nOmega =", "\nOmgea =").replace("at = { Omega", "at = { Omgea")
    with pytest.raises(CaseError) as caught:
        parse_case(text, "a")
    assert str(caught.value).startswith("a: 1 problem;")
    assert "likewise: claim.0.at.Omgea" in str(caught.value)
