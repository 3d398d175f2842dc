"""The frames of motions: what each has of its own in one block, what all of a system share.

A motion is made for every point of a sweep, so a new one copies one block, frame included.
"""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from fiv_cli.codegen.codes import ENERGY_OUTPUTS, LANES, NODES, PER_CONTACT
from fiv_cli.codegen.memory import Array
from fiv_cli.dynamics import kernel, roots
from fiv_cli.dynamics.kernel import Run
from fiv_cli.dynamics.settings import SolverSettings
from fiv_cli.dynamics.system import System, Vector

# A state (m, rad, and those per s) beyond this has diverged. Growth in a nonlinear contact ends in
# ever shorter steps, so a bound far above anything mechanical would only cost time.
BOUND = 1e6
ROUNDING = 1e-16
FASTEST = 3.0  # squares and powers, of nonlinear laws too, against the states
KEPT_PIECES = ("pieces_before", "pieces_begun", "pieces_offered")
MOST_OFFERS = 4  # candidates of a contact: stick, slip in both senses, separation

NO_EXTREMES = dict.fromkeys(("reference", "least", "greatest", "squares"), np.zeros(0))
"""What is measured of each state, where only energies are asked for."""

NO_WORKS = np.zeros((0, 0))
"""Where no works are asked for at section points."""

# Steps after which a motion comes back for the first time: 0.2 s where they are slow.
FIRST_STRIDE = 4000


@cache
def blank_frame(system: System, solver: SolverSettings, events: int = 0) -> Run:
    """What a system's new motions copy (their scratch arrays are shared: one runs at a time).

    With room for so many `events`, shared too, it is at hand for short motions one after another.
    What carries tangents is there where it is loaded.
    """
    shown = _tables(system, solver) | _scratch(system) | _not_asked_for(system)
    shown |= vars(system).get("tangent_tables", {}) | (ledger_of(events) if events else {})
    frame = Run.holding(shown, _own_lengths(system))
    for name, number in system.tables.numbers.items():
        setattr(frame, name, number)
    frame.is_taylor = int(solver.method == "taylor")
    frame.rtol, frame.fixed_step, frame.bound = solver.rtol, solver.step, BOUND
    frame.max_steps, frame.max_events = min(solver.max_steps, FIRST_STRIDE), solver.max_events
    frame.max_sections = 1
    frame.task = kernel.ENTER
    end = frame.parts["parameters"].stop - 1
    first = end - system.n_contacts
    frame.place_own("slip_signs", slice(first, end))
    frame.slip_signs[:] = 1.0
    frame.kinds[:] = system.tables.sliding_kinds
    _begin_in_first_pieces(frame, system, first)
    return frame


def _begin_in_first_pieces(frame: Run, system: System, end: int) -> None:
    """Every element of a law in its first piece; their numbers end there in the frame."""
    first = frame.parts["parameters"].start + system.n_own_parameters
    frame.place_own("rows", slice(first, end))
    frame.rows[:] = system.pieces.first_rows
    frame.in_piece[:] = system.pieces.begun_in


def _own_lengths(system: System) -> dict[str, int]:
    """Lengths of a motion's own arrays."""
    return {
        "parameters": len(system.generated.parameter_names),
        "coefficients": max(system.generated.n_coefficients, 1),
        "y": len(system.state_names),
        "kinds": system.n_contacts,
        "in_piece": len(system.pieces.begun_in),
        "known_zeros": system.tables.guard_kinds.shape[1],
    }


def _tables(system: System, solver: SolverSettings) -> dict[str, Array]:
    return {
        **system.tables.arrays(),
        **system.pieces.tables(system.state_names),
        "quadrature": quadratures(system.generated.order, solver.rtol),
        "work_rule": work_rule(system.generated.order),
    }


def _scratch(system: System) -> dict[str, Array]:
    n, contacts, order = len(system.state_names), system.n_contacts, system.generated.order
    guards = system.tables.guard_kinds.shape[1]
    rows = 2 * n + 2 * guards + 2
    width = system.outputs_width
    vectors = (
        "outputs", "reached", "inner", "begun", "between", "joined", "rates_before", "delays",
        "at_rest",
    )  # fmt: skip
    return {
        "series": np.zeros(max(rows * (order + 1), system.generated.n_followed)),
        "work": np.zeros(max(rows * (order + 1), system.generated.n_followed)),
        "lanes": np.zeros(n * (system.generated.tangent_order + 1) * LANES),
        **{name: np.zeros(max(width, 2 * n)) for name in vectors},
        "nodes": np.zeros((2, width * NODES)),
        **roots.scratch(order),
        "slip_velocities": np.zeros(contacts),
        "greatest_slip": system.greatest_slip,
        **{
            name: np.zeros(contacts, np.int64) for name in ("code_before", "is_at_rest", "n_offers")
        },
        **{name: np.zeros(len(system.pieces.begun_in), np.int64) for name in KEPT_PIECES},
        "offered_kinds": np.zeros((contacts, MOST_OFFERS), np.int64),
        "offered_signs": np.zeros((contacts, MOST_OFFERS), np.int64),
    }


def _not_asked_for(system: System) -> dict[str, Array]:
    """What stands for arrays that a motion may not need."""
    n, contacts = len(system.state_names), system.n_contacts
    return {
        **NO_EXTREMES,
        "shares": np.zeros((contacts, 3)),
        "works": np.zeros(len(system.setup.model.powers)),
        "section_times": np.zeros(1),
        "section_states": np.zeros((1, n)),
        "section_works": NO_WORKS,
        "sample_times": np.zeros(0),
        "sample_states": np.zeros((0, n)),
        "sample_outputs": np.zeros((0, sample_width(system))),
        "sample_codes": np.zeros((0, contacts), np.int64),
        **ledger_of(0),
        "tangents": np.zeros((0, n)),
    }


def extremes_of(reference: Vector, n: int) -> dict[str, Array]:
    """What is measured of each of `n` states, before anything is."""
    known, least, greatest = np.array(reference, dtype=float), np.empty(n), np.empty(n)
    least.fill(np.inf)
    greatest.fill(-np.inf)
    return dict(zip(NO_EXTREMES, (known, least, greatest, np.zeros(n)), strict=True))


def sample_width(system: System) -> int:
    """Numbers of a sample besides the state: of contacts, what they store, energies."""
    return PER_CONTACT * system.n_contacts + system.generated.n_stored + len(ENERGY_OUTPUTS)


def ledger_of(rows: int) -> dict[str, Array]:
    """Room for so many events."""
    numbers = ("before", "after", "contacts")
    return {
        **{f"ledger_{name}": np.zeros(rows) for name in ("times", "residuals")},
        **{f"ledger_{name}": np.zeros(rows, np.int64) for name in numbers},
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


@cache
def work_rule(order: int) -> Array:
    """Gauss nodes and weights on [0, 1] that integrate a series of this order.

    Returns
    -------
    array, shape (2, a multiple of NODES)
        The first row are nodes; those that fill up have no weight.
    """
    count = order // 2 + 1
    nodes, weights = np.polynomial.legendre.leggauss(count)
    rule = np.zeros((2, -(-count // NODES) * NODES))
    rule[0, :count], rule[1, :count] = 0.5 * (nodes + 1.0), 0.5 * weights
    return rule


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
