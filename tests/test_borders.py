"""Borders between classes are drawn whole, from few runs, and always from the same ones."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import ndimage

from fiv_cli.sweep.borders import BLANK, Picture, draw, sample

UNKNOWN = -9

Field = Callable[..., NDArray[np.bool_]]


def lattice(field: Field, coarse: int, levels: int, dims: int = 2) -> NDArray[np.int64]:
    """The classes of a field over the unit square (or line, or cube) on the fine lattice."""
    axis = np.linspace(0.0, 1.0, (coarse - 1) * 2**levels + 1)
    return field(*np.meshgrid(*[axis] * dims, indexing="ij")).astype(np.int64)


def run_to_the_end(truth: NDArray[np.int64], levels: int) -> tuple[Picture, int]:
    """Run what is wanted until nothing more is; the map, and in how many goes."""
    known, goes = np.zeros(truth.shape, bool), 0
    while True:
        picture = draw(np.where(known, truth, UNKNOWN), known, levels)
        assert not (known & ~picture.wanted).any()
        if picture.complete:
            return picture, goes
        assert (picture.wanted & ~known).any()
        known |= picture.wanted
        goes += 1


def disc(x0: float, y0: float, radius: float) -> Field:
    """Inside a circle."""
    return lambda x, y: (x - x0) ** 2 + (y - y0) ** 2 < radius**2


def test_nine_by_nine_becomes_the_picture_of_257_by_257_for_a_sixth_of_the_runs() -> None:
    for radius in (0.1, 0.3, 0.45):
        truth = lattice(disc(0.5, 0.5, radius), 9, 5)
        picture, goes = run_to_the_end(truth, 5)
        assert truth.shape == (257, 257)
        assert (picture.classes == truth).all()
        assert picture.wanted.mean() < 1 / 6
        assert goes <= 8


def test_a_stripe_thinner_than_a_coarse_cell_is_followed_to_its_end() -> None:
    truth = lattice(lambda x, y: np.abs(y - 0.25 - 0.3 * x) < 0.012, 9, 5)
    assert truth[0, 64] == 1  # it begins at a point of the coarse lattice
    picture, _ = run_to_the_end(truth, 5)
    assert (picture.classes == truth).all()
    assert picture.wanted.mean() < 1 / 6


def test_an_island_between_the_points_of_the_coarse_lattice_is_missed_and_sampled() -> None:
    truth = lattice(disc(0.18, 0.18, 0.03), 9, 5)
    picture, _ = run_to_the_end(truth, 5)
    assert picture.wanted.sum() == 81
    wrong = picture.classes != truth
    assert (wrong == (truth == 1)).all()
    found = sample(~picture.wanted, 20_000, seed=0)
    share = (wrong & found).sum() / found.sum()
    assert share == pytest.approx(wrong[~picture.wanted].mean(), rel=0.25)


@pytest.mark.parametrize(("dims", "levels"), [(1, 6), (2, 5), (3, 4)])
def test_along_any_number_of_axes_runs_grow_like_the_border(dims: int, levels: int) -> None:
    """The lattice grows by 2**dims when it is halved, the border by 2**(dims - 1)."""
    shares = []
    for count in (levels - 1, levels):
        truth = lattice(lambda *x: sum((v - 0.4) ** 2 for v in x) < 0.08, 5, count, dims)
        picture, _ = run_to_the_end(truth, count)
        assert (picture.classes == truth).all()
        shares.append(picture.wanted.mean())
    assert 0.4 < shares[1] / shares[0] < 0.65


def test_a_single_class_costs_the_coarse_lattice() -> None:
    picture, goes = run_to_the_end(np.full((129, 65), 3), 4)
    assert (picture.wanted.sum(), goes) == (9 * 5, 1)
    assert (picture.classes == 3).all()


def test_classes_of_points_that_are_not_wanted_change_nothing() -> None:
    """A store may hold more than is wanted, e.g. of a full grid run before."""
    truth = lattice(disc(0.4, 0.6, 0.3), 5, 4)
    expected, _ = run_to_the_end(truth, 4)
    everything = draw(truth, np.ones(truth.shape, bool), 4)
    assert (everything.wanted == expected.wanted).all()
    noise = np.where(expected.wanted, truth, 7)
    assert (draw(noise, np.ones(truth.shape, bool), 4).classes == expected.classes).all()


unit = st.floats(0.0, 1.0)


def test_points_run_in_vain_draw_no_border() -> None:
    truth = lattice(disc(0.45, 0.55, 0.3), 9, 4)
    clean, _ = run_to_the_end(truth, 4)
    failed = np.zeros(truth.shape, bool)
    failed[::16, ::16][1::3, 2::3] = True  # every ninth point of the coarse lattice
    failed.ravel()[3::50] = True
    picture, _ = run_to_the_end(np.where(failed, BLANK, truth), 4)
    assert abs(picture.wanted.sum() - clean.wanted.sum()) < 0.1 * clean.wanted.sum()
    assert (picture.classes == BLANK).sum() == (failed & picture.wanted).sum()
    assert (picture.classes == truth)[picture.classes != BLANK].all()


def test_nothing_is_filled_in_where_everything_was_run_in_vain() -> None:
    picture, _ = run_to_the_end(np.full((33, 33), BLANK), 3)
    assert picture.wanted.sum() == 25
    assert (picture.classes == BLANK).all()


discs = st.tuples(unit, unit, st.floats(0.005, 0.5), st.integers(1, 3))
stripes = st.tuples(unit, st.floats(-1.0, 1.0), st.floats(0.004, 0.1))


@settings(max_examples=60, deadline=None)
@given(st.lists(discs, max_size=4), st.lists(stripes, max_size=2), st.integers(1, 4))
def test_whatever_was_met_is_drawn_whole(
    circles: list[tuple[float, float, float, int]],
    lines: list[tuple[float, float, float]],
    levels: int,
) -> None:
    """Two neighbours of different class have both been run; what is wrong is an unmet island."""

    def field(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.int64]:
        classes = np.zeros(x.shape, np.int64)
        for x0, y0, radius, label in circles:
            classes[disc(x0, y0, radius)(x, y)] = label
        for offset, slope, width in lines:
            classes[np.abs(y - offset - slope * x) < width] = 4
        return classes

    truth = lattice(field, 6, levels)
    picture, _ = run_to_the_end(truth, levels)
    assert (picture.classes == truth)[picture.wanted].all()
    for axis in (0, 1):
        differ = np.diff(picture.classes, axis=axis) != 0
        before, after = np.delete(picture.wanted, -1, axis), np.delete(picture.wanted, 0, axis)
        assert (before & after)[differ].all()
    wrong = picture.classes != truth
    for label in np.unique(truth):
        regions, _ = ndimage.label(truth == label)
        met = np.unique(regions[picture.wanted])
        assert not np.isin(regions[wrong], met[met > 0]).any()


def test_a_sample_is_of_the_size_asked_for_and_depends_on_the_seed() -> None:
    filled = np.ones((50, 40), bool)
    filled[:10] = False
    first = sample(filled, 100, seed=0)
    assert first.sum() == 100
    assert not (first & ~filled).any()
    assert (sample(filled, 100, seed=0) == first).all()
    assert (sample(filled, 100, seed=1) != first).any()
    assert (sample(filled, 5000, seed=0) == filled).all()
    mixed = {place: splitmix(place + 0x9E3779B97F4A7C15) for place in range(400, 2000)}
    assert set(np.flatnonzero(first)) == set(sorted(mixed, key=mixed.__getitem__)[:100])


def splitmix(x: int) -> int:
    """The finaliser of SplitMix64 in whole numbers."""
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9 % 2**64
    x = (x ^ (x >> 27)) * 0x94D049BB133111EB % 2**64
    return x ^ (x >> 31)
