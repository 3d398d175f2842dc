"""The driver run by Python itself moves as the compiled one does, bit for bit."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from motions import motion
from numpy.typing import NDArray
from small_models import BOUNCER

from fiv_cli.analyses.base import SolverSettings
from fiv_cli.codegen.native import ARRAYS
from fiv_cli.dynamics import kernel
from fiv_cli.dynamics import motion as motions_of
from fiv_cli.dynamics.motion import Motion, samples_at
from fiv_cli.dynamics.settings import Section

LOOSE = SolverSettings(rtol=1e-6)
STEPWISE = SolverSettings("rk4", 1e-6, 0.05)
CASES: dict[str, Any] = {
    "belt": ("belt-1dof", {"x": 0.0}, LOOSE, {}, {}, 80.0, "x_dot"),
    "forced belt": (
        "belt-1dof", {"x": 0.0}, LOOSE, {}, {"u0": 0.5, "omega": 1.2}, 50.0, "x_dot",
    ),
    "belt, rk4": ("belt-1dof", {"x": 0.0}, STEPWISE, {}, {}, 20.0, "x_dot"),
    "impacts": (BOUNCER, {"z": 0.2, "x_dot": 0.3}, LOOSE, {}, {"A": 15.0}, 5.0, "z_dot"),
    "separation": (
        BOUNCER, {"z": 0.2, "x_dot": 0.3}, LOOSE, {"contact": "elastic"},
        {"A": 15.0, "k_c": 200.0}, 4.0, "z_dot",
    ),
    "sector": (
        "pin-on-disc", {"phi_dot": 2.0}, LOOSE, {}, {"beta": 2.0, "psi_a": 0.3}, 1.0, "phi_dot",
    ),
}  # fmt: skip


class PlainDriver:
    """Stands for the compiled driver: the same function, on the arrays that the frame shows."""

    def __init__(self) -> None:
        self.calls = 0

    def function(self, entry: Callable[..., int]) -> Callable[..., int]:
        """The kernel, to be called as its compiled form is."""

        def call(address: int, *given: Any) -> int:
            self.calls += 1
            with np.errstate(all="ignore"):
                return entry(arrays_at(address), *given)

        return call


def arrays_at(address: int) -> SimpleNamespace:
    """The arrays of a frame by name."""
    count = len(kernel.Run.words({}))
    words = list((ctypes.c_int64 * count).from_address(address))
    shown = {}
    for name, place in kernel.Run.places().items():
        element, depth = ARRAYS[kernel.Run.__annotations__[name]]
        start, shape = words[place], words[place + 1 : place + 1 + depth]
        if kernel.Run.__annotations__[name].startswith("Own"):
            start += address
        kind = ctypes.c_double if element is float else ctypes.c_int64
        data = (kind * int(np.prod(shape))).from_address(start)
        shown[name] = np.frombuffer(data, kind).reshape(shape)
    return SimpleNamespace(**shown)


def watched(name: str) -> tuple[Motion, dict[str, NDArray[Any]]]:
    """A motion of `CASES` in three pieces, watched in every way, and all that it leaves."""
    model, start, solver, options, changes, t_end, state = CASES[name]
    begun = motion(model, "coulomb", start, solver, options, **changes)
    n = len(begun.y)
    begun.start_measuring(np.full(len(begun.system.coordinates), 0.1))
    if solver.method == "taylor":
        begun.carry_tangents(np.eye(n)[:2])
    samples = samples_at(begun.system, np.linspace(0.0, t_end, 30))
    times, states = np.zeros(40), np.zeros((40, n))
    zero = Section("zero", state=state, direction="up")
    for share in (0.1, 0.5, 1.0):
        begun.run(share * t_end, zero, (times, states), samples, measuring=True)
    own = {part: begun.arrays.frame[where] for part, where in begun.layout.parts.items()}
    measured, filled = vars(begun.measures), vars(samples)
    others = {"ledger": begun.ledger, "tangents": begun.tangents, "met": states, "at": times}
    return begun, own | measured | filled | others


@pytest.mark.parametrize("name", CASES)
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


def test_the_cases_meet_stick_impacts_separation_sectors_and_sections() -> None:
    moved = {name: watched(name)[0] for name in CASES}
    codes = {name: begun.ledger[: begun.n_events, 1:3] for name, begun in moved.items()}
    assert kernel.CODE_STICK in codes["belt"]
    assert kernel.CODE_SEPARATION in codes["separation"]
    assert moved["impacts"].counters[kernel.IMPACTS] > 0
    assert np.any(codes["sector"][:, 0] == codes["sector"][:, 1])  # on a border nothing else
    assert all(begun.n_sections > 0 for begun in moved.values())
