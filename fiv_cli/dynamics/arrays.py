"""The arrays of a motion: its own ones in one block, those that all motions of a system share.

The driver reads them through a frame of addresses (`codegen/memory.py`). A motion is made for
every point of a sweep, so a new one copies one block, frame included.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fiv_cli.codegen.memory import address_of
from fiv_cli.dynamics import kernel, roots
from fiv_cli.dynamics.settings import SolverSettings
from fiv_cli.dynamics.system import System, Vector

SCRATCH_ROWS = 7
WORD = 8  # bytes of an integer, a float, an address
# A state (m, rad, and those per s) beyond this has diverged. Growth in a nonlinear contact ends in
# ever shorter steps, so a bound far above anything mechanical would only cost time.
BOUND = 1e6
ROUNDING = 1e-16
FASTEST = 3.0  # squares and powers, of nonlinear laws too, against the states

# Steps after which a motion comes back for the first time: 0.2 s where they are slow.
FIRST_STRIDE = 4000

Words = NDArray[np.int64]
PLACES = kernel.Run.places()
NO_SECTION = np.zeros(kernel.SECTION_WIDTH, np.int64)


class Part:
    """An array of a motion, cut out of its block at the first look (most are never needed)."""

    def __init__(self, block: str) -> None:
        self.block = block

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    def __get__(self, arrays: MotionArrays, owner: type) -> NDArray[Any]:
        array: NDArray[Any] = getattr(arrays, self.block)[arrays.layout.parts[self.name]]
        arrays.__dict__[self.name] = array
        return array


class MotionArrays:
    """What a motion has of its own; zero but for tolerances, limits and what it begins with.

    Attributes
    ----------
    frame : addresses and lengths, see `kernel.Run`; the arrays follow in the same block
    floats : the block as floats
    address : of the frame
    clock, parameters, y, counters, ... : see `kernel.Run`
    """

    clock = Part("floats")
    parameters = Part("floats")
    coefficients = Part("floats")
    y = Part("floats")
    measures = Part("floats")
    kinds = Part("frame")
    counters = Part("frame")
    limits = Part("frame")

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        self.frame: Words = layout.block.copy()
        self.floats: Vector = self.frame.view(np.float64)
        self.address = address_of(self.frame)

    def show(self, name: str, array: NDArray[Any]) -> None:
        """Show the driver `array` as the frame's `name`; keep it alive meanwhile."""
        place, frame, shape = PLACES[name], self.frame, array.shape
        frame[place] = address_of(array) - (self.address if name in self.layout.parts else 0)
        frame[place + 1] = shape[0]
        if len(shape) == 2:
            frame[place + 2] = shape[1]


@dataclass(frozen=True)
class Layout:
    """What new motions copy.

    Attributes
    ----------
    block : the frame, then the motion's own arrays
    parts : name -> where an array of the motion's own lies in the block
    given : part of the block that holds the parameters proper
    max_sections, n_sections, n_sampled, first_step : places in the block of what every run sets
    shared : the other arrays that the frame shows, kept alive
    """

    block: Words
    parts: Mapping[str, slice]
    given: slice
    max_sections: int
    n_sections: int
    n_sampled: int
    first_step: int
    shared: Mapping[str, NDArray[Any]]


@cache
def layout_of(system: System, solver: SolverSettings) -> Layout:
    """Layout of a system's motions (their scratch arrays are shared: one runs at a time)."""
    own, shared = _own_lengths(system), _shared(system, solver)
    words = kernel.Run.words(shared)
    parts, end = {}, len(words)
    for name, length in own.items():
        place = PLACES[name]
        words[place : place + 2] = end * WORD, length
        parts[name] = slice(end, end + length)
        end += length
    block = np.concatenate([words, np.zeros(end - len(words), np.int64)])
    floats = block.view(np.float64)
    floats[parts["tolerances"]] = solver.rtol, solver.step, BOUND
    floats[parts["parameters"]][-1 - system.n_contacts : -1] = 1.0  # signs of slip
    floats[parts["clock"]][kernel.TASK] = kernel.ENTER
    block[parts["limits"]] = min(solver.max_steps, FIRST_STRIDE), solver.max_events, 0
    return Layout(
        block,
        parts,
        slice(parts["parameters"].start, parts["parameters"].stop - 1 - system.n_contacts),
        parts["limits"].start + kernel.MAX_SECTIONS,
        parts["counters"].start + kernel.SECTIONS,
        parts["counters"].start + kernel.SAMPLED,
        parts["clock"].start + kernel.FIRST_STEP,
        shared,
    )


def _own_lengths(system: System) -> dict[str, int]:
    """Lengths of a motion's own arrays."""
    generated = system.generated
    return {
        "clock": kernel.CLOCK_WIDTH,
        "parameters": len(generated.parameter_names),
        "coefficients": max(generated.n_coefficients, 1),
        "y": len(system.state_names),
        "measures": kernel.MEASURES_WIDTH,
        "tolerances": kernel.TOLERANCES_WIDTH,
        "kinds": system.n_contacts,
        "strips": system.tables.guards.shape[1] + 3,
        "counters": kernel.COUNTERS_WIDTH,
        "limits": kernel.LIMITS_WIDTH,
    }


def _shared(system: System, solver: SolverSettings) -> dict[str, NDArray[Any]]:
    """Tables of the system, scratch, and what stands for arrays that a motion may not need."""
    return {**_tables(system, solver), **_scratch(system), **_not_asked_for(system)}


def _tables(system: System, solver: SolverSettings) -> dict[str, NDArray[Any]]:
    tables, config = system.tables, system.tables.config.copy()
    if solver.method == "rk4":
        config[kernel.METHOD] = kernel.METHOD_RK4
    names = {name: getattr(tables, name) for name in ("table", "impacts", "guards", "ends")}
    return {
        **names,
        "config": config,
        "quadrature": quadratures(system.generated.order, solver.rtol),
    }


def _scratch(system: System) -> dict[str, NDArray[Any]]:
    n, contacts, order = len(system.state_names), system.n_contacts, system.generated.order
    guards = system.tables.guards.shape[1]
    rows = 2 * n + 2 * guards + 2
    width = max(2 * n + guards + 1 + 3 * contacts + kernel.N_ENERGIES, 2 * n, order + 1)
    options = np.zeros((contacts, kernel.OPTIONS_WIDTH), np.int64)
    options[:, kernel.ONE_WAY] = system.generated.smooth
    return {
        "series": np.zeros(rows * (order + 1)),
        "work": np.zeros(rows * (system.generated.tangent_order + 1)),
        "stages": np.zeros((SCRATCH_ROWS, width)),
        "polynomial": np.zeros(order + 1),
        "pieces": roots.scratch(),
        "options": options,
    }


def _not_asked_for(system: System) -> dict[str, NDArray[Any]]:
    n, contacts = len(system.state_names), system.n_contacts
    outputs = kernel.PER_CONTACT * contacts + kernel.N_ENERGIES
    return {
        "reference": np.zeros(len(system.coordinates)),
        "extremes": np.zeros((3, n)),
        "shares": np.zeros((contacts, 3)),
        "section": NO_SECTION,
        "section_times": np.zeros(1),
        "section_states": np.zeros((1, n)),
        "sample_times": np.zeros(0),
        "sample_states": np.zeros((0, n)),
        "sample_outputs": np.zeros((0, outputs)),
        "sample_codes": np.zeros((0, contacts), np.int64),
        "ledger": np.zeros((0, kernel.LEDGER_WIDTH)),
        "tangents": np.zeros((0, n)),
    }


@cache
def quadratures(order: int, rtol: float) -> Vector:
    """Gauss-Lobatto nodes and weights on [0, 1] of rules of 1 to `order` / 2 + 2 nodes.

    The third column is the share of a step that a rule integrates to rounding: a step is as long
    as keeps the last term of the series of an oscillation below `rtol`, and what is integrated
    oscillates FASTEST times as fast. The rule of most nodes takes the rest.

    Returns
    -------
    array, shape (rows, 3)
        The rule of k nodes begins in row k (k - 1) / 2.
    """
    phase = FASTEST * (rtol * math.factorial(order)) ** (1.0 / order)
    rules, most = [np.zeros((1, 3))], order // 2 + 2
    for count in range(2, most + 1):
        nodes, weights = lobatto(count)
        reach = lobatto_reach(count) / phase if count < most else np.inf
        rules.append(np.column_stack([nodes, weights, np.full(count, reach)]))
    return np.concatenate(rules)


def lobatto_reach(count: int) -> float:
    """Phase over which a rule integrates an oscillation to rounding, by its error term, rad."""
    power = 2 * count - 2
    missed = count * (count - 1) ** 3 * math.factorial(count - 2) ** 4
    error = missed / ((power + 1) * math.factorial(power) ** 3)
    return float((ROUNDING / error) ** (1.0 / power))


def lobatto(count: int) -> tuple[Vector, Vector]:
    """Gauss-Lobatto nodes and weights on [0, 1], both ends among the nodes."""
    legendre = np.polynomial.legendre.Legendre.basis(count - 1)
    inner = np.sort(legendre.deriv().roots().real)
    for _ in range(2):
        inner -= legendre.deriv()(inner) / legendre.deriv(2)(inner)
    nodes = np.concatenate([[-1.0], inner, [1.0]])
    weights = 1.0 / (count * (count - 1) * legendre(nodes) ** 2)
    return 0.5 * (nodes + 1.0), weights
