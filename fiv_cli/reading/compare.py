"""Whether two datasets agree, and where they do not.

Status and class are compared exactly. Numbers are compared where both sides are equilibrium or
periodic, or where the analysis knows no classes; quasi-periodic and chaotic motions only by L_s
and by the shares of time, within the error of a finite window, because two computations of such
a motion agree for a while only. What says how an answer was reached (how far to trust it, what it
cost) is left out unless a tolerance is given.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from fiv_cli.analyses.catalogue import named
from fiv_cli.analyses.variables import Role
from fiv_cli.case.toml import parse_toml
from fiv_cli.errors import InputError, UsageError
from fiv_cli.flags import ATTRACTOR

Mask = NDArray[np.bool_]

EXACT_CLASSES = ("equilibrium", "periodic", "contact_lost")
SAMPLED_CLASSES = ("quasiperiodic", "chaotic")


@dataclass(frozen=True)
class Tolerance:
    """Numbers a and b agree when ``|a - b| <= atol + rtol max(|a|, |b|)``."""

    rtol: float = 1e-6
    atol: float = 1e-12


@dataclass(frozen=True)
class Tolerances:
    """Tolerances of a comparison.

    Attributes
    ----------
    default : of every variable without its own
    sampled : of L_s and shares of time of quasi-periodic and chaotic motions
    variables : name -> its own
    ignore : names that are not compared
    """

    default: Tolerance = Tolerance()
    sampled: Tolerance = Tolerance(rtol=0.1, atol=0.02)
    variables: Mapping[str, Tolerance] = field(default_factory=dict)
    ignore: tuple[str, ...] = ()

    def of(self, name: str) -> Tolerance:
        """The tolerance of a variable."""
        return self.variables.get(name, self.default)


@dataclass(frozen=True)
class Difference:
    """One thing in which two datasets differ.

    Attributes
    ----------
    what : variable, coordinate or dim
    text : how, with the worst offender and where it is
    count : number of values that differ
    """

    what: str
    text: str
    count: int = 1


def read_tolerances(path: Path) -> Tolerances:
    """Tolerances from a TOML file.

    ``[default]``, ``[sampled]`` and ``[variables.NAME]`` hold ``rtol`` and ``atol``; ``ignore``
    lists names.

    Raises
    ------
    UsageError
        there is no such file.
    InputError
        it is not TOML, or has another form.
    """
    try:
        table = parse_toml(path.read_text(encoding="utf-8"))
        return _tolerances(table)
    except OSError as error:
        raise UsageError(f"{path}: {error.strerror}\nnext: name a TOML file") from error
    except (AttributeError, TypeError, ValueError) as error:
        raise InputError(
            f"{path}: no table of tolerances: {error}\n"
            "next: [default] rtol = 1e-6, [variables.L_s] rtol = 1e-4, ignore = [...]"
        ) from error


def compare(
    left: Mapping[str, xr.Dataset], right: Mapping[str, xr.Dataset], tolerances: Tolerances
) -> list[Difference]:
    """Every difference between two sets of datasets, by name of the analysis."""
    found = []
    for name in sorted(left.keys() | right.keys()):
        prefix = f"{name}/" if name else ""
        if name not in left or name not in right:
            side = "first" if name in left else "second"
            found.append(Difference(name, f"only in the {side} dataset"))
        else:
            found.extend(_compare_datasets(left[name], right[name], tolerances, prefix))
    return found


def _tolerances(table: Mapping[str, Any]) -> Tolerances:
    unknown = set(table) - {"default", "sampled", "variables", "ignore"}
    if unknown:
        raise ValueError(f"unknown key {sorted(unknown)[0]!r}")
    plain = Tolerances()
    own = {name: Tolerance(**entry) for name, entry in table.get("variables", {}).items()}
    return Tolerances(
        default=Tolerance(**table["default"]) if "default" in table else plain.default,
        sampled=Tolerance(**table["sampled"]) if "sampled" in table else plain.sampled,
        variables=own,
        ignore=tuple(table.get("ignore", ())),
    )


def _compare_datasets(
    left: xr.Dataset, right: xr.Dataset, tolerances: Tolerances, prefix: str
) -> Iterator[Difference]:
    yield from _compare_names(left, right, tolerances, prefix)
    shape = list(_compare_coordinates(left, right, prefix))
    yield from shape
    if shape:
        return  # values at different places cannot be compared
    classes = _Classes(left, right)
    for name in left.data_vars:
        if name in right.data_vars and str(name) not in tolerances.ignore:
            yield from _compare_variable(left, right, str(name), classes, tolerances, prefix)


def _compare_names(
    left: xr.Dataset, right: xr.Dataset, tolerances: Tolerances, prefix: str
) -> Iterator[Difference]:
    for name in sorted(map(str, left.variables.keys() ^ right.variables.keys())):
        if name not in tolerances.ignore:
            side = "first" if name in left.variables else "second"
            yield Difference(prefix + name, f"only in the {side} dataset")


def _compare_coordinates(left: xr.Dataset, right: xr.Dataset, prefix: str) -> Iterator[Difference]:
    for name in left.coords:
        if name not in right.coords:
            continue
        a, b = left[name].values, right[name].values
        if a.shape != b.shape:
            yield Difference(f"{prefix}{name}", f"{a.size} against {b.size} values")
        elif not np.array_equal(a, b):
            index = int(np.flatnonzero(a != b)[0])
            text = f"value {index}: {a.ravel()[index]!r} against {b.ravel()[index]!r}"
            yield Difference(f"{prefix}{name}", text, int(np.count_nonzero(a != b)))


class _Classes:
    """Where values can be compared: by the attractor of both sides."""

    def __init__(self, left: xr.Dataset, right: xr.Dataset) -> None:
        self._left, self._right = left, right

    def mask(self, name: str) -> tuple[xr.DataArray | bool, xr.DataArray | bool]:
        """Where `name` is compared with its own tolerance, and where with that of sampling."""
        if "attractor" not in self._left or "attractor" not in self._right:
            return True, False
        if named(name).role is Role.STATUS or name == "attractor":
            return True, False
        exact = self._both(EXACT_CLASSES)
        sampled = self._both(SAMPLED_CLASSES) if named(name).statistic else False
        return exact, sampled

    def _both(self, classes: Iterable[str]) -> xr.DataArray:
        codes = [ATTRACTOR.codes[name] for name in classes]
        left, right = self._left["attractor"], self._right["attractor"]
        return left.isin(codes) & right.isin(codes)


def _compare_variable(
    left: xr.Dataset,
    right: xr.Dataset,
    name: str,
    classes: _Classes,
    tolerances: Tolerances,
    prefix: str,
) -> Iterator[Difference]:
    a, b = left[name], right[name]
    if a.attrs.get("units") != b.attrs.get("units"):
        text = f"units {a.attrs.get('units')!r} against {b.attrs.get('units')!r}"
        yield Difference(prefix + name, text)
        return
    if a.dims != b.dims or a.dtype.kind != b.dtype.kind:
        text = f"{a.dtype} over {a.dims} against {b.dtype} over {b.dims}"
        yield Difference(prefix + name, text)
        return
    if named(name).tells_trust and name not in tolerances.variables:
        return
    owner, other = _ragged_owner(left, a), _ragged_owner(right, b)
    if owner != other:
        yield Difference(prefix + name, f"rows counted by {owner} against {other}")
    elif owner is not None:
        yield from _compare_ragged(left, right, name, owner, classes, tolerances, prefix)
    elif not (name.endswith("_row_size") and "attractor" in left):
        yield from _compare_values(a, b, name, classes, tolerances, prefix)


def _ragged_owner(dataset: xr.Dataset, variable: xr.DataArray) -> str | None:
    """Name of the variable that counts the rows of `variable`, where it is ragged."""
    for name, candidate in dataset.data_vars.items():
        if candidate.attrs.get("sample_dimension") in variable.dims:
            return str(name)
    return None


def _compare_values(
    a: xr.DataArray,
    b: xr.DataArray,
    name: str,
    classes: _Classes,
    tolerances: Tolerances,
    prefix: str,
) -> Iterator[Difference]:
    if a.shape != b.shape:
        yield Difference(prefix + name, f"shape {a.shape} against {b.shape}")
        return
    exact, sampled = classes.mask(name)
    bad = _differs(a, b, tolerances.of(name) if _is_number(a) else Tolerance(0.0, 0.0)) & exact
    if sampled is not False:
        bad = bad | (_differs(a, b, tolerances.sampled) & sampled)
    bad = bad.transpose(*a.dims)
    count = int(np.count_nonzero(bad.values))
    if count:
        yield Difference(prefix + name, _worst(a, b, bad.values), count)


def _is_number(variable: xr.DataArray) -> bool:
    return variable.dtype.kind == "f"


def _differs(a: xr.DataArray, b: xr.DataArray, tolerance: Tolerance) -> xr.DataArray:
    """Where two arrays differ; two NaN agree, a NaN and a number do not."""
    x, y = a.values, b.values
    if not _is_number(a):
        return a.copy(data=x != y)
    finite = np.isfinite(x) & np.isfinite(y)
    u, w = np.where(finite, x, 0.0), np.where(finite, y, 0.0)
    allowed = tolerance.atol + tolerance.rtol * np.maximum(np.abs(u), np.abs(w))
    same = np.where(finite, np.abs(u - w) <= allowed, (x == y) | (np.isnan(x) & np.isnan(y)))
    return a.copy(data=~same.astype(bool))


def _worst(a: xr.DataArray, b: xr.DataArray, bad: Mask) -> str:
    """The value that differs most, with its coordinates."""
    x, y = a.values, b.values
    gap = np.where(bad, _gap(x, y), -1.0)
    index = np.unravel_index(int(np.argmax(gap)), gap.shape)
    left, right = _named(a, x[index]), _named(a, y[index])
    return f"{left} against {right} at {_place(a, index)}"


def _gap(x: NDArray[Any], y: NDArray[Any]) -> NDArray[np.float64]:
    """Relative distance; infinite where a side is not a number."""
    x, y = np.asarray(x, float), np.asarray(y, float)
    finite = np.isfinite(x) & np.isfinite(y)
    u, w = np.where(finite, x, 0.0), np.where(finite, y, 0.0)
    scale = np.maximum(np.abs(u), np.abs(w))
    return np.where(finite, np.abs(u - w) / np.where(scale > 0.0, scale, 1.0), np.inf)


def _named(variable: xr.DataArray, value: Any) -> str:
    """A value, by its name where it is a flag."""
    if "flag_meanings" not in variable.attrs:
        return f"{value:.12g}"
    values = [int(code) for code in np.atleast_1d(variable.attrs["flag_values"])]
    names = str(variable.attrs["flag_meanings"]).split()
    return dict(zip(values, names, strict=True)).get(int(value), str(value))


def _place(variable: xr.DataArray, index: tuple[Any, ...]) -> str:
    """Coordinates of an element: ``mu_k=0.4, initial=far``."""
    parts = []
    for dim, i in zip(variable.dims, index, strict=True):
        coordinates = [n for n, c in variable.coords.items() if c.dims == (dim,)]
        parts += [f"{n}={variable[n].values[int(i)]}" for n in coordinates] or [f"{dim}={int(i)}"]
    return ", ".join(parts) or "the only point"


def _compare_ragged(
    left: xr.Dataset,
    right: xr.Dataset,
    name: str,
    owner: str,
    classes: _Classes,
    tolerances: Tolerances,
    prefix: str,
) -> Iterator[Difference]:
    """Row by row: the numbers of rows must agree, then the values."""
    exact, _ = classes.mask(name)
    wanted = np.broadcast_to(np.asarray(exact), left[owner].shape).ravel()
    sizes = left[owner].values.ravel(), right[owner].values.ravel()
    unequal = (sizes[0] != sizes[1]) & wanted
    if unequal.any():
        flat = int(np.argmax(unequal))
        where = _place(left[owner], np.unravel_index(flat, left[owner].shape))
        text = f"{sizes[0][flat]} against {sizes[1][flat]} values at {where}"
        yield Difference(prefix + name, text, int(np.count_nonzero(unequal)))
        return
    a, b = (_rows(d[name].values, s, wanted) for d, s in zip((left, right), sizes, strict=True))
    yield from _compare_rows(left, name, owner, a, b, wanted, sizes[0], tolerances, prefix)


def _compare_rows(
    left: xr.Dataset,
    name: str,
    owner: str,
    a: NDArray[Any],
    b: NDArray[Any],
    wanted: Mask,
    sizes: NDArray[Any],
    tolerances: Tolerances,
    prefix: str,
) -> Iterator[Difference]:
    x, y = xr.DataArray(a, dims="row"), xr.DataArray(b, dims="row")
    bad = _differs(x, y, tolerances.of(name)).values
    if not bad.any():
        return
    worst = int(np.argmax(np.where(bad, _gap(a, b), -1.0)))
    points = np.repeat(np.flatnonzero(wanted), sizes[wanted].astype(int))
    where = _place(left[owner], np.unravel_index(int(points[worst]), left[owner].shape))
    text = f"{_named(left[name], a[worst])} against {_named(left[name], b[worst])} at {where}"
    yield Difference(prefix + name, text, int(np.count_nonzero(bad)))


def _rows(values: NDArray[Any], sizes: NDArray[Any], wanted: Mask) -> NDArray[Any]:
    """The values of the wanted rows of a contiguous ragged array."""
    return values[np.repeat(wanted, sizes.astype(int))]
