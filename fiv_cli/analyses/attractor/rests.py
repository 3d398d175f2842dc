"""What there is to come to rest at: sliding equilibria, and what slides to them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from fiv_cli.analyses.attractor.descent import Descent, Slide, slides_to
from fiv_cli.analyses.attractor.grounds import HURWITZ
from fiv_cli.analyses.attractor.level_set import LevelSet, level_sets, undamped_level
from fiv_cli.analyses.base import Request
from fiv_cli.analyses.common import Sliding, rests, start_states
from fiv_cli.analyses.rest.linearisation import free_jacobian
from fiv_cli.codegen.memory import Frames
from fiv_cli.dynamics.system import System, Vector


@dataclass(frozen=True, eq=False)
class Landscape:
    """The sliding equilibria of several points, and what slides to them, side by side.

    Attributes
    ----------
    unexcited : the system without its excitation, in sliding, at each point
    solutions : the equilibria of each, shape (n_states,) each
    begun : the states that starts describe, NaN where none does; shape (points, n_states)
    owners, jacobians : of every first equilibrium, its point, and sliding at it, 1/s
    level_sets : about every stable equilibrium, those of a point one after the other
    ends : how many these are up to each point
    """

    unexcited: Sliding
    solutions: list[list[Vector]]
    begun: NDArray[np.float64]
    owners: NDArray[np.intp]
    jacobians: NDArray[np.float64]
    level_sets: LevelSet
    ends: NDArray[np.intp]

    @cached_property
    def spectra(self) -> NDArray[np.complex128]:
        """Eigenvalues of sliding at every first equilibrium, 1/s."""
        return np.linalg.eigvals(self.jacobians).astype(complex)

    @cached_property
    def eigenvalues(self) -> dict[int, NDArray[np.complex128]]:
        """Point -> those of sliding at its first equilibrium, 1/s."""
        return dict(zip(self.owners.tolist(), self.spectra, strict=True))

    @cached_property
    def natural_periods(self) -> dict[int, float]:
        """Point -> the longest one there, s; infinite where nothing oscillates."""
        turning = np.abs(self.spectra.imag)
        slowest = np.min(np.where(turning > 0.0, turning, np.inf), axis=-1, initial=np.inf)
        periods = [float(2 * np.pi / speed) or np.inf for speed in slowest.tolist()]
        return dict(zip(self.owners.tolist(), periods, strict=True))

    @cached_property
    def slides(self) -> Frames[Slide]:
        """What looks at slides to the equilibria with level sets read and write."""
        return slides_to(self.level_sets)


@dataclass(frozen=True, eq=False)
class Rests:
    """The sliding equilibria of a point, and what slides to them: a row of a `Landscape`."""

    landscape: Landscape
    row: int

    @cached_property
    def unexcited(self) -> Sliding:
        """The system without its excitation, in sliding."""
        return self.landscape.unexcited[self.row]

    @property
    def solutions(self) -> list[Vector]:
        """Its equilibria, shape (n_states,) each."""
        return self.landscape.solutions[self.row]

    @property
    def first(self) -> Vector | None:
        """The one that growing loads lead to."""
        return self.solutions[0] if self.solutions else None

    @property
    def natural_period(self) -> float:
        """The longest one there, s; infinite where nothing oscillates."""
        return self.landscape.natural_periods.get(self.row, np.inf)

    @property
    def _numbers(self) -> range:
        return range(*self.landscape.ends[self.row : self.row + 2].tolist())

    @cached_property
    def level_sets(self) -> list[LevelSet]:
        """About every stable one."""
        return [self.landscape.level_sets[number] for number in self._numbers]

    def descents(self, anew: bool) -> list[Descent]:
        """Slides down to them, but for those that springs hold; looked at anew, or further on."""
        found = []
        for number, target in zip(self._numbers, self.level_sets, strict=True):
            if not target.keeps:
                slide = self.landscape.slides.copy(number)
                if anew:
                    slide.bent, slide.count = np.inf, 0
                found.append(Descent(target, slide))
        return found

    @property
    def is_neutral(self) -> bool:
        """Whether the first equilibrium neither attracts nor repels."""
        eigenvalues = self.landscape.eigenvalues.get(self.row)
        if eigenvalues is None:
            return False
        values = eigenvalues.tolist()
        slow = HURWITZ * max(map(abs, values))
        if self.landscape.unexcited.held[self.row]:
            values = [value for value in values if abs(value) > slow]
        return abs(max(value.real for value in values)) <= slow

    def undamped_levels(self, states: NDArray[np.float64]) -> NDArray[np.float64]:
        """V over c of slides about the first equilibrium, where that is neutral; NaN without."""
        first, row = np.flatnonzero(self.landscape.owners == self.row), [self.row]
        if not first.size or self.first is None:
            return np.full(len(states), np.nan)
        here = self.landscape.unexcited[row], self.first[None], self.landscape.jacobians[first]
        return undamped_level(*here, states)

    @property
    def longest_beat(self) -> float:
        """The longest of two of its frequencies that lie side by side, s; 0 where none beat."""
        eigenvalues = self.landscape.eigenvalues.get(self.row, np.zeros(1, complex))
        slow = HURWITZ * np.abs(eigenvalues).max()
        turning = np.sort(eigenvalues.imag[eigenvalues.imag > slow])
        apart = np.diff(turning)
        return 2 * np.pi / float(np.min(apart[apart > slow], initial=np.inf))


def rests_at(system: System, requests: Sequence[Request]) -> list[Rests]:
    """What there is to come to rest at, at several points."""
    landscape = landscape_at(system, requests)
    return [Rests(landscape, row) for row in range(len(requests))]


def landscape_at(system: System, requests: Sequence[Request]) -> Landscape:
    """The same, side by side."""
    state, solutions = rests(system, requests)
    counts = np.array([len(some) for some in solutions])
    owners = np.repeat(np.arange(len(counts)), counts)
    y = np.array([one for some in solutions for one in some]).reshape(-1, len(system.state_names))
    numbers = 1 + np.arange(len(owners)) - (np.cumsum(counts) - counts)[owners]
    at, first = state[owners], numbers == 1
    jacobians = free_jacobian(at, y)
    rows, levels = level_sets(at, y, jacobians, numbers)
    begun = start_states(system, requests, [some[0] if some else None for some in solutions])
    if len(rows) > 0:
        levels = levels.asked_of(begun[owners[rows]])
    ends = np.searchsorted(owners[rows], np.arange(len(counts) + 1))
    return Landscape(state, solutions, begun, owners[first], jacobians[first], levels, ends)
