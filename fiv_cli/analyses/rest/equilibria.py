"""Sliding equilibria of the unexcited system: all real ones, and how many are complex.

Where the equations at rest reduce to one polynomial (see ``codegen/statics.py``) every root is
found at once: the real ones are polished on the full equations, the rest are counted, and the set
is complete. Elsewhere Newton's iteration is started from many points, each solution taken out of
the equations once it is found (deflation), and nothing certifies that none is missed.

The first equilibrium is the one that the unloaded system moves to as its loads grow from zero.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache, cached_property

import numpy as np
from numpy.typing import NDArray

from fiv_cli.codegen.memory import call_generated
from fiv_cli.codegen.reduction import Reduction, Statics
from fiv_cli.codegen.statics import Loaded, generate_statics, load_reduction
from fiv_cli.dynamics.arrays import BOUND
from fiv_cli.dynamics.system import FieldOutput, System, Vector

NEWTON_STEPS = 60
CONVERGED = 1e-13  # last Newton step, relative to the solution
# Near a singular stiffness rounding keeps the steps larger: below this, one that no longer shrinks
# to half is the last.
STALLED = 1e-8
SAME_SOLUTION = 1e-8
# A root whose imaginary part is below this share of itself is tried as a real one.
NEARLY_REAL = 1e-3
EXACT = 1e-9  # what is left of the forces at an equilibrium; of those of the thesis 4e-16
COMMON_ROOT = 1e-9  # a numerator below this share of its terms vanishes
LOAD_STEPS = 8  # in which the loads grow from zero
# Newton starts, as multiples of the first solution: other real solutions of the spring forces.
SPREAD = (-30.0, -10.0, -3.0, -1.0, -0.3, 0.3, 3.0, 10.0, 30.0)


@dataclass(frozen=True)
class Sliding:
    """The unexcited system, sliding in the direction that the drive imposes at rest.

    Attributes
    ----------
    system : the compiled system
    parameters : parameter vector with slip signs
    coefficients : generated coefficients
    index : contact state "all slip"
    moving : whether every contact has slip velocity at rest, as a sliding equilibrium needs
    """

    system: System
    parameters: Vector
    coefficients: Vector
    index: int
    moving: bool

    def field(self, y: Vector) -> FieldOutput:
        """Rates, forces and switching functions at y."""
        return self.system.field(self.index, self.coefficients, 0.0, y)

    def rates(self, y: Vector) -> Vector:
        """dy/dt; shape (n_states,)."""
        return self.field(y).rates

    def contact_forces(self, y: Vector) -> NDArray[np.float64]:
        """(F_N, F_T, v_rel) per contact; shape (n_contacts, 3)."""
        return self.field(y).contacts

    def jacobian(self, y: Vector) -> NDArray[np.float64]:
        """Exact derivative of `rates` (by differentiated code); shape (n, n)."""
        return self.slopes(y, range(len(y)))

    def slopes(self, y: Vector, columns: Sequence[int]) -> NDArray[np.float64]:
        """Columns of `jacobian`; shape (n, number of columns)."""
        found = self.system.linearised(self.index, self.coefficients, 0.0, y, columns)
        return np.ascontiguousarray(found[:, :, 1]).T

    @cached_property
    def statics(self) -> Statics:
        """What is known of the system at rest."""
        return statics_of(self.system)

    @property
    def free(self) -> list[int]:
        """See `free_coordinates`."""
        return free_coordinates(self.system)

    @property
    def free_rates(self) -> NDArray[np.intp]:
        """Places of their accelerations among `rates`."""
        return _free_rates(self.system)


@cache
def statics_of(system: System) -> Statics:
    """The statics of a system, derived once per user.

    Its code is loaded, so that no point's time contains it.
    """
    statics = generate_statics(system.setup)
    for reduction in statics.reductions:
        _loaded(reduction)
    return statics


@cache
def free_coordinates(system: System) -> list[int]:
    """Places of the coordinates that no rigid contact determines."""
    determined = statics_of(system).determined
    return [i for i, name in enumerate(system.coordinates) if name not in determined]


@cache
def _free_rates(system: System) -> NDArray[np.intp]:
    return len(system.coordinates) + np.array(free_coordinates(system), np.intp)


def sliding(system: System, parameters: Mapping[str, float]) -> Sliding:
    """The unexcited system in sliding."""
    vector = system.parameter_vector(system.setup.model.unexcited(parameters))
    state = Sliding(system, vector, system.coefficients(vector), 0, True)
    velocities = state.contact_forces(np.zeros(len(system.state_names)))[:, 2]
    moving = bool(((velocities != 0.0) | np.array(system.generated.smooth)).all())
    backwards = velocities < 0.0
    if not backwards.any():
        return Sliding(system, vector, state.coefficients, 0, moving)
    first = len(vector) - 1 - system.n_contacts
    vector[first : first + system.n_contacts] = np.where(backwards, -1.0, 1.0)
    return Sliding(system, vector, system.coefficients(vector), 0, moving)


@dataclass(frozen=True)
class Equilibria:
    """What is known of the sliding equilibria.

    Attributes
    ----------
    states : state vectors (velocities zero) with closed contacts, the one reached by growing
        loads first
    pulling : how many further real solutions need a unilateral contact to pull
    n_complex : how many solutions are not real; None where that is not known
    certified : whether these are all the real solutions there are
    reason : why there is none, a key of the table of reasons; "" when there is one
    """

    states: list[Vector] = field(default_factory=list)
    pulling: int = 0
    n_complex: int | None = None
    certified: bool = False
    reason: str = ""


def equilibria(state: Sliding) -> list[Vector]:
    """Sliding equilibria with closed contacts.

    Each is a state vector with zero velocities; the first is the one that the unloaded system
    moves to as its loads grow. A contact that cannot pull (any but a bilateral one) keeps out the
    solutions with F_N < 0.
    """
    return all_equilibria(state).states


def all_equilibria(state: Sliding) -> Equilibria:
    """Every sliding equilibrium, with what is known of those that are none."""
    if not state.moving:
        return Equilibria(reason="no_drive")
    reduced = (_reduced(state, polynomial) for polynomial in _polynomials(state.system))
    found = next((one for one in reduced if one is not None), None) or _search(state)
    held = [y for y in found.states if _is_held(state, y)]
    if not all(relative_residual(state, y) <= EXACT for y in held):
        return Equilibria(reason="inexact_equilibrium")
    pulling = len(found.states) - len(held)
    reason = "" if held else "contact_would_pull" if pulling else found.reason
    return Equilibria(_in_order(state, held), pulling, found.n_complex, found.certified, reason)


def relative_residual(state: Sliding, y: Vector) -> float:
    """What is left of the equations at `y` over the forces that balance there, the worst of all.

    The forces of an equation: what each displacement contributes, and the loads.
    """
    rows = state.free_rates
    left = np.abs(state.rates(y)[rows])
    forces = np.abs(state.slopes(y, state.free)[rows]) @ np.abs(y[state.free])
    forces += np.abs(state.rates(np.zeros(len(y)))[rows])
    return float(np.max(left / np.where(left > 0.0, forces, 1.0), initial=0.0))


def why_none(state: Sliding) -> str:
    """Key of the reason why there is no sliding equilibrium; "" where there is one."""
    return all_equilibria(state).reason


def _is_held(state: Sliding, y: Vector) -> bool:
    """Whether no unilateral contact has to pull."""
    normal = state.contact_forces(y)[:, 0]
    return bool(np.all((normal >= 0.0) | np.array(state.statics.bilateral)))


# --- by one polynomial ----------------------------------------------------------------------------
@cache
def _loaded(reduction: Reduction) -> Loaded:
    return load_reduction(reduction)


@dataclass(frozen=True, eq=False)
class _Polynomial:
    """A reduction as a point needs it: code that is loaded, and places for names and slots.

    Attributes
    ----------
    arguments : places of its parameters in the parameter vector
    closure, denominator, numerators : places of the coefficients, from s^0 upwards
    """

    reduction: Reduction
    loaded: Loaded
    arguments: NDArray[np.intp]
    closure: NDArray[np.intp]
    denominator: NDArray[np.intp]
    numerators: tuple[NDArray[np.intp], ...]


@cache
def _polynomials(system: System) -> tuple[_Polynomial, ...]:
    """The reductions of a system, in the order in which they are tried."""
    names = system.generated.parameter_names
    return tuple(
        _Polynomial(
            reduction,
            _loaded(reduction),
            np.array([names.index(name) for name in reduction.parameters], np.intp),
            np.array(reduction.closure, np.intp),
            np.array(reduction.denominator, np.intp),
            tuple(np.array(slots, np.intp) for slots in reduction.numerators),
        )
        for reduction in statics_of(system).reductions
    )


def _reduced(state: Sliding, polynomial: _Polynomial) -> Equilibria | None:
    """Every root of the closure that is a real solution of the full equations.

    None where the scalar does not determine the other unknowns at these parameters.
    """
    values = np.zeros(polynomial.reduction.n_slots)
    arguments = state.parameters[polynomial.arguments]
    call_generated(polynomial.loaded.statics, values, 0.0, arguments, values)
    if not values[polynomial.denominator].any() or not np.isfinite(values).all():
        return None
    roots = _roots(values[polynomial.closure])
    nearly = roots[np.abs(roots.imag) <= NEARLY_REAL * np.abs(roots)].real
    found: list[Vector] = []
    for scalar in np.sort(nearly).tolist():
        _keep(found, _newton(state, _inserted(state, polynomial, values, arguments, scalar)))
    missing = len(roots) - len(found)
    certified = missing % 2 == 0 and not _undetermined(polynomial, values)
    n_complex = missing if certified else None
    return Equilibria(found, 0, n_complex, certified, "" if found else _why_none(state))


def _why_none(state: Sliding) -> str:
    """A singular stiffness without load, or nothing known."""
    start = np.zeros(len(state.system.state_names))
    stiffness = state.slopes(start, state.free)[state.free_rates]
    singular = np.linalg.matrix_rank(stiffness) < len(state.free)
    return "singular_equilibrium" if singular else "no_equilibrium"


def _roots(coefficients: Vector) -> NDArray[np.complex128]:
    """Roots of a polynomial given from s^0 upwards: those of `numpy.roots`, sooner."""
    falling = coefficients[::-1]
    if not (falling[0] and falling[-1]):  # it is of a lower degree, or has zero as a root
        return np.roots(falling).astype(complex)
    companion = _shift(len(falling) - 1).copy()
    companion[0] = -falling[1:] / falling[0]
    return np.linalg.eigvals(companion).astype(complex)


@cache
def _shift(size: int) -> NDArray[np.float64]:
    """Ones below the diagonal."""
    return np.eye(size, k=-1)


def _value(coefficients: Vector, at: float) -> float:
    """A polynomial given from s^0 upwards, by Horner's rule."""
    value = 0.0
    for coefficient in reversed(coefficients.tolist()):
        value = value * at + coefficient
    return value


def _inserted(
    state: Sliding, polynomial: _Polynomial, values: Vector, arguments: Vector, scalar: float
) -> Vector:
    """State vector of the solution with this value of the scalar."""
    reduction = polynomial.reduction
    denominator = np.float64(_value(values[polynomial.denominator], scalar))
    known = {reduction.scalar: scalar}
    for name, slots in zip(reduction.unknowns, polynomial.numerators, strict=True):
        known[name] = float(_value(values[slots], scalar) / denominator)
    if reduction.eliminated:
        taken_out = np.zeros(len(reduction.eliminated))
        solved = np.concatenate([arguments, list(known.values())])
        call_generated(polynomial.loaded.eliminated, taken_out, 0.0, solved, taken_out)
        known |= dict(zip(reduction.eliminated, taken_out.tolist(), strict=True))
    return state.system.state_vector(known)


def _undetermined(polynomial: _Polynomial, values: Vector) -> bool:
    """Whether somewhere the scalar leaves the other unknowns free (a bifurcation off the family).

    There the denominator has a real root that is one of every numerator too.
    """
    if len(polynomial.denominator) == 1:
        return False
    roots = _roots(values[polynomial.denominator])
    real = roots[np.abs(roots.imag) <= NEARLY_REAL * np.abs(roots)].real
    return any(
        all(_vanishes(values[slots], float(root)) for slots in polynomial.numerators)
        for root in real
    )


def _vanishes(coefficients: Vector, at: float) -> bool:
    terms = coefficients * at ** np.arange(len(coefficients))
    return bool(abs(np.sum(terms)) <= COMMON_ROOT * np.sum(np.abs(terms)))


# --- by Newton's iteration ------------------------------------------------------------------------
def _search(state: Sliding) -> Equilibria:
    """What deflated Newton iterations find from a fixed set of starts."""
    n = len(state.system.state_names)
    found: list[Vector] = []
    for first in (_loaded_from_zero(state), _newton(state, np.zeros(n))):
        _keep(found, first)
    if found:
        one = state.system.state_vector(dict.fromkeys(state.system.coordinates, 1.0))
        reach = found[0] if np.any(found[0]) else one
        for factor in SPREAD:
            near = _newton(state, factor * reach, found)
            _keep(found, None if near is None else _newton(state, near))
    return Equilibria(found, reason="" if found else _why_none(state))


def _newton(
    state: Sliding, start: Vector, known: Sequence[Vector] = (), kept: Vector | None = None
) -> Vector | None:
    """Root of the accelerations at zero velocity; None when Newton does not converge.

    Parameters
    ----------
    start : state vector
    known : solutions to stay away from
    kept : accelerations that stand on the right side instead of zero, shape (n_states,)
    """
    free, rows = state.free, state.free_rates
    y = state.field(start).state.copy()
    last = np.inf
    for _ in range(NEWTON_STEPS):
        matrix = state.slopes(y, free)[rows]
        rest = state.rates(y) if kept is None else state.rates(y) - kept
        try:
            step = np.linalg.solve(matrix, rest[rows]).astype(float, copy=False)
        except np.linalg.LinAlgError:
            return None
        if known:
            step *= _deflation(step, y[free], [solution[free] for solution in known])
        y[free] -= step
        if not (np.abs(y) < BOUND).all():
            return None
        y = state.field(y).state.copy()
        size = np.abs(step).max() / max(np.abs(y).max(), 1e-300)
        if size <= CONVERGED or (size <= STALLED and size > last / 2.0):
            return y
        last = size
    return None


def _deflation(step: Vector, at: Vector, known: Iterable[Vector]) -> float:
    """Factor on Newton's step for the equations times product(1 + |k|^2 / |y - k|^2) over known k.

    Farrell, Birkisson & Funke, SIAM J. Sci. Comput. 37 (2015) A2026, by Sherman and Morrison.
    """
    slope = 0.0
    for solution in known:
        away = at - solution
        square, size = float(away @ away), float(solution @ solution)
        if square == 0.0:
            return 1.0
        slope += -2.0 * size * float(away @ step) / (square * (square + size))
    return 1.0 / (1.0 + slope) if slope != -1.0 else 1.0


def _keep(found: list[Vector], candidate: Vector | None) -> None:
    """Add a solution unless it is there already."""
    if candidate is not None and _is_new(candidate, found):
        found.append(candidate)


def _is_new(candidate: Vector, found: list[Vector]) -> bool:
    scale = max(np.max(np.abs(candidate), initial=0.0), 1e-300)
    return all(np.max(np.abs(candidate - known)) > SAME_SOLUTION * scale for known in found)


# --- which comes first ----------------------------------------------------------------------------
def _in_order(state: Sliding, found: list[Vector]) -> list[Vector]:
    """First the one that growing loads lead to, then by distance from it."""
    if len(found) < 2:
        return found
    sizes = np.max(np.abs(found), axis=0)
    scaled = np.array(found) / np.where(sizes > 0.0, sizes, 1.0)
    reached = _loaded_from_zero(state)
    origin = 0.0 if reached is None else reached / np.where(sizes > 0.0, sizes, 1.0)
    first = int(np.argmin(np.max(np.abs(scaled - origin), axis=1)))
    away = np.max(np.abs(scaled - scaled[first]), axis=1)
    return [found[i] for i in np.argsort(away, kind="stable")]


def _loaded_from_zero(state: Sliding) -> Vector | None:
    """Where the system at rest without loads goes as they grow; None where that path ends."""
    y: Vector | None = np.zeros(len(state.system.state_names))
    assert y is not None
    unloaded = state.rates(y)
    for share in np.linspace(1.0, 0.0, LOAD_STEPS + 1)[1:]:
        y = _newton(state, y, kept=share * unloaded)
        if y is None:
            return None
    return y
