"""A dataset on its way to a file.

It is what xarray would make of it; but to import xarray takes longer than many sweeps.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from fiv_cli.data.block import Array

if TYPE_CHECKING:
    import xarray as xr

Attributes = Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class Labelled:
    """An array with names for its dims.

    Attributes
    ----------
    dims, values, attrs : as of a variable of xarray
    """

    dims: tuple[str, ...]
    values: Array
    attrs: Attributes

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the values."""
        return self.values.dtype

    def arranged(self, dims: tuple[str, ...]) -> Array:
        """The values with the dims in this order."""
        return self.values.transpose([self.dims.index(dim) for dim in dims])


@dataclass(frozen=True, eq=False)
class Dataset:
    """Arrays over common dims.

    Attributes
    ----------
    variables : the arrays, coordinates among them
    coords : names of the coordinates
    attrs : what holds of all
    """

    variables: Mapping[str, Labelled]
    coords: frozenset[str]
    attrs: Attributes = field(default_factory=dict)

    @classmethod
    def of(cls, dataset: xr.Dataset) -> Dataset:
        """The same dataset, from xarray."""
        variables = {
            str(name): Labelled(tuple(map(str, one.dims)), one.values, one.attrs)
            for name, one in dataset.variables.items()
        }
        return cls(variables, frozenset(map(str, dataset.coords)), dataset.attrs)

    def to_xarray(self) -> xr.Dataset:
        """The same dataset, for whoever computes with it."""
        import xarray as xr

        made = {name: xr.Variable(v.dims, v.values, v.attrs) for name, v in self.variables.items()}
        data = {name: one for name, one in made.items() if name not in self.coords}
        coords = {name: one for name, one in made.items() if name in self.coords}
        return xr.Dataset(data, coords=coords, attrs=self.attrs)

    @property
    def sizes(self) -> dict[str, int]:
        """Dim -> its length, in the order in which the variables have them."""
        variables = self.variables.values()
        return {d: n for one in variables for d, n in zip(one.dims, one.values.shape, strict=True)}

    @property
    def nbytes(self) -> int:
        """Memory that the values take."""
        return sum(one.values.nbytes for one in self.variables.values())

    def assign(self, changed: Mapping[str, Labelled], coords: tuple[str, ...] = ()) -> Dataset:
        """The dataset with other variables in place of some, or besides."""
        variables = {**self.variables, **changed}
        return replace(self, variables=variables, coords=self.coords.union(coords))
