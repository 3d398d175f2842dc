"""The driver run by Python itself moves as the compiled one does, bit for bit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from motions import ledger, motion
from watched import LOOSE, SMALL, watched

from fiv_cli.codegen.codes import CODE_SEPARATION, CODE_STICK
from fiv_cli.dynamics import motion as motions_of
from fiv_cli.dynamics.compiled import advance_at


class PlainDriver:
    """Stands for the compiled driver: the same function, run by Python."""

    def __init__(self) -> None:
        self.calls = 0

    def function(self, *given: Any) -> int:
        """As the compiled form is called."""
        self.calls += 1
        with np.errstate(all="ignore"):
            return advance_at(*given)


@pytest.mark.parametrize("name", SMALL)
def test_python_moves_as_the_machine_code_does(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    begun, compiled = watched(name)
    driver = PlainDriver()
    monkeypatch.setattr(motions_of, "DRIVER", driver)
    again, plain = watched(name)
    assert driver.calls == 4  # the beginning, three pieces
    assert begun.n_events >= 5
    assert (begun.n_events, begun.n_steps) == (again.n_events, again.n_steps)
    for part, expected in compiled.items():
        np.testing.assert_array_equal(plain[part], expected, err_msg=part)


@pytest.mark.parametrize("law", ["gms", "bristle"])
def test_pieces_of_laws_change_as_in_the_machine_code(
    law: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    moved = []
    for _ in range(2):
        begun = motion("belt-1dof", law, {"x": 0.3}, LOOSE, v=0.3)
        begun.carry_tangents(np.eye(len(begun.y))[:2])
        begun.run(0.5)
        moved.append((begun.y, begun.frame.in_piece, begun.tangents, ledger(begun)))
        monkeypatch.setattr(motions_of, "DRIVER", PlainDriver())
    assert len(moved[0][-1]) > 10
    for plain, compiled in zip(*moved, strict=True):
        np.testing.assert_array_equal(plain, compiled)


def test_the_cases_meet_stick_impacts_separation_sectors_and_sections() -> None:
    moved = {name: watched(name)[0] for name in SMALL}
    codes = {name: ledger(begun)[:, 1:3] for name, begun in moved.items()}
    assert CODE_STICK in codes["belt"]
    assert CODE_SEPARATION in codes["separation"]
    assert moved["impacts"].frame.n_impacts > 0
    assert np.any(codes["sector"][:, 0] == codes["sector"][:, 1])  # on a border nothing else
    assert all(begun.n_sections > 0 for begun in moved.values())
