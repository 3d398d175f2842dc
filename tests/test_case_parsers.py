"""Laws of the small parsers under the case file: units, axes, line numbers, overrides."""

from __future__ import annotations

import math
import re
import tomllib
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fiv_cli.case.axes import AxisError, span_by_count, span_by_step
from fiv_cli.case.lines import locate
from fiv_cli.case.overrides import apply_overrides, parse_override
from fiv_cli.friction import all_laws, get_law, laws_of
from fiv_cli.models import all_models
from fiv_cli.notation.names import ascii_name, suggest
from fiv_cli.notation.units import UNITS, convert, exact, parse_unit

DECIMALS = st.decimals(-10_000, 10_000, allow_nan=False, places=4)
STEPS = st.decimals("0.0001", 10, allow_nan=False, places=4)


class TestUnits:
    @pytest.mark.parametrize(
        ("text", "unit", "value"),
        [
            ("20 rpm", "rad s-1", 20 * math.pi / 30),
            ("1 Hz", "rad s-1", 2 * math.pi),
            ("50 Hz", "Hz", 50.0),
            ("1 rev/min", "rad s-1", math.pi / 30),
            ("15 deg", "rad", math.pi / 12),
            ("180°", "rad", math.pi),
            ("5 mm", "m", 0.005),
            ("5e-3 m", "m", 0.005),
            ("0.5 kN", "N", 500.0),
            ("30N", "N", 30.0),
            ("1.5 N/mm", "N m-1", 1500.0),
            ("2 N s/m", "N s m-1", 2.0),
            ("2 N*s/m", "N s m-1", 2.0),
            ("2 kg/s", "N s m-1", 2.0),
            ("3 kg*m^2", "kg m2", 3.0),
            ("3 kg m²", "kg m2", 3.0),
            ("3 kg m**2", "kg m2", 3.0),
            ("3 g cm2", "kg m2", 3e-7),
            ("2 N m/rad", "N m", 2.0),
            ("2 N.m.s", "N m s", 2.0),
            ("7 GPa", "Pa", 7e9),
            ("30 ms", "s", 0.03),
            ("2 min", "s", 120.0),
            ("40 %", "1", 0.4),
            ("0.4", "1", 0.4),
            ("-.5", "N", -0.5),
            ("3 1/s", "s-1", 3.0),
        ],
    )
    def test_conversions(self, text: str, unit: str, value: float) -> None:
        assert convert(text, unit) == pytest.approx(value, rel=3e-16)

    @pytest.mark.parametrize(
        ("text", "unit"),
        [
            ("3 N", "kg"),
            ("3 Hz", "s-1"),
            ("3 rad", "1"),
            ("3 m", "rad"),
            ("3 N m", "N m-1"),
            ("3 m/s", "m s-2"),
        ],
    )
    def test_units_that_do_not_fit(self, text: str, unit: str) -> None:
        with pytest.raises(ValueError, match="does not fit"):
            convert(text, unit)

    @pytest.mark.parametrize(
        "text",
        [
            "",
            "N",
            "3 stone",
            "3 N/",
            "3 /N",
            "3 12",
            "nan",
            "inf",
            "1e999 N",
            "3 N^x",
            "0x10",
            "1_ N 2",
        ],
    )
    def test_nonsense(self, text: str) -> None:
        with pytest.raises(ValueError, match=r"."):
            convert(text, "N")

    def test_absurd_exponent_is_refused_at_once(self) -> None:
        with pytest.raises(ValueError, match="out of the range"):
            convert("1e999999999", "1")

    @given(st.floats(allow_nan=False, allow_infinity=False), st.sampled_from(sorted(UNITS)))
    def test_a_number_in_its_own_unit_keeps_every_bit(self, value: float, unit: str) -> None:
        assert convert(value, unit) == value
        assert convert(f"{value!r} {unit}", unit) == value

    @given(DECIMALS)
    def test_a_decimal_factor_gives_the_nearest_double(self, value: Decimal) -> None:
        assert convert(f"{value} mm", "m") == float(value / 1000)

    @given(st.sampled_from(sorted(UNITS)), st.sampled_from(sorted(UNITS)), st.integers(1, 3))
    def test_units_multiply(self, first: str, second: str, power: int) -> None:
        product = parse_unit(f"{first}{power} {second}-1")
        assert product == parse_unit(f"{first}^{power}/{second}")
        assert product == UNITS[first] ** power * UNITS[second] ** -1

    def test_every_unit_in_the_tables_can_be_parsed(self) -> None:
        owners = [*all_models().values(), *all_laws().values()]
        for parameter in (p for owner in owners for p in owner.parameters):
            assert parse_unit(parameter.unit).factor == 1, parameter


class TestAxes:
    @given(DECIMALS, STEPS, st.integers(0, 300))
    def test_stepped_values_are_the_decimals_written(
        self, start: Decimal, step: Decimal, gaps: int
    ) -> None:
        for step_ in (step, -step):
            span = span_by_step(Fraction(start), Fraction(start + gaps * step_), Fraction(step_))
            assert span.values() == [float(start + i * step_) for i in range(gaps + 1)]

    @given(DECIMALS, STEPS, st.integers(2, 300))
    def test_counted_values_include_both_ends(
        self, start: Decimal, step: Decimal, num: int
    ) -> None:
        stop = start + (num - 1) * step
        span = span_by_count(Fraction(start), Fraction(stop), num, "linear")
        assert span.values() == [float(start + i * step) for i in range(num)]
        assert span.second == span.values()[1]
        back = span_by_count(Fraction(stop), Fraction(start), num, "linear")
        assert back.values() == span.values()[::-1]

    @given(st.integers(-8, 8), st.integers(1, 8))
    def test_decades_are_exact(self, first: int, decades: int) -> None:
        start, stop = Fraction(10) ** first, Fraction(10) ** (first + decades)
        values = span_by_count(start, stop, decades + 1, "log").values()
        assert values == [float(f"1e{first + i}") for i in range(decades + 1)]
        assert span_by_count(stop, start, decades + 1, "log").values() == values[::-1]

    @given(STEPS, st.integers(2, 50))
    def test_logarithmic_values_rise_by_one_ratio(self, start: Decimal, num: int) -> None:
        span = span_by_count(Fraction(start), Fraction(start) * 7, num, "log")
        values = span.values()
        assert span.second == pytest.approx(values[1], rel=1e-14)
        ratios = [b / a for a, b in pairwise(values)]
        assert ratios == pytest.approx([7 ** (1 / (num - 1))] * (num - 1), rel=1e-14)
        assert (values[0], values[-1]) == (float(start), float(Fraction(start) * 7))

    def test_seventeen_steps_of_a_twentieth(self) -> None:
        span = span_by_step(exact(0.05, "1"), exact(2.95, "1"), exact(0.05, "1"))
        assert span.values()[17] == float("0.9")

    def test_a_missed_stop_names_the_nearest(self) -> None:
        with pytest.raises(AxisError, match=r"the nearest stops are 0\.9 and 1\.2") as caught:
            span_by_step(Fraction(0), Fraction(1), Fraction(3, 10))
        assert caught.value.key == "stop"

    @given(st.integers(1, 100), st.integers(1, 60), st.integers(1, 12))
    def test_a_stop_that_a_message_names_is_taken(self, start: int, count: int, per: int) -> None:
        """Of steps in a unit whose factor has no end, as 2 pi / 60 has none, and so is rounded."""
        unit = Fraction(6.283185307179586) / 60
        begin, step = start * unit, unit / per
        with pytest.raises(AxisError) as caught:
            span_by_step(begin, begin + (count + Fraction(2, 5)) * step, step)
        for named in re.findall(r"[\d.]+(?:e-?\d+)?(?= and|$)", str(caught.value)):
            values = span_by_step(begin, exact(named, "1"), step).values()
            assert values[-1] == float(named) and len(values) in (count + 1, count + 2)

    def test_one_value(self) -> None:
        one = Fraction(1)
        assert span_by_step(one, one, one).values() == [1.0]
        assert span_by_count(one, one, 1, "linear").values() == [1.0]
        assert span_by_count(one, one, 1, "log").values() == [1.0]


KEYS = st.text("abcXYZ019_-", min_size=1, max_size=5)
QUOTED = st.text(st.characters(exclude_categories=("Cs", "Cc")), max_size=6)
SCALARS = st.one_of(
    st.integers(-99, 99),
    st.booleans(),
    st.floats(allow_nan=False, allow_infinity=False, width=16),
    st.text(st.sampled_from(list("ab #[]{}=,.'\"\\\nΩ")), max_size=12),
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(KEYS | QUOTED, inner, max_size=3),
    max_leaves=6,
)
DOCUMENTS = st.dictionaries(KEYS | QUOTED, VALUES, max_size=5)


def quote(text: str) -> str:
    """A TOML basic string."""
    escapes = {"\\": "\\\\", '"': '\\"', "\n": "\\n"}
    return '"' + "".join(escapes.get(character, character) for character in text) + '"'


def write(value: Any) -> str:
    """A value in TOML, lists over several lines."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        multiline = "\n" in value and '"""' not in value and "\\" not in value
        return f'"""\n{value} """' if multiline else quote(value)
    if isinstance(value, list):
        return "[ # ]\n" + "".join(f"  {write(one)} ,\n" for one in value) + "]"
    if isinstance(value, dict):
        pairs = (f"{quote(key)} = {write_flat(one)}" for key, one in value.items())
        return "{ " + ", ".join(pairs) + " }"
    return repr(value)


def write_flat(value: Any) -> str:
    """A value on one line, as inline tables want it."""
    if isinstance(value, list):
        return "[" + ", ".join(write_flat(one) for one in value) + "]"
    if isinstance(value, str):
        return quote(value)
    return write(value)


class TestLines:
    @given(DOCUMENTS, st.integers(0, 3))
    def test_every_key_is_found_where_it_stands(
        self, document: dict[str, Any], blanks: int
    ) -> None:
        text, expected = "", {}
        for key, value in document.items():
            text += "# [comment]\n" + "\n" * blanks
            expected[(key,)] = text.count("\n") + 1
            text += f"{quote(key)} = {write(value)} # x = 1\n"
        assert set(tomllib.loads(text)) == set(document)
        found = locate(text)
        assert {path: found[path] for path in expected} == expected

    @given(st.lists(st.dictionaries(KEYS, SCALARS, max_size=3), min_size=1, max_size=4))
    def test_elements_of_arrays_of_tables(self, elements: list[dict[str, Any]]) -> None:
        text, expected = "", {}
        for index, element in enumerate(elements):
            expected[("a", index)] = text.count("\n") + 1
            text += "[[a]]\n"
            for key, value in element.items():
                expected[("a", index, key)] = text.count("\n") + 1
                text += f"{key} = {write(value)}\n"
            expected[("a", index, "sub table", "k")] = text.count("\n") + 2
            text += '[a."sub table"]\nk = 1\n'
        found = locate(text)
        assert {path: found[path] for path in expected} == expected

    def test_dotted_keys_inline_tables_and_lists(self) -> None:
        text = (
            "a.b . c = { d = 1, e.f = 2 }\n"
            "g = [\n  1,\n  { h = 3 },\n]\n"
            "[i.j]\nk = 1979-05-27 07:32:00 # x\n"
        )
        found = locate(text)
        assert found["a", "b", "c", "e", "f"] == 1
        assert found["g", 0] == 3
        assert found["g", 1, "h"] == 4
        assert found["i", "j", "k"] == 7


class TestOverrides:
    @given(st.lists(KEYS, min_size=1, max_size=4), VALUES)
    def test_what_is_set_is_there(self, keys: list[str], value: Any) -> None:
        override = parse_override(f"{'.'.join(keys)}={write_flat(value)}")
        assert override.keys == tuple(keys)
        changed, places, problems = apply_overrides({}, [override])
        assert not problems
        assert list(places) == [tuple(keys)]
        for key in keys:
            changed = changed[key]
        assert changed == value

    @given(st.from_regex(r"[A-Za-z][A-Za-z ]{0,8}[A-Za-z]", fullmatch=True))
    def test_a_bare_word_is_a_string(self, word: str) -> None:
        expected: Any = {"true": True, "false": False, "inf": math.inf}.get(word, word)
        value = parse_override(f"a={word}").value
        assert value == expected or (word == "nan" and math.isnan(value))

    def test_the_document_is_not_touched(self) -> None:
        document = {"a": {"b": 1}}
        apply_overrides(document, [parse_override("a.b=2")])
        assert document == {"a": {"b": 1}}


class TestNames:
    @pytest.mark.parametrize(
        ("name", "contract"),
        [
            ("Ω", "Omega"),
            ("\N{OHM SIGN}", "Omega"),
            ("ω", "omega"),
            ("μ_k", "mu_k"),
            ("\N{MICRO SIGN}_s", "mu_s"),
            ("φ_dot", "phi_dot"),
            ("ψ_a", "psi_a"),
            ("α_0", "alpha_0"),
            ("k₁", "k1"),
            ("N0", "N0"),
        ],
    )
    def test_greek(self, name: str, contract: str) -> None:
        assert ascii_name(name) == contract

    def test_case_goes_before_likeness(self) -> None:
        known = {"Omega": "disc speed", "omega": "frequency", "omegas": "more"}
        hint = suggest("OMEGA", known)
        assert hint == "did you mean 'Omega' (disc speed) or 'omega' (frequency)?"

    def test_nothing_alike(self) -> None:
        assert suggest("vs", ["v", "v_s", "m"]) == "did you mean 'v_s'?"
        assert suggest("xyzzy", ["mu_k"]) == ""

    def test_a_word_of_the_name_that_the_likest_lack_leads_to_another(self) -> None:
        hint = suggest("branch_end", ["branch_min", "cycle_period", "cycle_end"])
        assert hint == "did you mean 'branch_min' or 'cycle_end'?"

    def test_model_and_law_never_share_a_name(self) -> None:
        """A bare name means one parameter, so the two tables must not overlap."""
        for model in all_models().values():
            own = {parameter.name for parameter in model.parameters}
            own |= {option.name for option in model.options}
            for law in laws_of(model):
                assert not own & {parameter.name for parameter in get_law(law).parameters}
                states = {state.name for state in model.states(model.default_options())}
                assert not states & {state.name for state in get_law(law).states}
