"""What makes two cases, or two points, the same."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from fiv_cli.case import identity
from fiv_cli.case.case import Case
from fiv_cli.case.identity import (
    default_output,
    differences,
    digest,
    document,
    fingerprint,
    is_of,
)
from fiv_cli.case.load import parse_case

TEXT = """\
schema = 1
[model]
name = "belt-1dof"
[grid]
v = [1.0, 2.0]
[[initial]]
label = "near"
kind = "equilibrium"
[[analysis]]
kind = "response"
[[analysis]]
kind = "equilibrium"
"""


def parse(*overrides: str, text: str = TEXT) -> Case:
    return parse_case(text, "configs/ch3/belt.toml", overrides)


class TestFingerprint:
    @pytest.mark.parametrize(
        "override",
        ["grid.v=[1.0, 2.0, 3.0]", "title=other", "reference=other", 'assumed=["x"]'],
    )
    def test_what_does_not_count(self, override: str) -> None:
        assert fingerprint(parse(override)) == fingerprint(parse())

    @pytest.mark.parametrize(
        ("override", "place"),
        [
            ("model.parameters.m=2", "parameters.m"),
            ("friction.law=stribeck", "law"),
            ("analysis.response.t_max=10", "analyses.response.settings.t_max"),
            ("solver.rtol=1e-10", "solver.rtol"),
            ("initial.near.offset.x=1e-3", "starts.near.offset.x"),
            ("grid.c=[0.0, 1.0]", "axes"),
        ],
    )
    def test_what_counts_is_named(self, override: str, place: str) -> None:
        changed = parse(override)
        assert fingerprint(changed) != fingerprint(parse())
        found = differences(document(parse()), changed)
        assert any(line.startswith(f"{place}: ") for line in found)

    def test_no_differences_from_itself(self) -> None:
        assert differences(document(parse()), parse("grid.v=[7.0]")) == []

    def test_a_section_is_told_as_a_case_writes_it(self) -> None:
        named = parse("analysis.response.section.zero=x_dot")
        (told,) = differences(document(named), parse())
        assert told == (
            'analyses.response.settings.section: stored { zero = "x_dot", direction = "both" }, '
            'now { event = "any" }, as where a case names none'
        )

    def test_an_analysis_may_be_added_and_none_taken_away_or_changed(self) -> None:
        case = parse()
        assert differences(document(case, case.analyses[1:]), case) == []
        fewer = parse(text=TEXT.removesuffix('[[analysis]]\nkind = "equilibrium"\n'))
        (told,) = differences(document(case), fewer)
        assert told == "analyses.equilibrium: stored, now absent"

    def test_a_chain_of_starts_may_be_added_like_any_other(self) -> None:
        """That it is followed in steps is nothing of the others."""
        chain = 'kind = "continue", along = "v", direction = "up", from = "near"'
        longer = parse(text=TEXT + "[[initial]]\nlabel = 'up'\n" + chain.replace(", ", "\n"))
        assert differences(document(parse()), longer) == []
        attributes = {"fingerprint": fingerprint(parse())} | {
            name: json.dumps(dict.fromkeys(labels))
            for name, labels in (
                ("analyses_json", [one.name for one in longer.analyses]),
                ("starts_json", [one.label for one in parse().starts]),
            )
        }
        assert is_of(attributes, longer)
        assert document(longer)["numerics"].keys() - document(parse())["numerics"].keys()

    def test_starts_do_not_count_where_there_are_none(self) -> None:
        changed = parse("initial.near.offset.x=1e-3")
        before, after = (fingerprint(one, one.analyses[1:]) for one in (parse(), changed))
        assert before == after

    def test_numerics_version_counts(self, monkeypatch: pytest.MonkeyPatch) -> None:
        before = fingerprint(parse())
        monkeypatch.setattr(identity, "NUMERICS_VERSION", identity.NUMERICS_VERSION + 1)
        assert fingerprint(parse()) != before

    def test_an_option_that_came_later_counts_only_where_it_is_not_at_its_default(self) -> None:
        text = TEXT.replace("belt-1dof", "flutter-2dof")
        before, same, changed = (
            parse(*overrides, text=text)
            for overrides in ((), ("model.options.impact=plastic",), ("model.options.impact=none",))
        )
        assert document(before)["options"] == {"states": "until-separation"}
        assert fingerprint(same) == fingerprint(before)
        told = differences(document(before), changed)
        assert told == ['options.impact: now "none", absent in what is stored']

    def test_an_axis_of_laws_may_grow(self) -> None:
        few = parse('grid.friction=["coulomb"]')
        more = parse('grid.friction=["coulomb", "hyperbolic", "stribeck"]')
        assert fingerprint(few) == fingerprint(more)

    def test_a_laws_own_parameter_counts_on_an_axis_of_laws(self) -> None:
        laws = 'grid.friction=["stribeck", "hyperbolic"]'
        for value in ("1.0", "2.0"):
            changed = parse(laws, f"friction.hyperbolic.delta={value}")
            assert fingerprint(changed) != fingerprint(parse(laws))


class TestOutput:
    def test_stem(self) -> None:
        assert default_output(parse()) == Path("runs/belt.nc")

    def test_overrides_get_a_file_of_their_own(self) -> None:
        output = default_output(parse("solver.rtol=1e-8"))
        assert output.parent == Path("runs")
        assert output.name.startswith("belt-")
        assert output != default_output(parse("solver.rtol=1e-7"))

    def test_digest_is_of_what_is_set(self) -> None:
        assert digest(["a=1.0", "b=2"]) == digest(["b = 2", "a=1.00"])
        assert digest(["a=1", "a=2"]) == digest(["a=2"])
        assert digest(["a=1"]) != digest(["a=2"])
