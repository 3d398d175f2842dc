"""Settings of analyses: what a type shows of itself is what it reads."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator

import pytest

from fiv_cli.analyses import all_analyses
from fiv_cli.analyses.settings import Setting, TableSetting
from fiv_cli.case.analysis import Surroundings
from fiv_cli.friction import get_law
from fiv_cli.models import get_model

DISC = get_model("disc-rigid-contact")
CASE = Surroundings(
    DISC, DISC.default_options(), (get_law(DISC.default_law),), varied=DISC.parameters[0].name
)

# What no setting takes: none is a time, a date or an empty list.
NOTHING_TAKES: list[object] = [tomllib.loads("x = 2001-01-01")["x"], [], float("nan")]


def every_setting() -> Iterator[Setting]:
    """The settings of all analyses, those of tables in them included."""
    for analysis in all_analyses().values():
        for setting in analysis.settings:
            yield setting
            yield from setting.keys if isinstance(setting, TableSetting) else ()


SETTINGS = {f"{type(one).__name__}-{one.name}-{one.default}": one for one in every_setting()}
each = pytest.mark.parametrize("setting", SETTINGS.values(), ids=SETTINGS.keys())


@each
def test_an_example_is_read_and_a_default_reads_as_itself(setting: Setting) -> None:
    value = tomllib.loads(f"x = {setting.example(DISC, DISC.parameters[0])}")["x"]
    found = setting.read(value, CASE)
    assert found.refusals == ()
    if setting.default is not None:
        assert found.value == setting.default


@each
@pytest.mark.parametrize("value", NOTHING_TAKES, ids=repr)
def test_what_is_refused_says_what_is_allowed(setting: Setting, value: object) -> None:
    found, (refusal,) = setting.read(value, CASE)
    assert refusal.message and setting.meaning in refusal.allowed
    assert found == setting.default


@each
def test_what_must_be_given_is_missed(setting: Setting) -> None:
    assert [one.message for one in setting.left_out(CASE).refusals] == (
        ["is missing"] if setting.required else []
    )
