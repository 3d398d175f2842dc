"""`fiv verify`: every answer known without this program, and what the command makes of them."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

import pytest

from fiv_cli import verify as known
from fiv_cli.cli.main import run

LONG = (known.main_frequencies_on_a_disc,)  # which `fiv verify` asks too


@pytest.mark.parametrize(
    "problem",
    [
        pytest.param(problem, marks=[pytest.mark.campaign] * (problem in LONG), id=problem.__name__)
        for problem in known.PROBLEMS
    ],
)
def test_known_answers(problem: Any) -> None:
    checks = known.verify(problems=(problem,))
    assert len(checks) > 0
    assert [check for check in checks if not check.passed] == []


def test_the_checks_are_distinct_and_their_tolerances_tight() -> None:
    checks = known.verify(problems=(known.coulomb_belt, known.den_hartog, known.pin_equilibrium))
    assert len({check.name for check in checks}) == len(checks)
    assert all(0.0 <= check.tolerance <= 1e-4 * max(abs(check.expected), 1.0) for check in checks)


@pytest.mark.parametrize(
    ("found", "passed"), [(1.0, True), (1.0 + 1e-12, True), (1.01, False), (math.nan, False)]
)
def test_a_check_passes_within_its_tolerance_only(found: float, passed: bool) -> None:
    assert known.Check("name", "source", found, 1.0, 1e-9).passed is passed


def wrong(bench: object) -> Iterator[known.Check]:
    """A problem with one wrong answer."""
    yield known.Check("right", "somewhere", 1.0, 1.0, 1e-9)
    yield known.Check("wrong", "somewhere", 1.1, 1.0, 1e-9)


def broken(bench: object) -> Iterator[known.Check]:
    """A problem that cannot be computed."""
    yield known.Check("right", "somewhere", 1.0, 1.0, 1e-9)
    raise ValueError("no such answer")


def test_a_problem_that_cannot_be_computed_has_failed() -> None:
    (check,) = known.verify(problems=(broken,))
    assert not check.passed
    assert check.error == math.inf
    assert check.name == "broken: ValueError: no such answer"


def test_verify_prints_a_table(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(known, "PROBLEMS", (known.negative_slope,))
    assert run(["verify"]) == 0
    printed = capsys.readouterr()
    assert printed.out.count(" ok") == 3
    assert "3 of 3 checks passed" in printed.err


@pytest.mark.parametrize("problem", [wrong, broken])
def test_verify_fails_with_code_5(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], problem: Any
) -> None:
    monkeypatch.setattr(known, "PROBLEMS", (problem,))
    assert run(["verify"]) == 5
    assert "FAILED" in capsys.readouterr().out


def test_verify_as_json(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(known, "PROBLEMS", (wrong, broken))
    assert run(["verify", "--json"]) == 5
    document = json.loads(capsys.readouterr().out)
    assert document["passed"] is False
    assert [check["passed"] for check in document["checks"]] == [True, False, False]
    assert document["checks"][-1]["found"] is None
