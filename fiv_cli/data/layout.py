"""The shape of one analysis' part of a dataset: its dims, coordinates and variables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf, prod

from fiv_cli.analyses.base import Settings
from fiv_cli.analyses.catalogue import variables_of
from fiv_cli.analyses.variables import Role, Variable
from fiv_cli.case.case import Axis
from fiv_cli.models import get_model
from fiv_cli.models.base import Parameter, State


@dataclass(frozen=True)
class Dim:
    """One dim of the grid: an axis, or several that advance together."""

    axes: tuple[Axis, ...]

    @property
    def name(self) -> str:
        """``mu_k``; ``A_omega`` for zipped axes."""
        return "_".join(axis.dim for axis in self.axes)

    @property
    def size(self) -> int:
        """Number of points along the dim."""
        return len(self.axes[0].values)


@dataclass(frozen=True)
class Layout:
    """How the points of one analysis lie in a dataset.

    Attributes
    ----------
    name : name of the analysis (its NetCDF group where there are several)
    kind : kind of the analysis
    model : model name
    options : options of the model that are not axes
    settings : settings of the analysis
    dims : dims of the grid, in order
    labels : coordinate of the dim ``initial``; None where the analysis has no starts
    laws : names of the laws in use
    varying : parameters that vary in time
    fixed : parameters that have one value at all points, SI
    internal : states of the friction laws, and what they store
    reach : slip speed up to which the laws are known, m/s
    """

    name: str
    kind: str
    model: str
    options: Mapping[str, str]
    settings: Settings
    dims: tuple[Dim, ...]
    labels: tuple[str, ...] | None
    laws: tuple[str, ...]
    varying: tuple[Parameter, ...] = ()
    fixed: Mapping[str, float] = field(default_factory=dict)
    internal: tuple[State, ...] = ()
    reach: float = inf

    @property
    def dim_names(self) -> tuple[str, ...]:
        """Names of the dims of the grid, then ``initial`` where there are starts."""
        names = tuple(dim.name for dim in self.dims)
        return names if self.labels is None else (*names, "initial")

    @property
    def shape(self) -> tuple[int, ...]:
        """Sizes of `dim_names`."""
        sizes = tuple(dim.size for dim in self.dims)
        return sizes if self.labels is None else (*sizes, len(self.labels))

    @property
    def size(self) -> int:
        """Number of points."""
        return prod(self.shape)

    @property
    def told(self) -> Variable | None:
        """The variable that tells the class of each point; None where there is none."""
        classes = (v for v in self.variables if v.role is Role.CLASS and v.one_per_point)
        return next(classes, None)

    @property
    def variables(self) -> tuple[Variable, ...]:
        """The variables of this analysis."""
        model, more = get_model(self.model), (self.varying, self.internal, self.reach)
        return variables_of(self.kind, model, self.options, self.settings, *more)
