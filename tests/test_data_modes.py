"""Modes followed through crossings, mergers and grids of several axes."""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

import numpy as np
import pytest
import xarray as xr
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from fiv_cli.analyses.rest.modes import followed as matched
from fiv_cli.analyses.rest.modes import modes_of
from fiv_cli.api import analyse, load, run
from fiv_cli.data.dataset import Dataset
from fiv_cli.data.modes import coupling_points, follow_grid
from fiv_cli.data.modes import follow_modes as follow

Complex = NDArray[np.complex128]
FLUTTER = 5 / 2 + sqrt(3)


def shuffled(values: Complex, vectors: Complex, seed: int = 3) -> tuple[Complex, Complex]:
    """The modes of each point in a random order, but for the very first point."""
    generator = np.random.default_rng(seed)
    values, vectors = values.copy(), vectors.copy()
    for place in list(np.ndindex(values.shape[:-1]))[1:]:
        order = generator.permutation(values.shape[-1])
        values[place], vectors[place] = values[place][order], vectors[place][order]
    return values, vectors


def followed(values: Complex, vectors: Complex) -> Complex:
    """The eigenvalues in the order that `follow_grid` finds."""
    return np.take_along_axis(values, follow_grid(values, vectors), axis=-1)


def flutter(friction: NDArray[np.float64], **changes: float) -> tuple[Complex, Complex]:
    """Eigenvalues and vectors of the flutter model along its friction."""
    found = [
        analyse("flutter-2dof", "coulomb", "eigenvalues", mu_k=float(mu), **changes).values
        for mu in friction
    ]
    values = np.array([f["eigenvalue_real"] + 1j * f["eigenvalue_imag"] for f in found])
    vectors = np.array([f["eigenvector_real"] + 1j * f["eigenvector_imag"] for f in found])
    return values, vectors


# --- one row -------------------------------------------------------------------------------------
@pytest.mark.parametrize("points", [9, 10, 41])
def test_modes_that_pass_each_other_keep_their_numbers(points: int) -> None:
    at = np.linspace(0.0, 1.0, points)
    values = np.stack([2j - 0.1 + 0 * at, 1j - 0.2 + 2j * at], axis=1)
    vectors = np.broadcast_to(np.eye(2, dtype=complex), (points, 2, 2))
    np.testing.assert_array_equal(followed(*shuffled(values, vectors)), values)


@pytest.mark.parametrize("damping", [0.0, 0.05, 0.3])
def test_modes_are_followed_through_their_merger(damping: float) -> None:
    """Each of four numbers is smooth but for the merger, and pairs stay pairs."""
    friction = np.linspace(3.0, 5.5, 60)
    values = followed(*shuffled(*flutter(friction, c1=damping, c2=damping)))
    assert np.abs(np.diff(values, axis=0)).max() < 0.15
    upper = values.imag[0] > 0.0
    assert np.all((values.imag > 0.0) == upper)
    twins = [int(np.flatnonzero(values[0] == z.conjugate())[0]) for z in values[0]]
    np.testing.assert_array_equal(values[:, twins], values.conj())


def test_the_lower_number_takes_the_larger_growth() -> None:
    values = followed(*flutter(np.linspace(4.0, 4.5, 8)))
    grows, decays = values[-1, 0], values[-1, 2]
    assert grows.real > 0.0 > decays.real


def test_a_pair_that_becomes_two_real_modes_and_a_pair_again() -> None:
    at = np.linspace(0.0, 1.0, 41)
    root = np.sqrt((at - 0.3137) * (0.7137 - at) + 0j)
    pair = np.stack([-1.0 + root, -1.0 - root], axis=1)
    other = np.stack([-0.1 + 1j + 0 * at, -0.1 - 1j + 0 * at], axis=1)
    values = np.concatenate([pair, other], axis=1)
    shapes = np.stack([np.ones_like(values), values], axis=2)
    found = followed(*shuffled(values, shapes))
    assert np.abs(np.diff(found, axis=0)).max() < 0.2
    assert {tuple(sorted(np.flatnonzero(abs(row + 1.0) < 0.5))) for row in found} == {(0, 1)}


def test_points_without_eigenvalues_are_bridged() -> None:
    at = np.linspace(0.0, 1.0, 21)
    values = np.stack([2j + 0 * at, 1j + 2j * at], axis=1)
    vectors = np.broadcast_to(np.eye(2, dtype=complex), (21, 2, 2))
    mixed, shapes = shuffled(values, vectors)
    mixed[[0, 9, 10]] = np.nan
    found = followed(mixed, shapes)
    # the first known point sets the numbers
    expected = values if found[1, 0] == values[1, 0] else values[:, ::-1]
    known = [point for point in range(21) if point not in (0, 9, 10)]
    np.testing.assert_array_equal(found[known], expected[known])


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 10_000))
def test_matching_gives_each_mode_one_successor(seed: int) -> None:
    generator = np.random.default_rng(seed)
    matrices = generator.normal(size=(2, 6, 6))
    pairs = [np.linalg.eig(matrix) for matrix in matrices]
    (old, old_vectors), (new, new_vectors) = [(v.astype(complex), w.T) for v, w in pairs]
    vectors = np.array([old_vectors, new_vectors], complex)
    modes = modes_of(np.array([old, new]), vectors)
    (order,) = matched([(modes[0], modes[1])])
    assert sorted(order) == list(range(6))
    for mode in np.flatnonzero(old.imag > 0.0):
        if new[order[mode]].imag > 0.0:
            twin = int(np.flatnonzero(old == old[mode].conjugate())[0])
            assert new[order[twin]] == new[order[mode]].conjugate()


# --- several axes --------------------------------------------------------------------------------
def test_a_number_means_the_same_all_over_a_grid() -> None:
    """Two modes pass each other along a line that slants through the grid."""
    x, y = np.meshgrid(np.linspace(0, 1, 15), np.linspace(0, 1, 11), indexing="ij")
    values = np.stack([3j + 0 * x, 1j + 2j * x + 3j * y], axis=-1)
    vectors = np.broadcast_to(np.eye(2, dtype=complex), (15, 11, 2, 2))
    np.testing.assert_array_equal(followed(*shuffled(values, vectors)), values)


def test_three_axes_with_holes() -> None:
    axes = np.meshgrid(*(np.linspace(0, 1, n) for n in (4, 5, 9)), indexing="ij")
    total = sum(axes)
    values = np.stack([3j + 0 * total, 1j + 2j * total, 7j - 1j * total], axis=-1)
    vectors = np.broadcast_to(np.eye(3, dtype=complex), (*total.shape, 3, 3))
    mixed, shapes = shuffled(values, vectors)
    holes = np.random.default_rng(2).random(total.shape) < 0.15
    holes[0, 0, 0] = False
    mixed[holes] = np.nan
    np.testing.assert_array_equal(followed(mixed, shapes)[~holes], values[~holes])


def as_dataset(
    evaluate: Callable[[float, float], Complex], x: NDArray[np.float64], y: NDArray[np.float64]
) -> xr.Dataset:
    """Eigenvalues of two uncoupled modes on a grid (kind, x, y), sorted anew at each point."""
    values = np.array([[evaluate(float(a), float(b)) for b in y] for a in x])
    order = np.argsort(values.imag, axis=-1)
    vectors = np.eye(2, dtype=complex)[order]
    values = np.take_along_axis(values, order, axis=-1)
    both, shapes = np.stack([values, values]), np.stack([vectors, vectors])
    return xr.Dataset(
        {
            "eigenvalue_real": (("kind", "x", "y", "mode"), both.real),
            "eigenvalue_imag": (("kind", "x", "y", "mode"), both.imag),
            "eigenvector_real": (("kind", "x", "y", "mode", "state"), shapes.real),
            "eigenvector_imag": (("kind", "x", "y", "mode", "state"), shapes.imag),
            "growth_rate": (("kind", "x", "y"), both.real.max(axis=-1)),
        },
        coords={"kind": np.array(["one", "other"]), "x": x, "y": y},
    )


def follow_modes(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with its modes followed."""
    return follow(Dataset.of(dataset)).to_xarray()


def test_datasets_are_renumbered_on_every_numeric_axis() -> None:
    x, y = np.linspace(0.0, 1.0, 12), np.linspace(0.0, 1.0, 7)
    found = follow_modes(as_dataset(lambda a, b: np.array([3j, 1j + 2j * a + 3j * b]), x, y))
    expected = 1 + 2 * x[:, None] + 3 * y[None, :]
    for kind in ("one", "other"):
        part = found.sel(kind=kind)["eigenvalue_imag"].transpose("x", "y", "mode")
        np.testing.assert_allclose(part.values[..., 0], expected)
        np.testing.assert_allclose(part.values[..., 1], 3.0)
    shape = found["eigenvector_real"].transpose("kind", "x", "y", "mode", "state").values
    assert np.all(shape[..., 0, 1] == 1.0)


# --- where modes merge ---------------------------------------------------------------------------
@pytest.mark.parametrize("damping", [0.0, 1e-6, 0.05, 0.4])
def test_frequencies_that_meet_are_marked_where_they_do(damping: float) -> None:
    """Undamped or equally damped: exactly at the friction of undamped flutter."""
    friction = np.linspace(3.02, 5.5, 40)
    values = followed(*flutter(friction, c1=damping, c2=damping))
    marks = coupling_points(friction, values)
    (before,) = np.unique(np.nonzero(np.isfinite(marks))[0])
    assert friction[before] < FLUTTER < friction[before + 1]
    np.testing.assert_allclose(marks[before], FLUTTER, rtol=1e-6)


def test_modes_that_part_again_are_marked_twice() -> None:
    at = np.linspace(0.0, 1.0, 33)
    root = np.sqrt((at - 0.31) * (0.77 - at) + 0j)
    marks = coupling_points(at, np.stack([2j - 0.1 + root, 2j - 0.1 - root], axis=1))
    np.testing.assert_allclose(marks[np.isfinite(marks)], [0.31, 0.31, 0.77, 0.77], rtol=1e-12)


def test_modes_far_apart_in_damping_do_not_merge() -> None:
    """The thesis: with unequal damping the imaginary parts merge no more."""
    friction = np.linspace(3.02, 5.5, 40)
    values = followed(*flutter(friction, c1=0.2, c2=0.4))
    assert np.all(np.isnan(coupling_points(friction, values)))


def test_modes_that_only_pass_do_not_merge() -> None:
    at = np.linspace(0.0, 1.0, 40)
    marks = coupling_points(at, np.stack([-0.001 + 2j + 0 * at, -0.001 + 1j + 2j * at], axis=1))
    assert np.all(np.isnan(marks))


@pytest.mark.parametrize("friction", [[3.0, 4.2, 4.3, 5.0], [4.3]])
def test_modes_that_have_merged_name_each_other_as_modes(friction: list[float]) -> None:
    """A conjugate pair is one mode, as in figures."""
    flutter = {"schema": 1, "model": {"name": "flutter-2dof"}, "grid": {"mu_k": friction}}
    found = run(load(flutter | {"analysis": [{"kind": "eigenvalues"}]}), workers=1)
    numbers, partners = found["mode_number"], found["coupled_with"]
    assert sorted(numbers.values.tolist()) == [1, 1, 2, 2]
    values = found["eigenvalue_real"] + 1j * found["eigenvalue_imag"]
    for number in (1, 2):
        one, other = values.isel(mode=np.flatnonzero(numbers == number)).values.T
        np.testing.assert_allclose(one, other.conj())
    merged = found["mu_k"] > FLUTTER
    assert bool((partners == xr.where(merged, 3 - numbers, -1)).all())


# --- axes without an order ------------------------------------------------------------------------
def zipped(friction: list[float], stiffness: list[float]) -> xr.Dataset:
    """The flutter model along two axes that advance together."""
    found = [
        analyse("flutter-2dof", "coulomb", "eigenvalues", mu_k=mu, k1=k1).values
        for mu, k1 in zip(friction, stiffness, strict=True)
    ]
    dims = ("k1_mu_k", "mode")
    parts = {
        name: (dims + ("state",) * ("vector" in name), np.array([f[name] for f in found]))
        for name in ("eigenvalue_real", "eigenvalue_imag", "eigenvector_real", "eigenvector_imag")
    }
    parts["coupling_point"] = (
        dims,
        np.full((len(found), len(found[0]["eigenvalue_real"])), np.nan),
    )
    axes = {"k1": ("k1_mu_k", stiffness), "mu_k": ("k1_mu_k", friction)}
    return xr.Dataset(parts, coords=axes)


def eigenvalues_of(dataset: xr.Dataset) -> list[list[tuple[float, float]]]:
    """The eigenvalues of each point, whatever their numbers."""
    parts = (dataset[f"eigenvalue_{part}"].values for part in ("real", "imag"))
    return [sorted(zip(*row, strict=True)) for row in zip(*parts, strict=True)]


def test_of_axes_that_advance_together_one_in_order_is_followed() -> None:
    """The first repeats a value, which once took all eigenvalues away."""
    dataset = zipped([4.0, 4.1, 4.4, 4.5], [1.0, 1.0, 1.0, 1.0])
    found = follow_modes(dataset)
    assert found["coupling_point"].attrs["along"] == "mu_k"
    places = np.unique(found["coupling_point"].values[np.isfinite(found["coupling_point"].values)])
    assert len(places) == 1 and 4.1 < places[0] < 4.4
    assert eigenvalues_of(found) == eigenvalues_of(dataset)


def test_along_axes_without_an_order_nothing_is_followed() -> None:
    dataset = zipped([4.4, 4.1, 4.1, 4.5], [1.0, 1.0, 2.0, 1.0])
    assert follow_modes(dataset).drop_vars("mode_number").identical(dataset)


def test_a_failure_to_follow_keeps_the_eigenvalues(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(*arguments: object) -> None:
        raise np.linalg.LinAlgError("SVD did not converge")

    monkeypatch.setattr("fiv_cli.data.modes.coupling_points", fails)
    dataset = zipped([4.0, 4.4], [1.0, 2.0])
    found = follow_modes(dataset)
    xr.testing.assert_equal(found.drop_vars("mode_number"), dataset)
    assert "numbered on their own" in found["eigenvalue_real"].attrs["comment"]
