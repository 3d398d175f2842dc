"""Sliding equilibria of the unexcited system: all real ones, and how many are complex.

Where the equations at rest reduce to one polynomial (see ``codegen/statics.py``) every root is
found at once: the real ones are polished on the full equations, the rest are counted, and the set
is complete. Elsewhere Newton's iteration is started from many points, each solution taken out of
the equations once it is found (deflation), and nothing certifies that none is missed.

The first equilibrium is the one that the unloaded system moves to as its loads grow from zero.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from fiv_cli.codegen.codes import GAP
from fiv_cli.codegen.reduction import Reduction, Statics
from fiv_cli.codegen.statics import Loaded, generate_statics, load_reduction
from fiv_cli.dynamics.rows import call_rows
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
PROBE = 1e-4  # relative change of a parameter that shows what it contributes
COMMON_ROOT = 1e-9  # a numerator below this share of its terms vanishes
LOAD_STEPS = 8  # in which the loads grow from zero
# Newton starts, as multiples of the first solution: other real solutions of the spring forces.
SPREAD = (-30.0, -10.0, -3.0, -1.0, -0.3, 0.3, 3.0, 10.0, 30.0)


@dataclass(frozen=True)
class Sliding:
    """The unexcited system, sliding in the direction that the drive imposes at rest.

    At one point or, in rows, at several: what it is asked of a state it answers of each row.

    Attributes
    ----------
    system : the compiled system
    parameters : parameter vector with slip signs; shape (..., n_parameters)
    coefficients : generated coefficients; shape (..., n_coefficients)
    index : contact state "all slip", stops open
    moving : whether every contact has slip velocity at rest, as a sliding equilibrium needs
    held : whether none has, and friction is that of springs, which stand upright at one
    """

    system: System
    parameters: Vector
    coefficients: Vector
    index: int
    moving: NDArray[np.bool_]
    held: NDArray[np.bool_]

    def __getitem__(self, rows: Any) -> Sliding:
        """At some of the points."""
        taken = self.parameters[rows], self.coefficients[rows], self.index
        return type(self)(self.system, *taken, self.moving[rows], self.held[rows])

    def field(self, y: Vector) -> FieldOutput:
        """Rates, forces and switching functions at y."""
        return self.system.field(self.index, self.coefficients, 0.0, y)

    def rates(self, y: Vector) -> Vector:
        """dy/dt; shape (..., n_states)."""
        return self.field(y).rates

    def contact_forces(self, y: Vector) -> NDArray[np.float64]:
        """(F_N, F_T, v_rel) per contact; shape (..., n_contacts, 3)."""
        return self.field(y).contacts

    def jacobian(self, y: Vector) -> NDArray[np.float64]:
        """Exact derivative of `rates` (by differentiated code); shape (..., n, n)."""
        return self.slopes(y, range(y.shape[-1]))

    def slopes(self, y: Vector, columns: Sequence[int]) -> NDArray[np.float64]:
        """Columns of `jacobian`; shape (..., n, number of columns)."""
        found = self.system.linearised(self.index, self.coefficients, 0.0, y, columns)
        return np.ascontiguousarray(found[..., 1]).swapaxes(-1, -2)

    @property
    def slip_signs(self) -> NDArray[np.float64]:
        """Of the contacts, 0 where one may stand still; shape (..., n_contacts)."""
        signs = self.parameters[..., self._first_sign : -1]
        return np.where(_may_stand_still(self.system), 0.0, signs)

    @property
    def pieces(self) -> NDArray[np.float64]:
        """Numbers of the pieces of laws that these rest in; shape (..., n_pieces)."""
        return self.parameters[..., self.system.n_own_parameters : self._first_sign]

    @property
    def _first_sign(self) -> int:
        return self.parameters.shape[-1] - 1 - self.system.n_contacts

    @cached_property
    def statics(self) -> Statics:
        """What is known of the system at rest."""
        return statics_of(self.system)

    @property
    def free(self) -> list[int]:
        """Places of what an equilibrium has: see `free_coordinates`, then the states of laws."""
        return _free(self.system)

    @property
    def free_rates(self) -> NDArray[np.intp]:
        """Places of their accelerations, and of the laws' rates, among `rates`."""
        return _free_rates(self.system)


class Upright(Sliding):
    """The same with the states of laws kept at zero."""

    @property
    def free(self) -> list[int]:
        """Places of coordinates alone."""
        return free_coordinates(self.system)

    @property
    def free_rates(self) -> NDArray[np.intp]:
        """Places of their accelerations."""
        return np.array(self.free, np.intp) + len(self.system.coordinates)


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
def _free(system: System) -> list[int]:
    return [*free_coordinates(system), *_internal(system)]


@cache
def _free_rates(system: System) -> NDArray[np.intp]:
    accelerations = [len(system.coordinates) + place for place in free_coordinates(system)]
    return np.array([*accelerations, *_internal(system)], np.intp)


def _internal(system: System) -> range:
    """Places of the states of the friction law."""
    return range(len(system.motions), len(system.state_names))


def sliding(system: System, parameters: Mapping[str, float]) -> Sliding:
    """The unexcited system in sliding."""
    return sliding_at(system, [parameters])[0]


def sliding_at(system: System, points: Sequence[Mapping[str, float]]) -> Sliding:
    """The same at several points, in rows."""
    unexcited = system.setup.model.unexcited
    vectors = system.parameter_vectors([unexcited(point) for point in points])
    coefficients = system.coefficients(vectors)
    index = system.sliding_index
    none = np.zeros(len(points), bool)
    state = Sliding(system, vectors, coefficients, index, ~none, none)
    at_rest = np.zeros((len(points), len(system.state_names)))
    velocities = state.contact_forces(at_rest)[..., 2]
    moving = ((velocities != 0.0) | _may_stand_still(system)).all(axis=-1)
    if system.pieces.laws or (velocities < 0.0).any():
        first = state._first_sign
        vectors[:, first:-1] = np.where(velocities < 0.0, -1.0, 1.0)
        slips = velocities.tolist()
        rows = [_rows(system, *point) for point in zip(slips, points, strict=True)]
        vectors[:, system.n_own_parameters : first] = rows
        coefficients = system.coefficients(vectors)
    state = Sliding(system, vectors, coefficients, index, moving, none)
    if moving.all():
        return state
    return replace(state, held=(velocities == 0.0).all(axis=-1) & ~moving & _are_springs(state))


def _may_stand_still(system: System) -> NDArray[np.bool_]:
    """Which contacts may: their laws have no border at zero slip; shape (n_contacts,)."""
    still = np.array(system.generated.smooth)
    still[[contact for contact, law in system.pieces.laws.items() if law.states]] = False
    return still


def _are_springs(state: Sliding) -> NDArray[np.bool_]:
    """Whether the states of laws move with the slip alone where they stand upright."""
    places = list(_internal(state.system))
    upright = np.zeros((len(state.moving), len(state.system.state_names)))
    if not places:
        return np.zeros(len(upright), bool)
    own = state.slopes(upright, places)[:, places]
    moved = np.any(state.rates(upright)[:, places], axis=-1) | np.any(own, axis=(1, 2))
    return np.asarray(~moved)


def slip_at_rest(system: System, parameters: Mapping[str, float]) -> float:
    """How fast contacts with a law by pieces slip where nothing but the drive moves, m/s."""
    forces = sliding(system, parameters).contact_forces(np.zeros(len(system.state_names)))
    return float(np.abs(forces[list(system.pieces.laws), 2]).max())


def _rows(system: System, velocities: Sequence[float], point: Mapping[str, float]) -> list[float]:
    """The numbers of the pieces in which every contact rests while it slides so."""
    rows: list[tuple[float, ...]] = []
    for contact, law in system.pieces.laws.items():
        rows += law.rows_at(velocities[contact], system.told_to_law(contact, point))
    return system.pieces.numbers(rows)


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
    (found,) = equilibria_at(state[None])
    return found


Found = TypeVar("Found")


def equilibria_at(points: Sliding) -> list[Equilibria]:
    """`all_equilibria` at each of several points."""
    found = [Equilibria(reason="no_drive")] * len(points.moving)
    held, left = np.flatnonzero(points.held), np.flatnonzero(points.moving)
    if len(held) > 0:
        upright = Upright(**vars(points[held]))
        _enter(found, held, _search(upright))
    if not all(law.rests for law in points.system.pieces.laws.values()):
        _enter(found, left, [Equilibria(reason="no_equilibrium")] * len(left))
        return _held(points, found)
    for polynomial in _polynomials(points.system):
        if len(left) > 0:
            left = _enter(found, left, _reduced(points[left], polynomial))
    if len(left) > 0:
        _enter(found, left, _search(points[left]))
    return _held(points, found)


def _enter(
    found: list[Found], rows: NDArray[np.intp], given: Sequence[Found | None]
) -> NDArray[np.intp]:
    """Put what is given of some rows in its place; the rows of which nothing is."""
    for row, one in zip(rows.tolist(), given, strict=True):
        if one is not None:
            found[row] = one
    return rows[[one is None for one in given]]


def _held(points: Sliding, found: Sequence[Equilibria]) -> list[Equilibria]:
    """What is left of all solutions where contacts may not pull, in order."""
    owners = np.repeat(np.arange(len(found)), [len(one.states) for one in found])
    n = len(points.system.state_names)
    states = np.array([y for one in found for y in one.states]).reshape(-1, n)
    at = points[owners]
    held, exact = _is_held(at, states), relative_residual(at, states) <= EXACT
    left = list(found)
    for row in set(owners[~(held & exact)].tolist()):
        left[row] = _without_pulling(found[row], held[owners == row], exact[owners == row])
    several = [row for row, one in enumerate(left) if len(one.states) > 1]
    reached = _loaded_from_zero(points[several]) if several else ()
    for row, first in zip(several, reached, strict=True):
        left[row] = replace(left[row], states=_in_order(left[row].states, first))
    return left


def _without_pulling(
    found: Equilibria, held: NDArray[np.bool_], exact: NDArray[np.bool_]
) -> Equilibria:
    """The solutions of a point in which no contact has to pull."""
    if not exact[held].all():
        return Equilibria(reason="inexact_equilibrium")
    states = [y for y, is_held in zip(found.states, held.tolist(), strict=True) if is_held]
    pulling = len(found.states) - len(states)
    reason = "" if states else "contact_would_pull" if pulling else found.reason
    return replace(found, states=states, pulling=pulling, reason=reason)


def relative_residual(state: Sliding, y: Vector) -> NDArray[np.float64]:
    """What is left of the equations at `y` over the forces that balance there, the worst of all.

    The forces of an equation: what each displacement contributes, and the loads. What a
    displacement contributes may itself be a difference that vanishes (at mu_k = 0.6 in
    Figure 6.22): then also what each parameter contributes, which is dearer to ask.
    """
    rows = state.free_rates
    left = np.abs(state.rates(y)[..., rows])
    away = np.abs(y[..., state.free, None])
    forces = (np.abs(state.slopes(y, state.free)[..., rows, :]) @ away)[..., 0]
    forces += np.abs(state.rates(np.zeros(y.shape))[..., rows])
    worst = _worst_share(left, forces)
    if (worst > EXACT).any():
        worst = np.minimum(worst, _worst_share(left, forces + _of_parameters(state, y)[..., rows]))
    return worst


def _worst_share(left: Vector, forces: Vector) -> NDArray[np.float64]:
    share = left / np.where(left > 0.0, forces, 1.0)
    return np.asarray(np.max(share, axis=-1, initial=0.0))


def _of_parameters(state: Sliding, y: Vector) -> Vector:
    """The sum of what each parameter contributes to the rates at `y`; shape (..., n_states)."""
    own = np.arange(state.system.n_own_parameters)
    changed = np.repeat(state.parameters[..., None, :], len(own), axis=-2)
    changed[..., own, own] *= 1.0 + PROBE
    others = replace(state, parameters=changed, coefficients=state.system.coefficients(changed))
    alone = others.rates(np.repeat(y[..., None, :], len(own), axis=-2))
    return np.asarray(np.abs(alone - state.rates(y)[..., None, :]).sum(axis=-2) / PROBE)


def why_none(state: Sliding) -> str:
    """Key of the reason why there is no sliding equilibrium; "" where there is one."""
    return all_equilibria(state).reason


def _is_held(points: Sliding, y: Vector) -> NDArray[np.bool_]:
    """Whether no unilateral contact has to pull and no stop to give way, at each point."""
    field, tables = points.field(y), points.system.tables
    closed = (field.contacts[..., 0] >= 0.0) | np.array(points.statics.bilateral)
    kinds = tables.guard_kinds[points.index, : tables.n_guards[points.index]]
    held: NDArray[np.bool_] = closed.all(axis=-1)
    return held & (field.switching[..., kinds == GAP] >= 0.0).all(axis=-1)


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


def _reduced(points: Sliding, polynomial: _Polynomial) -> list[Equilibria | None]:
    """Every root of the closure that is a real solution of the full equations, at each point.

    None where the scalar does not determine the other unknowns at these parameters.
    """
    values = np.zeros((len(points.moving), polynomial.reduction.n_slots))
    arguments = np.ascontiguousarray(points.parameters[:, polynomial.arguments])
    call_rows(polynomial.loaded.statics, values, 0.0, arguments, values)
    told = values[:, polynomial.denominator].any(axis=1) & np.isfinite(values).all(axis=1)
    reduced: list[Equilibria | None] = [None] * len(values)
    rows = np.flatnonzero(told)
    if len(rows) > 0:
        _enter(reduced, rows, _solved_for(points[rows], polynomial, values[rows], arguments[rows]))
    return reduced


def _solved_for(
    points: Sliding, polynomial: _Polynomial, values: Vector, arguments: Vector
) -> list[Equilibria]:
    """The solutions where the scalar determines the other unknowns."""
    roots = _roots(values[:, polynomial.closure])
    nearly = np.abs(roots.imag) <= NEARLY_REAL * np.abs(roots)
    scalars = np.sort(np.where(nearly, roots.real, np.nan), axis=1)
    owners, places = np.nonzero(np.isfinite(scalars))
    at = scalars[owners, places]
    starts = _inserted(points.system, polynomial, values[owners], arguments[owners], at)
    found: list[list[Vector]] = [[] for _ in roots]
    solutions = _polished(points[owners], starts, np.isin(at, roots.real[roots.imag == 0.0]))
    real = np.isfinite(solutions).all(axis=1)
    for owner, solution in zip(owners[real].tolist(), solutions[real], strict=True):
        if not found[owner] or _is_new(solution, found[owner]):
            found[owner].append(solution)
    missing = np.isfinite(roots).sum(axis=1) - [len(solutions) for solutions in found]
    return [
        _counted(points, polynomial, values, row, solutions, count)
        for row, (solutions, count) in enumerate(zip(found, missing.tolist(), strict=True))
    ]


def _polished(points: Sliding, starts: Vector, real: NDArray[np.bool_]) -> Vector:
    """The solutions nearby; NaN where there is none.

    On the way to infinity, where the stiffness turns singular, Newton's steps are all rounding long
    before the `real` roots are, which still solve the equations.
    """
    solutions = _newton(points, starts)
    lost = ~np.isfinite(solutions).all(axis=1) & np.isfinite(starts).all(axis=1)
    rows = np.flatnonzero(lost & real)
    if len(rows) > 0:
        at, given = points[rows], points[rows].field(starts[rows]).state.copy()
        solve = (relative_residual(at, given) <= CONVERGED) & ~_is_singular(at, given)
        solutions[rows[solve]] = given[solve]
    return solutions


def _counted(
    points: Sliding,
    polynomial: _Polynomial,
    values: Vector,
    row: int,
    found: list[Vector],
    missing: int,
) -> Equilibria:
    """The solutions of a point, and whether the missing ones are known to be complex."""
    certified = missing % 2 == 0 and not _undetermined(polynomial, values[row])
    n_complex = missing if certified else None
    reason = "" if found else _why_none(points[row : row + 1])
    return Equilibria(found, 0, n_complex, certified, reason)


def _why_none(point: Sliding) -> str:
    """A singular stiffness without load, or nothing known."""
    unloaded = np.zeros((1, len(point.system.state_names)))
    return "singular_equilibrium" if _is_singular(point, unloaded).all() else "no_equilibrium"


def _is_singular(points: Sliding, y: Vector) -> NDArray[np.bool_]:
    """Whether the stiffness at `y` is, to rounding, in whatever units its entries are."""
    stiffness = points.slopes(y, points.free)[:, points.free_rates]
    for axis in (2, 1):
        largest = np.abs(stiffness).max(axis=axis, keepdims=True, initial=0.0)
        stiffness = stiffness / np.where(largest > 0.0, largest, 1.0)
    return np.asarray(np.linalg.matrix_rank(stiffness) < len(points.free))


def _roots(coefficients: Vector) -> NDArray[np.complex128]:
    """Roots of each polynomial given from s^0 upwards: those of `numpy.roots`, sooner.

    Parameters
    ----------
    coefficients : shape (polynomials, degree + 1)

    Returns
    -------
    (polynomials, degree): NaN behind those of a polynomial of a lower degree
    """
    falling = coefficients[:, ::-1]
    degree = falling.shape[1] - 1
    roots = np.full((len(falling), degree), np.nan, complex)
    some = falling != 0.0
    spans = np.column_stack([some.argmax(axis=1), degree - some[:, ::-1].argmax(axis=1)])
    for first, last in set(map(tuple, spans.tolist())):  # of lower degrees, with zero as a root
        rows = np.flatnonzero((spans == (first, last)).all(axis=1) & some.any(axis=1))
        companions = np.tile(_shift(last - first), (len(rows), 1, 1))
        if last > first:
            own = falling[rows, first : last + 1]
            companions[:, 0] = -own[:, 1:] / own[:, :1]
        roots[rows, : last - first] = np.linalg.eigvals(companions)
        roots[rows, last - first : degree - first] = 0.0
    return roots


@cache
def _shift(size: int) -> NDArray[np.float64]:
    """Ones below the diagonal."""
    return np.eye(size, k=-1)


def _value(coefficients: Vector, at: Vector) -> Vector:
    """Polynomials given from s^0 upwards, each at a place of its own, by Horner's rule."""
    value = np.zeros(len(at))
    for coefficient in coefficients.T[::-1]:
        value = value * at + coefficient
    return value


def _inserted(
    system: System, polynomial: _Polynomial, values: Vector, arguments: Vector, scalars: Vector
) -> Vector:
    """State vectors of the solutions with these values of the scalar."""
    reduction = polynomial.reduction
    denominator = _value(values[:, polynomial.denominator], scalars)
    known = {reduction.scalar: scalars}
    for name, slots in zip(reduction.unknowns, polynomial.numerators, strict=True):
        known[name] = _value(values[:, slots], scalars) / denominator
    if reduction.eliminated:
        taken_out = np.zeros((len(scalars), len(reduction.eliminated)))
        solved = np.column_stack([arguments, *known.values()])
        call_rows(polynomial.loaded.eliminated, taken_out, 0.0, solved, taken_out)
        known |= dict(zip(reduction.eliminated, taken_out.T, strict=True))
    vectors = np.zeros((len(scalars), len(system.state_names)))
    for name in known.keys() & system.places.keys():
        vectors[:, system.places[name]] = known[name]
    return vectors


def _undetermined(polynomial: _Polynomial, values: Vector) -> bool:
    """Whether somewhere the scalar leaves the other unknowns free (a bifurcation off the family).

    There the denominator has a real root that is one of every numerator too.
    """
    if len(polynomial.denominator) == 1:
        return False
    (roots,) = _roots(values[None, polynomial.denominator])
    real = roots[np.abs(roots.imag) <= NEARLY_REAL * np.abs(roots)].real
    return any(
        all(_vanishes(values[slots], float(root)) for slots in polynomial.numerators)
        for root in real
    )


def _vanishes(coefficients: Vector, at: float) -> bool:
    terms = coefficients * at ** np.arange(len(coefficients))
    return bool(abs(np.sum(terms)) <= COMMON_ROOT * np.sum(np.abs(terms)))


# --- by Newton's iteration ------------------------------------------------------------------------
def _search(points: Sliding) -> list[Equilibria]:
    """What deflated Newton iterations find from a fixed set of starts, at each point."""
    found: list[list[Vector]] = [[] for _ in points.moving]
    origin = np.zeros((len(found), len(points.system.state_names)))
    for first in (_loaded_from_zero(points), _newton(points, origin)):
        _keep_each(found, first)
    rows = [row for row, solutions in enumerate(found) if solutions]
    one = points.system.state_vector(dict.fromkeys(points.system.coordinates, 1.0))
    reach = [found[row][0] if np.any(found[row][0]) else one for row in rows]
    at, known = points[rows], [found[row] for row in rows]
    for factor in SPREAD if rows else ():
        _keep_each(known, _newton(at, _newton(at, factor * np.array(reach), known)))
    return [
        Equilibria(solutions, reason="" if solutions else _why_none(points[row : row + 1]))
        for row, solutions in enumerate(found)
    ]


def _newton(
    points: Sliding,
    starts: Vector,
    known: Sequence[Sequence[Vector]] = (),
    kept: Vector | None = None,
) -> Vector:
    """Root of the accelerations at zero velocity at each point; NaN where Newton finds none.

    Parameters
    ----------
    starts : state vectors, shape (points, n_states)
    known : per point, solutions to stay away from
    kept : accelerations that stand on the right side instead of zero, shape (points, n_states)
    """
    free, rows = points.free, points.free_rates
    y = points.field(starts).state.copy()
    found, at = np.full(y.shape, np.nan), np.arange(len(y))
    kept, last = np.zeros(y.shape) if kept is None else kept, np.full(len(y), np.inf)
    for _ in range(NEWTON_STEPS):
        step = _solved(points.slopes(y, free)[:, rows], (points.rates(y) - kept)[:, rows])
        for row, place in enumerate(at.tolist() if known else ()):
            step[row] *= _deflation(step[row], y[row, free], [one[free] for one in known[place]])
        y[:, free] -= step
        bounded = np.isfinite(y).all(axis=1)
        y = points.field(y).state.copy()
        size = np.abs(step).max(axis=1) / np.maximum(np.abs(y).max(axis=1), 1e-300)
        ended = (size <= CONVERGED) | ((size <= STALLED) & (size > last / 2.0))
        found[at[bounded & ended]] = y[bounded & ended]
        last, left = size, bounded & ~ended
        if not left.any():
            break
        if not left.all():
            points, at, y, kept, last = points[left], at[left], y[left], kept[left], last[left]
    return found


def _solved(matrices: NDArray[np.float64], right: Vector) -> Vector:
    """Solutions of linear systems; NaN of the singular ones."""
    with suppress(np.linalg.LinAlgError):
        return np.linalg.solve(matrices, right[..., None])[..., 0].astype(float, copy=False)
    if len(right) == 1:
        return np.full(right.shape, np.nan)
    alone = [_solved(matrices[row : row + 1], right[row : row + 1]) for row in range(len(right))]
    return np.concatenate(alone)


def _deflation(step: Vector, at: Vector, known: Iterable[Vector]) -> float:
    """Factor on Newton's step for the equations times product(1 + |k|^2 / |y - k|^2) over known k.

    Farrell, Birkisson & Funke, SIAM J. Sci. Comput. 37 (2015) A2026, by Sherman and Morrison.
    """
    slope = 0.0
    for solution in known:
        away = at - solution
        square, size = float(away @ away), float(solution @ solution)
        scale = square * (square + size)
        if scale == 0.0:
            return 1.0
        slope += -2.0 * size * float(away @ step) / scale
    return 1.0 / (1.0 + slope) if slope != -1.0 else 1.0


def _keep_each(found: Sequence[list[Vector]], candidates: Vector) -> None:
    """`_keep` at each point."""
    for solutions, candidate in zip(found, candidates, strict=True):
        _keep(solutions, candidate)


def _keep(found: list[Vector], candidate: Vector) -> None:
    """Add a solution (NaN: none) unless it is there already."""
    if np.isfinite(candidate).all() and _is_new(candidate, found):
        found.append(candidate)


def _is_new(candidate: Vector, found: list[Vector]) -> bool:
    return all(
        np.max(np.abs(candidate - known)) > SAME_SOLUTION * max(np.max(np.abs(candidate)), 1e-300)
        for known in found
    )


# --- which comes first ----------------------------------------------------------------------------
def _in_order(found: list[Vector], reached: Vector) -> list[Vector]:
    """First the one that growing loads lead to (NaN: that path ends), then by distance from it."""
    sizes = np.max(np.abs(found), axis=0)
    sizes[sizes == 0.0] = 1.0
    scaled, origin = np.array(found) / sizes, np.nan_to_num(reached) / sizes
    first = int(np.argmin(np.max(np.abs(scaled - origin), axis=1)))
    away = np.max(np.abs(scaled - scaled[first]), axis=1)
    return [found[i] for i in np.argsort(away, kind="stable")]


def _loaded_from_zero(points: Sliding) -> Vector:
    """Where each system at rest without loads goes as they grow; NaN where that path ends."""
    y = np.zeros((len(points.moving), len(points.system.state_names)))
    unloaded = points.rates(y)
    for share in np.linspace(1.0, 0.0, LOAD_STEPS + 1)[1:]:
        y = _newton(points, y, kept=share * unloaded)
    return y
