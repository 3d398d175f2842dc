"""Asking every shipped class again: what counts as a change, on hand-made and real datasets."""

from __future__ import annotations

from pathlib import Path

import asked_again
import numpy as np
import pytest

from fiv_cli.case.load import load_case

SPEEDS = np.array([1.0, 2.0, 3.0])


def told(*classes: str) -> asked_again.Answers:
    return asked_again.Answers(("Omega",), {"Omega": SPEEDS}, np.array(classes, dtype=object))


def test_only_a_class_that_becomes_another_one_has_changed() -> None:
    before = told("periodic", "undecided", "equilibrium")
    after = told("equilibrium", "chaotic", "undecided")
    line, changed = asked_again.compared("pin", before, after)
    assert line == "pin: 3 points, decided 2 -> 2, changed 1"
    assert changed == ["Omega = 1.0: periodic -> equilibrium"]


def test_every_case_with_a_response_is_asked() -> None:
    asked = {path.stem for path in asked_again.cases()}
    assert {"fig_7_06_reached", "fig_3_13"} <= asked
    assert not {"modes", "critical_speed"} & asked


@pytest.mark.parametrize("path", asked_again.cases(["fig_7_03", "fig_6_11_thesis"]))
def test_a_case_is_asked_with_more_time_and_less_tolerance(path: Path) -> None:
    case = load_case(path)
    harder = load_case(path, asked_again.harder(case))
    assert harder.solver.rtol == pytest.approx(0.1 * case.solver.rtol)
    assert harder.solver.max_events == 2 * case.solver.max_events
    times = [
        [one.settings["t_max"] for one in asked.analyses if one.kind == "response"]
        for asked in (case, harder)
    ]
    assert times[1] == [2 * t_max for t_max in times[0]]


def test_a_case_is_asked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for _ in range(2):  # the second time from what is stored
        assert asked_again.main([str(tmp_path), "fig_7_02", "--workers", "1"]) == 0
        line, total = capsys.readouterr().out.splitlines()
        assert line == "fig_7_02 response: 1 points, decided 1 -> 1, changed 0"
        assert total == "0 classes changed"
