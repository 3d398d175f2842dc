"""The first root of a polynomial on [0, 1]: none missed, none invented."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from numpy.typing import NDArray

from fiv_cli.codegen import emit
from fiv_cli.codegen.compiled import Compiled
from fiv_cli.codegen.generate import load_text
from fiv_cli.dynamics import roots

AMBIGUOUS = 1e-6  # complex pairs this close to the real axis, or roots this close to a border
DOUBLE = 1e-7  # a double root is known to the root of rounding only, see `known_to`
ROOT = st.floats(0.02, 0.98)


def search_at(address: int) -> Any:
    """The frame at an address."""
    return roots.Search.at(address)


def first_root_at(address: int, degree: int, total: float, end: float) -> float:
    """`roots.first_root` of the polynomial of the search at an address."""
    return root(search_at(address), degree, total, end)


root = roots.first_root


def declared() -> Callable[..., float]:
    """The entry, numba told of what it calls."""
    from fiv_cli.codegen.kernels import register, register_frame

    register_frame(roots.Search, search_at)
    register(roots)
    return first_root_at


FILES = (Path(roots.__file__), Path(__file__))
ROOTS = Compiled("roots", "float64(int64, int64, float64, float64)", FILES, declared)


@cache
def generated(degree: int) -> tuple[int, int]:
    """Addresses of the generated functions of polynomials of this degree."""
    lines = emit.value_slope_bend("value_slope_bend", degree) + emit.bernstein("bernstein", degree)
    engine = load_text("\n".join(lines) + "\n")
    KEPT.append(engine)
    value_slope_bend, bernstein = map(
        engine.get_function_address, ("value_slope_bend", "bernstein")
    )
    return int(value_slope_bend), int(bernstein)


KEPT: list[object] = []  # code whose address is in use


def first_root(coefficients: NDArray[np.float64] | list[float]) -> float:
    """`roots.first_root` of a polynomial in rising powers."""
    degree, top = len(coefficients) - 1, max(len(coefficients) - 1, 2)
    search = roots.Search.holding(roots.scratch(top), {})
    search.order, (search.value_slope_bend, search.bernstein) = top, generated(top)
    search.polynomial[: degree + 1] = coefficients
    total, end = float(np.sum(np.abs(coefficients))), float(np.sum(coefficients))
    return ROOTS.function(search.address, degree, total, end)


def with_roots(*places: float, beyond: tuple[float, ...] = ()) -> NDArray[np.float64]:
    """Coefficients in rising powers of a polynomial, positive at 0, with these roots."""
    rising = np.polynomial.polynomial.polyfromroots([*places, *beyond])
    return rising if rising[0] > 0.0 else -rising


def known_to(place: float, beyond: float) -> float:
    """How well rounding lets a double root of (x - place)^2 (beyond - x) be known.

    That far from it the polynomial is what rounding its coefficients may amount to.
    """
    total = (1.0 + place) ** 2 * (1.0 + beyond)
    return float(np.sqrt(roots.ROUNDING * total / (beyond - place)))


def companion_root(coefficients: NDArray[np.float64]) -> float | None:
    """First root in [0, 1] by companion-matrix eigenvalues; None where that is ill-conditioned."""
    found = np.roots(coefficients[::-1])
    inside = (found.real > -AMBIGUOUS) & (found.real < 1.0 + AMBIGUOUS)
    real = np.abs(found.imag) < 1e-12
    doubtful = inside & ~real & (np.abs(found.imag) < 1e-3)
    borders = inside & (np.minimum(np.abs(found.real), np.abs(found.real - 1.0)) < AMBIGUOUS)
    if doubtful.any() or (borders & real).any():
        return None
    candidates = np.sort(found[inside & real].real)
    if len(candidates) > 1 and np.min(np.diff(candidates)) < 1e-3:
        return None
    return float(candidates[0]) if len(candidates) else roots.NO_ROOT


def random_polynomials(count: int) -> NDArray[np.float64]:
    """Coefficients of falling size, positive at the start; shape (count, 15)."""
    random = np.random.default_rng(1)
    size = random.uniform(0.2, 2.0, (count, 1)) ** np.arange(15)
    coefficients = random.normal(size=(count, 15)) * size
    coefficients[:, 0] = np.abs(coefficients[:, 0]) + 1e-3
    return coefficients


@pytest.mark.parametrize("count", [5_000, pytest.param(20_000, marks=pytest.mark.campaign)])
def test_random_polynomials_have_the_roots_of_their_companion_matrices(count: int) -> None:
    compared = 0
    for coefficients in random_polynomials(count):
        expected = companion_root(coefficients)
        if expected is not None:
            compared += 1
            assert first_root(coefficients) == pytest.approx(expected, abs=1e-9)
    assert compared > 0.75 * count


@given(first=ROOT, second=ROOT, third=st.floats(1.5, 5.0))
def test_the_first_of_several_roots_is_found(first: float, second: float, third: float) -> None:
    assume(abs(first - second) > 1e-4)
    found = first_root(with_roots(first, second, beyond=(third, -third)))
    assert found == pytest.approx(min(first, second), abs=1e-9)


@given(place=st.floats(0.05, 0.95), beyond=st.floats(1.5, 5.0))
def test_close_pairs_are_separated(place: float, beyond: float) -> None:
    found = first_root(with_roots(place, place + 1e-6, beyond=(beyond,)))
    assert found == pytest.approx(place, abs=2e-8)


@given(place=st.floats(0.05, 0.95), beyond=st.floats(1.5, 5.0))
def test_pairs_that_rounding_cannot_tell_from_a_touch_are_not_lost(
    place: float, beyond: float
) -> None:
    found = first_root(with_roots(place, place + 1e-7, beyond=(beyond,)))
    known = known_to(place, beyond)
    assert place - known <= found <= place + 1e-7 + known


@given(place=st.floats(0.05, 0.95), beyond=st.floats(1.5, 5.0))
def test_double_roots_are_found(place: float, beyond: float) -> None:
    found = first_root(with_roots(place, place, beyond=(beyond,)))
    assert found == pytest.approx(place, abs=known_to(place, beyond))


@given(place=ROOT, clearance=st.floats(1e-11, 1e-2))
def test_near_misses_are_no_roots(place: float, clearance: float) -> None:
    coefficients = with_roots(place, place)
    coefficients[0] += clearance
    assert first_root(coefficients) == roots.NO_ROOT


@pytest.mark.parametrize(
    ("coefficients", "expected"),
    [
        ([1.0, -1.0], 1.0),
        ([1.0, -2.0, 1.0], 1.0),
        ([0.99999**2, -2 * 0.99999, 1.0], 0.99999),
        ([1.0, -0.9999999], roots.NO_ROOT),
        ([0.0, 1.0], 0.0),
        ([-1e-3, 1.0], 0.0),
        ([1.0, -4.0, 0.0, 0.0, 0.0, 0.0], 0.25),
        ([1.0, 0.0, 0.0], roots.NO_ROOT),
        ([1.0], roots.NO_ROOT),
    ],
    ids=[
        "at the end", "double at the end", "double before the end", "just beyond the end",
        "at the start", "negative start", "degree below order", "constant", "degree zero",
    ],
)  # fmt: skip
def test_borders(coefficients: list[float], expected: float) -> None:
    assert first_root(coefficients) == pytest.approx(expected, abs=DOUBLE)


@given(scale=st.integers(-200, 200), place=ROOT, beyond=st.floats(1.5, 5.0))
def test_the_root_does_not_depend_on_units(scale: int, place: float, beyond: float) -> None:
    coefficients = with_roots(place, beyond=(beyond, -0.7))
    assert first_root(coefficients * 2.0**scale) == first_root(coefficients)
